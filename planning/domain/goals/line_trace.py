"""How far a straight line of a tool can be followed, and what stops it."""

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
    """What ended a line before its end.

    Attributes:
        reason: `limit`: a joint would leave its range. `collision`: two bodies would be nearer than
            their margin. `singularity`: the joints would have to move without bound.
            `unreachable`: the joints cannot move the tool that way, however they stand.
        fraction: Of the line that was reached, to about 1e-5.
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
    """What ended an approach or a retreat, seen from the goal outwards.

    Attributes:
        leg: "approach" or "retreat".
        stop: What ended it.
    """

    leg: str
    stop: LineStop

    @property
    def evidence(self) -> dict[str, Any]:
        """The same as JSON has it."""
        stop = self.stop
        return {
            "leg": self.leg,
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
    """Configurations along a line: a continuous motion, from its beginning as far as it goes.

    Attributes:
        line: The line.
        fractions: Increasing from 0, of every waypoint, shape (n,), n >= 1.
        positions: The group's q there, shape (n, nq); geodesics join them.
        max_shift: How far the tool is from the line at most, between waypoints too [m].
        max_turn: The same of its rotation [rad].
        stop: What ended it, or None if all of it was reached.
    """

    line: ToolLine
    fractions: Float64[np.ndarray, " n"]
    positions: Float64[np.ndarray, "n nq"]
    max_shift: float
    max_turn: float
    stop: LineStop | None

    @property
    def fraction(self) -> float:
        """How much of the line was reached."""
        return float(self.fractions[-1])

    @property
    def length(self) -> float:
        """How far the tool's origin gets along it [m]."""
        return self.fraction * self.line.length

    @property
    def leg(self) -> LinearMove:
        """The motion, if it reaches the end."""
        return LinearMove(self.line, self.fractions, self.positions)
