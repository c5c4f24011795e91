"""trajectory_msgs/msg/JointTrajectory, as JSON."""

import json
from typing import Any

from service.plans.models.trajectory import Trajectory


def _message(**fields: Any) -> dict[str, Any]:
    """Return the JSON schema of a message with some fields, all of which it has."""
    return {
        "type": "object",
        "properties": fields,
        "required": list(fields),
        "additionalProperties": False,
    }


def _array(items: dict[str, Any]) -> dict[str, Any]:
    return {"type": "array", "items": items}


_INTEGER, _NUMBERS = {"type": "integer"}, _array({"type": "number"})
_TIME = _message(sec=_INTEGER, nanosec=_INTEGER)
# Of what `to_joint_trajectory` writes (JSON Schema 2020-12).
SCHEMA = _message(
    header=_message(stamp=_TIME, frame_id={"type": "string"}),
    joint_names=_array({"type": "string"}),
    points=_array(
        _message(
            positions=_NUMBERS,
            velocities=_NUMBERS,
            accelerations=_NUMBERS,
            effort=_NUMBERS,
            time_from_start=_TIME,
        )
    ),
)


def to_joint_trajectory(motion: Trajectory) -> bytes:
    """Return the message as JSON, as rosbridge and `ros2 topic pub` take it."""
    return json.dumps(joint_trajectory(motion)).encode()


def joint_trajectory(motion: Trajectory) -> dict[str, Any]:
    """Return the message by its fields; times are seconds and nanoseconds from its start."""
    rows = zip(motion.times, motion.positions, motion.velocities, motion.accelerations, strict=True)
    return {
        "header": {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""},
        "joint_names": list(motion.joint_names),
        "points": [
            {
                "positions": list(q),
                "velocities": list(v),
                "accelerations": list(vdot),
                "effort": [],
                "time_from_start": duration_of(instant),
            }
            for instant, q, v, vdot in rows
        ],
    }


def duration_of(seconds: float) -> dict[str, int]:
    """Return a time as ROS 2 has it."""
    whole, rest = divmod(round(seconds * 1e9), 10**9)
    return {"sec": whole, "nanosec": rest}
