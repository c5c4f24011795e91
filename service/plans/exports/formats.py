"""Formats: which there are, what they are called on the web, and what they can hold."""

from collections.abc import Callable
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Literal

from planning.errors import ProblemInvalid
from service.plans.exports.bag import to_bag
from service.plans.exports.joint_trajectory import to_joint_trajectory
from service.plans.exports.numpy_arrays import to_arrays
from service.plans.exports.urscript import to_urscript
from service.plans.models.trajectory import Trajectory

type FormatName = Literal["ros2", "npz", "urscript", "mcap"]

_UR_JOINTS = 6
# Of the extra `mcap`.
_MCAP = "mcap_ros2"


@dataclass(frozen=True)
class Format:
    """One format.

    Attributes:
        media_type: Of the answer.
        write: Returns samples as the bytes of a file.
        told: What it is, for the document.
    """

    media_type: str
    write: Callable[[Trajectory], bytes]
    told: str


FORMATS: dict[FormatName, Format] = {
    "ros2": Format(
        "application/vnd.ros2.joint-trajectory+json",
        to_joint_trajectory,
        "The JSON of a `trajectory_msgs/msg/JointTrajectory`",
    ),
    "npz": Format("application/x-npz", to_arrays, "Arrays of NumPy, named as in the JSON"),
    "urscript": Format(
        "text/x-urscript",
        to_urscript,
        "A program of Universal Robots: it stops unless the robot is where the motion begins",
    ),
    "mcap": Format(
        "application/x-mcap",
        to_bag,
        "A log of `/joint_states` and `/joint_trajectory` (ROS 2), which Foxglove opens",
    ),
}


def require_format(name: FormatName, joint_types: list[str]) -> None:
    """Go on only if a format can hold a motion of joints of some types.

    Raises:
        ProblemInvalid: It cannot, or the server lacks what writes it.
    """
    if name == "npz":
        return
    if any(kind in {"floating", "planar"} for kind in joint_types):
        _refuse(name, "has one number per joint, and a planar or floating joint has several")
    turning = [kind in {"revolute", "continuous"} for kind in joint_types]
    if name == "urscript" and turning != [True] * _UR_JOINTS:
        _refuse(name, f"is for six revolute joints, not for: {', '.join(joint_types)}")
    if name == "mcap" and find_spec(_MCAP) is None:
        _refuse(name, "needs the extra `mcap`, which this server lacks")


def _refuse(name: str, why: str) -> None:
    message = f"the format {name} {why}"
    raise ProblemInvalid(message, {"field": "format"})
