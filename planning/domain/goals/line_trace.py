"""LineTrace: the part of a straight tool line that a group can follow, and what stops it."""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from jaxtyping import Float64

from planning.domain.geometry.body_pair import BodyPair
from planning.domain.geometry.pose import Pose
from planning.domain.goals.linear_moves import LinearMove, ToolLine
from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class LineStop(Value):
    """Reason and state at which a line cannot be followed any further.

    Attributes:
        reason: `limit`: a joint would leave its range. `collision`: two bodies would be nearer than
            their margin. `singularity`: the joints would have to move without bound.
            `unreachable`: no motion of the joints moves the tool that way, at any configuration.
        fraction: Reached fraction of the line, to about 1e-5.
        where: X_WT there.
        positions: The group's q there, shape (nq,).
        joint: The position coordinate at its limit, or "".
        pair: The two bodies, just beyond, or None.
        singular_value: Smallest singular value there of the tool's Jacobian, of those that are not
            zero everywhere (rotation [rad] and translation [m] per joint [rad or m]).
    """

    reason: Literal["limit", "singularity", "collision", "unreachable"]
    fraction: float
    where: Pose
    positions: Float64[np.ndarray, " nq"]
    joint: str
    pair: BodyPair | None
    singular_value: float


@dataclass(frozen=True, eq=False)
class LinearMoveStop(Value):
    """Stop of an approach or retreat, traced from the goal outwards.

    Attributes:
        move: "approach" or "retreat".
        stop: Reason and state.
    """

    move: str
    stop: LineStop

    @property
    def evidence(self) -> dict[str, Any]:
        """The same as JSON."""
        stop = self.stop
        return {
            "leg": self.move,
            "reason": stop.reason,
            "fraction": stop.fraction,
            "position": stop.where.position.tolist(),
            "quaternion": stop.where.quaternion.tolist(),
            "joint": stop.joint,
            "bodies": None if stop.pair is None else list(stop.pair.bodies),
            "singular_value": stop.singular_value,
        }


@dataclass(frozen=True, eq=False)
class LineTrace(Value):
    """Configurations along a line: a continuous motion from its beginning up to the stop.

    Attributes:
        line: The line.
        fractions: Fraction along the line of every waypoint, increasing from 0, shape (n,), n >= 1.
        positions: The group's q there, shape (n, nq); geodesics join them.
        max_position_deviation: Largest distance of the tool from the line, between waypoints too
            [m].
        max_rotation_deviation: The same of its rotation [rad].
        stop: Reason of the stop, or None if all of the line is reached.
    """

    line: ToolLine
    fractions: Float64[np.ndarray, " n"]
    positions: Float64[np.ndarray, "n nq"]
    max_position_deviation: float
    max_rotation_deviation: float
    stop: LineStop | None

    @property
    def fraction(self) -> float:
        """Reached fraction of the line, in [0, 1]."""
        return float(self.fractions[-1])

    @property
    def length(self) -> float:
        """Distance that the tool's origin covers along the line [m]."""
        return self.fraction * self.line.length

    @property
    def linear_move(self) -> LinearMove:
        """The trace as a linear move; meaningful only if it reaches the end of the line."""
        return LinearMove(self.line, self.fractions, self.positions)
