"""MCAP: a log of a motion in its scene, in messages of ROS 2."""

import io
from collections.abc import Iterator
from typing import Any

from planning.domain.geometry.pose import Pose
from planning.domain.scene.geometry import SceneMotion
from service.plans.exports.exported_motion import ExportedMotion
from service.plans.exports.joint_trajectory import duration_of, joint_trajectory
from service.plans.exports.markers import WORLD, markers, quaternion, vector
from service.plans.exports.ros_definitions import definition

# Messages by topic.
TOPICS = {
    "/joint_trajectory": "trajectory_msgs/JointTrajectory",
    "/joint_states": "sensor_msgs/JointState",
    "/tf_static": "tf2_msgs/TFMessage",
    "/tf": "tf2_msgs/TFMessage",
    "/markers": "visualization_msgs/MarkerArray",
}


def to_bag(motion: ExportedMotion) -> bytes:
    """Return the log; the motion begins at time zero, when all that stays is written."""
    from mcap_ros2.writer import Writer  # noqa: PLC0415  (of the extra `mcap`)

    file = io.BytesIO()
    with Writer(file) as log:
        schemas = {
            name: log.register_msgdef(name.replace("/", "/msg/"), definition(name))
            for name in dict.fromkeys(TOPICS.values())
        }
        for topic, stamp, message in _messages(motion):
            instant = stamp["sec"] * 10**9 + stamp["nanosec"]
            log.write_message(
                topic, schemas[TOPICS[topic]], message, log_time=instant, publish_time=instant
            )
    return file.getvalue()


def _messages(motion: ExportedMotion) -> Iterator[tuple[str, dict[str, int], dict[str, Any]]]:
    """Yield topic, time and content of each message, in order of time."""
    whole, begin = joint_trajectory(motion.samples), duration_of(0.0)
    yield "/joint_trajectory", begin, whole
    if motion.scene is not None:
        fixed = [_transform(begin, name, pose) for name, pose in motion.scene.fixed.items()]
        yield "/tf_static", begin, {"transforms": fixed}
        yield "/markers", begin, {"markers": markers(motion.scene)}
    for row, point in enumerate(whole["points"]):
        stamp = point["time_from_start"]
        state = {
            "header": {"stamp": stamp, "frame_id": ""},
            "name": motion.samples.joint_names,
            "position": point["positions"],
            "velocity": point["velocities"],
            "effort": [],
        }
        yield "/joint_states", stamp, state
        if motion.scene is not None:
            yield "/tf", stamp, {"transforms": _moved(motion.scene, row, stamp)}


def _moved(scene: SceneMotion, row: int, stamp: dict[str, int]) -> list[dict[str, Any]]:
    return [
        _transform(stamp, name, Pose.from_matrix(rows[row])) for name, rows in scene.moving.items()
    ]


def _transform(stamp: dict[str, int], name: str, pose: Pose) -> dict[str, Any]:
    """Return X_WF of a frame as a transform."""
    return {
        "header": {"stamp": stamp, "frame_id": WORLD},
        "child_frame_id": name,
        "transform": {
            "translation": vector(pose.position),
            "rotation": quaternion(pose.quaternion),
        },
    }
