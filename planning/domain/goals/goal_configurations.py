"""What the goals stage found: configurations, or the nearest to what it could not reach."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.geometry.pose import Pose
from planning.domain.goals.funnel import Funnel
from planning.domain.goals.line_trace import LinearMoveStop
from planning.domain.goals.linear_moves import GoalMoves
from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class Bounds(Value):
    """What keeps a pose from being nearer to the one that was asked for.

    Attributes:
        joints: The coordinates at their limits.
        pairs: The pairs of bodies at their margins.
        constraints: The path constraints that would be violated, on the goal's lines too.
        line: What would stop one of these lines.
    """

    joints: tuple[str, ...] = ()
    pairs: tuple[tuple[str, str], ...] = ()
    constraints: tuple[str, ...] = ()
    line: LinearMoveStop | None = None

    @property
    def binding(self) -> str:
        """The first of those that do: "collision", ... "limits", or "reach" if none does."""
        if self.pairs:
            return "collision"
        if self.constraints:
            return "path_constraint"
        if self.line is not None:
            return self.line.leg
        return "limits" if self.joints else "reach"

    @property
    def evidence(self) -> dict[str, Any]:
        """All of it as JSON has it."""
        return {
            "binding": self.binding,
            "joints": list(self.joints),
            "pairs": [list(pair) for pair in self.pairs],
            "constraints": list(self.constraints),
            "line": self.line and self.line.evidence,
        }


@dataclass(frozen=True, eq=False)
class NearestPose(Value):
    """The nearest feasible pose that the tool frame can take to what it cannot.

    Feasible are poses with a configuration that is free and within limits, keeps the path
    constraints, and has the lines that the goal asks for.

    Attributes:
        pose: X_WT, the tool frame in world.
        positions: The group's q there, shape (nq,).
        translation_error: From the nearest pose within the goal's tolerance [m].
        rotation_error: From the same [rad].
        pose_index: To which of the goal's poses it is the nearest.
        goal: X_WG of that pose, were it moved along, so that it is met there as it stands.
        bounds: What keeps it from being nearer; None if the time ran out before that was clear, and
            then there may well be a nearer one.
    """

    pose: Pose
    positions: Float64[np.ndarray, " nq"]
    translation_error: float
    rotation_error: float
    pose_index: int
    goal: Pose
    bounds: Bounds | None

    @property
    def evidence(self) -> dict[str, Any]:
        """All of it as JSON has it."""
        return {
            "position": self.pose.position.tolist(),
            "quaternion": self.pose.quaternion.tolist(),
            "positions": self.positions.tolist(),
            "translation_error": self.translation_error,
            "rotation_error": self.rotation_error,
            "pose_index": self.pose_index,
            "goal": {
                "position": self.goal.position.tolist(),
                "quaternion": self.goal.quaternion.tolist(),
            },
            **(self.bounds or Bounds()).evidence,
            **({} if self.bounds else {"binding": None}),
            "cut_short": self.bounds is None,
        }


@dataclass(frozen=True, eq=False)
class NearestConfiguration(Value):
    """The nearest feasible configuration to some that were asked for, of which none is.

    Attributes:
        positions: The group's q, within limits, free, and keeping the path constraints, shape
            (nq,).
        distance: From the one that was asked for, in the weighted joint metric [rad or m].
        differences: q [-] what was asked for, shape (nv,) [rad or m].
        names: Of these coordinates.
        goal_index: To which of those asked for it is the nearest.
        pairs: The pairs of bodies that would be nearer than their margin, were it any nearer.
        constraints: The path constraints that would be violated.
        joints: The coordinates at their limits that differ from what was asked for.
    """

    positions: Float64[np.ndarray, " nq"]
    distance: float
    differences: Float64[np.ndarray, " nv"]
    names: tuple[str, ...]
    goal_index: int
    pairs: tuple[tuple[str, str], ...] = ()
    constraints: tuple[str, ...] = ()
    joints: tuple[str, ...] = ()

    @property
    def binding(self) -> str:
        """What keeps it from being nearer: the first of those that do."""
        if self.pairs:
            return "collision"
        return "path_constraint" if self.constraints else "limits"

    @property
    def evidence(self) -> dict[str, Any]:
        """All of it as JSON has it."""
        return {
            "positions": self.positions.tolist(),
            "distance": self.distance,
            "differences": dict(zip(self.names, self.differences.tolist(), strict=True)),
            "goal_index": self.goal_index,
            "binding": self.binding,
            "joints": list(self.joints),
            "pairs": [list(pair) for pair in self.pairs],
            "constraints": list(self.constraints),
        }


@dataclass(frozen=True, eq=False)
class GoalConfigurations(Value):
    """What the goals stage found.

    Attributes:
        positions: The group's q, nearest to the start first, shape (n, nq), n >= 1.
        target_indices: Which candidate of the goal each row reaches.
        funnel: How many samples survived what.
        legs: Approach and retreat of each row; none if the goal has neither.
    """

    positions: Float64[np.ndarray, "n nq"]
    target_indices: tuple[int, ...]
    funnel: Funnel
    legs: tuple[GoalMoves, ...] = ()

    @property
    def entries(self) -> Float64[np.ndarray, "n nq"]:
        """Where the free part of a motion to each row ends: at its approach, if it has one."""
        approaches = [leg.approach for leg in self.legs]
        if not approaches or approaches[0] is None:
            return self.positions
        return np.stack([leg.positions[0] for leg in approaches if leg is not None])
