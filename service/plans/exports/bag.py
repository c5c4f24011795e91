"""MCAP: joint states over time and the trajectory as one message, as ROS 2 has them."""

import io

from service.plans.exports.joint_trajectory import joint_trajectory
from service.plans.models.trajectory import Trajectory

_SEPARATOR = "=" * 80
_HEADER = f"""\
{_SEPARATOR}
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
{_SEPARATOR}
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""
_JOINT_STATE = f"""\
std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
{_HEADER}"""
_JOINT_TRAJECTORY = f"""\
std_msgs/Header header
string[] joint_names
trajectory_msgs/JointTrajectoryPoint[] points
{_SEPARATOR}
MSG: trajectory_msgs/JointTrajectoryPoint
float64[] positions
float64[] velocities
float64[] accelerations
float64[] effort
builtin_interfaces/Duration time_from_start
{_SEPARATOR}
MSG: builtin_interfaces/Duration
int32 sec
uint32 nanosec
{_HEADER}"""


def to_bag(motion: Trajectory) -> bytes:
    """Return the log; the motion begins at time zero."""
    from mcap_ros2.writer import Writer  # noqa: PLC0415  (of the extra `mcap`)

    file = io.BytesIO()
    with Writer(file) as log:
        whole = log.register_msgdef("trajectory_msgs/msg/JointTrajectory", _JOINT_TRAJECTORY)
        state = log.register_msgdef("sensor_msgs/msg/JointState", _JOINT_STATE)
        message = joint_trajectory(motion)
        log.write_message("/joint_trajectory", whole, message, log_time=0, publish_time=0)
        for point in message["points"]:
            at = point["time_from_start"]
            instant = at["sec"] * 10**9 + at["nanosec"]
            told = {
                "header": {"stamp": at, "frame_id": ""},
                "name": motion.joint_names,
                "position": point["positions"],
                "velocity": point["velocities"],
                "effort": [],
            }
            log.write_message("/joint_states", state, told, log_time=instant, publish_time=instant)
    return file.getvalue()
