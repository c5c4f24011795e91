"""Path constraints: what a motion shall keep on its whole way, besides limits and margins."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.geometry.pose import Pose
from planning.domain.value import Value

type Array = np.ndarray[Any, np.dtype[np.float64]]


@dataclass(frozen=True, eq=False)
class PlacedBox(Value):
    """A box somewhere.

    Attributes:
        size: Full side lengths [m], infinite where it has no sides, shape (3,).
        pose: X_FB, its middle and axes B in the reference frame F.
        reference: Name of F; one that moves with the group counts where the start puts it.
    """

    size: Float64[np.ndarray, "3"]
    pose: Pose = field(default_factory=Pose.identity)
    reference: str = "world"


@dataclass(frozen=True, eq=False)
class DistanceBand(Value):
    """The smallest distance between two sets of bodies stays within [min, max].

    Pairs that may collide by the scene's leave are not looked at.

    Attributes:
        bodies: Full names; None for all that the group moves.
        to: Full names of the others; None for every body that is not among `bodies`.
        min: [m], not negative.
        max: [m], larger than `min`; may be infinite.
    """

    bodies: tuple[str, ...] | None
    to: tuple[str, ...] | None
    min: float
    max: float


@dataclass(frozen=True, eq=False)
class KeepOut(Value):
    """The origin of a frame stays out of a box."""

    frame: str
    box: PlacedBox


@dataclass(frozen=True, eq=False)
class KeepIn(Value):
    """The origin of a frame stays in a box."""

    frame: str
    box: PlacedBox


@dataclass(frozen=True, eq=False)
class PositionBand(Value):
    """The origin of a frame stays near a line or a plane: in a box thin across, infinite along."""

    frame: str
    box: PlacedBox


@dataclass(frozen=True, eq=False)
class OrientationCone(Value):
    """An axis of a frame stays within an angle of a direction; turns about the axis are free.

    Attributes:
        frame: Full name.
        axis: In that frame, of any length but zero, shape (3,).
        direction: In the reference frame, of any length but zero, shape (3,).
        tolerance: Largest angle between them [rad], above 0.
        reference: Whose axes `direction` counts in; one that moves with the group counts as the
            start has it.
    """

    frame: str
    axis: Float64[np.ndarray, "3"]
    direction: Float64[np.ndarray, "3"]
    tolerance: float
    reference: str = "world"


@dataclass(frozen=True, eq=False)
class LockedJoints(Value):
    """Some joints of the group stay where the start has them."""

    joints: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class TightLimits(Value):
    """Some coordinates of the group stay within bounds, besides those of the robot.

    Attributes:
        limits: Smallest and largest position [rad or m] by the name of a scalar joint or of a
            coordinate (`JointGroup.position_names`).
    """

    limits: Mapping[str, tuple[float, float]]


@dataclass(frozen=True, eq=False)
class PathPredicate(Value):
    """A function of yours says yes to every configuration; for users of the library.

    It is asked at samples only, in the certificate too, whose check names the resolution. A
    problem that holds one has no digest and pickles only if the function does.

    Attributes:
        predicate: Takes the group's q, shape (nq,); the same q gets the same answer.
        resolution: Largest joint-space distance between two samples [rad or m].
        name: For messages.
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
    """Return how messages and certificates call the constraint at an index of a problem."""
    return f"constraint {index}: {_TYPES[type(constraint)]}"
