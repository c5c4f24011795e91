"""Straight lines of a tool frame (MoveL, LIN), and motions of a group along them."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float64

from planning.domain.geometry import rotation
from planning.domain.geometry.pose import Pose
from planning.domain.value import Value

# Default tolerances on the tool's deviation from its line between waypoints.
MAX_POSITION_DEVIATION, MAX_ROTATION_DEVIATION = 1e-3, float(np.radians(0.5))


@dataclass(frozen=True, eq=False)
class Displacement(Value):
    """Translation by a vector, without a rotation.

    Attributes:
        vector: The displacement [m], shape (3,).
        frame: Frame of its axes: "world" or any frame of the scene, at its pose at the start.
    """

    vector: Float64[np.ndarray, "3"]
    frame: str = "world"


@dataclass(frozen=True, eq=False)
class ToolLine(Value):
    """The straight motion of a tool frame T from one pose to another.

    At fraction s in [0, 1] its origin is at p_0 + s (p_1 - p_0) and its rotation is
    R_0 exp(s phi), with phi the shortest rotation vector from R_0 to R_1 (Shoemake's slerp).

    Attributes:
        frame: Full name of T.
        begin: X_WT at s = 0.
        end: X_WT at s = 1.
    """

    frame: str
    begin: Pose
    end: Pose

    @property
    def translation(self) -> Float64[np.ndarray, "3"]:
        """Translation p_1 - p_0 in world [m]."""
        return self.end.position - self.begin.position

    @cached_property
    def rotation_vector(self) -> Float64[np.ndarray, "3"]:
        """Rotation vector phi, in the tool's axes [rad]."""
        inverse = rotation.conjugate(self.begin.quaternion)
        return rotation.log(rotation.multiply(inverse, self.end.quaternion))

    @property
    def length(self) -> float:
        """Length of the path of the tool's origin [m]."""
        return float(np.linalg.norm(self.translation))

    def pose(self, fraction: float) -> Pose:
        """Return X_WT at a fraction."""
        position = self.begin.position + fraction * self.translation
        turn = rotation.exp(fraction * self.rotation_vector)
        return Pose.from_parts(position, rotation.multiply(self.begin.quaternion, turn))

    @property
    def reverse(self) -> "ToolLine":
        """The same line from its other end."""
        return ToolLine(self.frame, self.end, self.begin)


@dataclass(frozen=True, eq=False)
class LinearMove(Value):
    """Linear move: a continuous motion of a group that takes a tool frame along all of a line.

    Attributes:
        line: The line.
        fractions: Fraction along the line of every waypoint, from 0 to 1, shape (n,), n >= 2.
        positions: The group's q there, shape (n, nq).
    """

    line: ToolLine
    fractions: Float64[np.ndarray, " n"]
    positions: Float64[np.ndarray, "n nq"]

    @property
    def reverse(self) -> "LinearMove":
        """The same linear move from its end to its start."""
        return LinearMove(self.line.reverse, 1.0 - self.fractions[::-1], self.positions[::-1])

    def shifted(self, offset: Float64[np.ndarray, " nq"]) -> "LinearMove":
        """Return the same motion with an offset added to all positions, such as whole turns."""
        return LinearMove(self.line, self.fractions, self.positions + offset)


@dataclass(frozen=True, eq=False)
class GoalMoves(Value):
    """Linear moves of a goal configuration: approach and retreat.

    Attributes:
        approach: Linear move that ends at the goal configuration; None if none is requested.
        retreat: Linear move that begins there; None if none is requested.
    """

    approach: LinearMove | None
    retreat: LinearMove | None

    @property
    def all(self) -> tuple[LinearMove, ...]:
        """The moves that are not None, approach first."""
        return tuple(move for move in (self.approach, self.retreat) if move is not None)


@dataclass(frozen=True, eq=False)
class LineSection(Value):
    """Section of a motion along a line, with tolerances on the tool's pose.

    Attributes:
        line: The line.
        begin: First instant [s].
        end: Last instant [s].
        max_position_deviation: Largest distance of the tool's origin from the line [m].
        max_rotation_deviation: Largest error of its rotation [rad].
    """

    line: ToolLine
    begin: float
    end: float
    max_position_deviation: float
    max_rotation_deviation: float
