"""Path constraints: conditions on every configuration of a motion, besides limits and margins."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.geometry.pose import Pose
from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class PlacedBox(Value):
    """Oriented box, fixed in a reference frame.

    Attributes:
        size: Full side lengths [m], infinite along unbounded axes, shape (3,).
        pose: X_FB, pose of the box frame B (centre and axes) in the reference frame F.
        reference: Name of F; a frame that moves with the group is taken at the start configuration.
    """

    size: Float64[np.ndarray, "3"]
    pose: Pose = field(default_factory=Pose.identity)
    reference: str = "world"


@dataclass(frozen=True, eq=False)
class DistanceBand(Value):
    """Path constraint: the smallest distance between two sets of bodies stays within [min, max].

    Pairs that the scene allows to collide are not measured.

    Attributes:
        bodies: Full names; None for all bodies that the group moves.
        to: Full names of the other set; None for every body that is not among `bodies`.
        min: Smallest distance [m], not negative.
        max: Largest distance [m], larger than `min`; may be infinite.
    """

    bodies: tuple[str, ...] | None
    to: tuple[str, ...] | None
    min: float
    max: float


@dataclass(frozen=True, eq=False)
class KeepOut(Value):
    """Path constraint: the origin of a frame stays outside a box."""

    frame: str
    box: PlacedBox


@dataclass(frozen=True, eq=False)
class KeepIn(Value):
    """Path constraint: the origin of a frame stays inside a box."""

    frame: str
    box: PlacedBox


@dataclass(frozen=True, eq=False)
class PositionBand(Value):
    """Path constraint: the origin of a frame stays near a line or plane, in an unbounded box.

    The box is thin across the line or plane and infinite along it.
    """

    frame: str
    box: PlacedBox


@dataclass(frozen=True, eq=False)
class OrientationCone(Value):
    """Path constraint: an axis of a frame stays within an angle of a direction.

    Rotation about the axis is free.

    Attributes:
        frame: Full name of the frame.
        axis: The axis in that frame, of any length but zero, shape (3,).
        direction: In the reference frame, of any length but zero, shape (3,).
        tolerance: Largest angle between axis and direction [rad], above 0.
        reference: Name of the reference frame of `direction`; a frame that moves with the group is
            taken at the start configuration.
    """

    frame: str
    axis: Float64[np.ndarray, "3"]
    direction: Float64[np.ndarray, "3"]
    tolerance: float
    reference: str = "world"


@dataclass(frozen=True, eq=False)
class LockedJoints(Value):
    """Path constraint: some joints of the group keep their start positions."""

    joints: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class TightLimits(Value):
    """Path constraint: position bounds on some coordinates of the group, tighter than the robot's.

    Attributes:
        limits: Smallest and largest position [rad or m] by the name of a scalar joint or of a
            coordinate (`JointGroup.position_names`).
    """

    limits: Mapping[str, tuple[float, float]]


@dataclass(frozen=True, eq=False)
class PathPredicate(Value):
    """Path constraint: a Python function of the caller accepts every configuration.

    It is evaluated at samples only, in the certificate too, whose check reports the resolution. A
    problem with a predicate has no digest, and it pickles only if the function does.

    Attributes:
        predicate: Takes the group's q, shape (nq,), returns acceptance; equal q must get equal
            answers.
        resolution: Largest joint-space distance between two samples [rad or m].
        name: Name of the constraint in messages.
    """

    predicate: Callable[[Array], bool]
    resolution: float
    name: str = "predicate"


type PathConstraint = (
    DistanceBand
    | KeepOut
    | KeepIn
    | PositionBand
    | OrientationCone
    | LockedJoints
    | TightLimits
    | PathPredicate
)

_TYPES: dict[type[Value], str] = {
    DistanceBand: "distance_band",
    KeepOut: "keep_out",
    KeepIn: "keep_in",
    PositionBand: "position",
    OrientationCone: "orientation",
    LockedJoints: "locked_joints",
    TightLimits: "joint_limits",
    PathPredicate: "predicate",
}


def constraint_label(index: int, constraint: PathConstraint) -> str:
    """Return the name of a problem's constraint, by its index, in messages and certificates."""
    return f"constraint {index}: {_TYPES[type(constraint)]}"
