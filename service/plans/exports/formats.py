"""Formats: which there are, what they are called on the web, and what they can hold."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from types import MappingProxyType
from typing import Any, Literal

from planning.errors import ProblemInvalid
from service.plans.exports.bag import to_bag
from service.plans.exports.exported_motion import ExportedMotion
from service.plans.exports.joint_trajectory import SCHEMA, to_joint_trajectory
from service.plans.exports.numpy_arrays import to_arrays
from service.plans.exports.recording import to_recording
from service.plans.exports.urscript import to_urscript

type FormatName = Literal["ros2", "npz", "urscript", "mcap", "rerun"]

_UR_JOINTS = 6
# Formats with names of coordinates, where others have one number for each joint.
_OF_ANY_JOINT = {"npz", "rerun"}
# What the extra of a format's name brings.
_MODULES = {"mcap": "mcap_ros2", "rerun": "rerun"}
_BYTES: Mapping[str, Any] = MappingProxyType({"type": "string", "format": "binary"})


@dataclass(frozen=True)
class Format:
    """One format.

    Attributes:
        media_type: Of the answer.
        write: Returns a motion as the bytes of a file.
        told: What it is, for the document.
        schema: What is in it, as JSON schema; by default bytes.
        shows_scene: Whether the file has the scene too.
    """

    media_type: str
    write: Callable[[ExportedMotion], bytes]
    told: str
    shows_scene: bool = False
    schema: Mapping[str, Any] = _BYTES


FORMATS: dict[FormatName, Format] = {
    "ros2": Format(
        "application/vnd.ros2.joint-trajectory+json",
        lambda motion: to_joint_trajectory(motion.samples),
        "The JSON of a `trajectory_msgs/msg/JointTrajectory`",
        schema=SCHEMA,
    ),
    "npz": Format(
        "application/x-npz",
        lambda motion: to_arrays(motion.samples),
        "Arrays of NumPy, named as in the JSON",
    ),
    "urscript": Format(
        "text/x-urscript",
        lambda motion: to_urscript(motion.samples),
        "A program of Universal Robots: it stops unless the robot is where the motion begins",
    ),
    "mcap": Format(
        "application/x-mcap",
        to_bag,
        "A log of ROS 2, which Foxglove opens: `/joint_states`, `/joint_trajectory`, `/tf`, "
        "`/tf_static` and `/markers`",
        shows_scene=True,
    ),
    "rerun": Format(
        "application/x-rerun",
        to_recording,
        "A recording for Rerun: the scene in motion, and curves of its joints",
        shows_scene=True,
    ),
}


def require_format(name: FormatName, joint_types: list[str]) -> None:
    """Go on only if a format can hold a motion of joints of some types.

    Raises:
        ProblemInvalid: It cannot, or the server lacks what writes it.
    """
    if name in _MODULES and find_spec(_MODULES[name]) is None:
        _refuse(name, f"needs the extra `{name}`, which this server lacks")
    if name in _OF_ANY_JOINT:
        return
    if any(kind in {"floating", "planar"} for kind in joint_types):
        _refuse(name, "has one number per joint, and a planar or floating joint has several")
    turning = [kind in {"revolute", "continuous"} for kind in joint_types]
    if name == "urscript" and turning != [True] * _UR_JOINTS:
        _refuse(name, f"is for six revolute joints, not for: {', '.join(joint_types)}")


def _refuse(name: str, why: str) -> None:
    message = f"the format {name} {why}"
    raise ProblemInvalid(message, {"field": "format"})
