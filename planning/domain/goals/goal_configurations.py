"""GoalConfigurations: result of inverse kinematics, or the nearest feasible pose."""

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
class ActiveConstraints(Value):
    """Active constraints of a nearest pose: what keeps it from being nearer to the requested one.

    Attributes:
        joints: Coordinates at their limits.
        pairs: Pairs of bodies at their margins.
        constraints: Path constraints that would be violated, on the goal's linear moves too.
        linear_move_stop: Where and why one of these linear moves would stop.
    """

    joints: tuple[str, ...] = ()
    pairs: tuple[tuple[str, str], ...] = ()
    constraints: tuple[str, ...] = ()
    linear_move_stop: LinearMoveStop | None = None

    @property
    def binding(self) -> str:
        """Kind of the first active constraint: "collision", ... "limits", or "reach" for none."""
        if self.pairs:
            return "collision"
        if self.constraints:
            return "path_constraint"
        if self.linear_move_stop is not None:
            return self.linear_move_stop.move
        return "limits" if self.joints else "reach"

    @property
    def evidence(self) -> dict[str, Any]:
        """The same as JSON."""
        return {
            "binding": self.binding,
            "joints": list(self.joints),
            "pairs": [list(pair) for pair in self.pairs],
            "constraints": list(self.constraints),
            "line": self.linear_move_stop and self.linear_move_stop.evidence,
        }


@dataclass(frozen=True, eq=False)
class NearestPose(Value):
    """Nearest feasible pose of the tool frame to an infeasible goal pose.

    A pose is feasible if a configuration for it is free and within limits, keeps the path
    constraints, and has the linear moves that the goal requests.

    Attributes:
        pose: X_WT, the tool frame in world.
        positions: The group's q there, shape (nq,).
        translation_error: Distance from the nearest pose within the goal's tolerance [m].
        rotation_error: Angle from the same pose [rad].
        pose_index: Index of the goal's pose that it is nearest to.
        goal: X_WG of that pose, displaced so that the nearest pose meets it exactly.
        active_constraints: Active constraints; None if the time ran out before they were
            determined, and then a nearer pose may exist.
    """

    pose: Pose
    positions: Float64[np.ndarray, " nq"]
    translation_error: float
    rotation_error: float
    pose_index: int
    goal: Pose
    active_constraints: ActiveConstraints | None

    @property
    def evidence(self) -> dict[str, Any]:
        """The same as JSON."""
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
            **(self.active_constraints or ActiveConstraints()).evidence,
            **({} if self.active_constraints else {"binding": None}),
            "cut_short": self.active_constraints is None,
        }


@dataclass(frozen=True, eq=False)
class NearestConfiguration(Value):
    """Nearest feasible configuration to requested ones that are all infeasible.

    Attributes:
        positions: The group's q, within limits, free, and keeping the path constraints, shape
            (nq,).
        distance: From the requested one, in the weighted joint metric [rad or m].
        differences: q [-] the requested one, shape (nv,) [rad or m].
        names: Of these coordinates.
        goal_index: Index of the requested configuration that it is nearest to.
        pairs: Pairs of bodies that would violate their margin at any nearer configuration.
        constraints: Path constraints that would be violated.
        joints: Coordinates at their limits that differ from the requested one.
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
        """Kind of the first active constraint: "collision", "path_constraint" or "limits"."""
        if self.pairs:
            return "collision"
        return "path_constraint" if self.constraints else "limits"

    @property
    def evidence(self) -> dict[str, Any]:
        """The same as JSON."""
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
    """Result of the goals stage: goal configurations with their linear moves.

    Attributes:
        positions: The group's q, nearest to the start first, shape (n, nq), n >= 1.
        target_indices: Index of the goal's candidate that each row reaches.
        funnel: Number of IK samples that passed each test.
        moves: Approach and retreat of each row; empty if the goal has neither.
    """

    positions: Float64[np.ndarray, "n nq"]
    target_indices: tuple[int, ...]
    funnel: Funnel
    moves: tuple[GoalMoves, ...] = ()

    @property
    def entries(self) -> Float64[np.ndarray, "n nq"]:
        """End of the free motion to each row: the beginning of its approach, if it has one."""
        approaches = [moves.approach for moves in self.moves]
        if not approaches or approaches[0] is None:
            return self.positions
        return np.stack([move.positions[0] for move in approaches if move is not None])
