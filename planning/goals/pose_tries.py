"""PoseTries: free configurations at poses near a pose, of many tries the nearest first."""

from typing import Any

import numpy as np
from jaxtyping import Bool, Float64

from planning.domain import rotation
from planning.domain.deadline import Deadline
from planning.domain.pose import Pose
from planning.goals.goal_query import GoalQuery
from planning.goals.pose_solvers import DrakePoseSolver, kernel_pose_solver
from planning.goals.seeds import Seeds
from planning.goals.start import within_limits
from planning.goals.tool_target import ToolTarget
from planning.world.kernel_tree import kernel_chain
from planning.world.world import World

type Array = np.ndarray[Any, np.dtype[np.float64]]

# How many of the free ones are handed out.
_NUM_KEPT = 4
_NUM_BY_DRAKE = 24


class PoseTries:
    """Tries to reach poses exactly, from what reached others, from hints and from anywhere."""

    def __init__(
        self,
        world: World,
        query: GoalQuery,
        frame: str,
        rng: np.random.Generator,
        deadline: Deadline,
    ) -> None:
        """Bring a tool frame to poses; solve no more once the deadline is over."""
        self._world, self._query, self._frame = world, query, frame
        self._deadline = deadline
        self._limits = world.limits(query.group)
        self._oracle = world.collision_oracle(query.group, query.margins)
        self._seeds = Seeds(query.group, self._limits, query.start, rng)
        self.hints: Array = np.zeros((0, query.group.num_positions))

    @property
    def are_fast(self) -> bool:
        """Whether hundreds of tries take no longer than a few by Drake."""
        chain = kernel_chain(self._world.drake, self._query.group, self._world.state, self._frame)
        return chain is not None

    def random(self, count: int) -> Float64[np.ndarray, "count nq"]:
        """Return configurations within limits: the start, some near it, then any."""
        return self._seeds.take(count)

    def are_feasible(self, rows: Float64[np.ndarray, "n nq"]) -> Bool[np.ndarray, " n"]:
        """Return which configurations are within limits and free, and keep the query's rules."""
        feasible = within_limits(self._limits, rows)
        feasible[feasible] = self._oracle.are_free(rows[feasible])
        if self._query.rules is not None:
            feasible[feasible] = self._query.rules.are_kept(rows[feasible])
        return feasible

    def pose_at(self, q: Float64[np.ndarray, " nq"]) -> Pose:
        """Return X_WT of the tool frame."""
        return self._world.frame_pose(self._frame, self._world.embed(self._query.group, q))

    def reach(
        self, base: Pose, moves: Float64[np.ndarray, "n 6"], near: Float64[np.ndarray, " nq"] | None
    ) -> Float64[np.ndarray, "m nq"]:
        """Return feasible configurations at the smallest displacements that have any, a few.

        Args:
            base: X_WB.
            moves: Displacements in B: shift [m] and rotation vector [rad], of any norm.
            near: A configuration to begin with, often.
        """
        metric = self._query.options.pose_metric
        targets = [
            ToolTarget(self._frame, pose, np.zeros(3), np.zeros(3)) for pose in _moved(base, moves)
        ]
        group = self._query.group
        solver = kernel_pose_solver(self._world, group, targets)
        if solver is None:
            targets = targets[:_NUM_BY_DRAKE]
            solver = DrakePoseSolver(self._world, group, self._deadline, targets)
        seeds = self._seeds.take(len(targets)).copy()
        if near is not None:
            seeds[::4] = near
        if len(self.hints):
            seeds[1::2] = np.resize(self.hints, seeds[1::2].shape)
        converged, rows = solver.solve(seeds, np.arange(len(seeds)), len(seeds))
        converged = converged[: len(rows)]
        weighted = moves * np.repeat([metric.translation, metric.rotation], 3)
        costs = np.linalg.norm(weighted[: len(rows)], axis=1)[converged]
        rows = rows[converged][np.argsort(costs, kind="stable")]
        return rows[self.are_feasible(rows)][:_NUM_KEPT]


def _moved(base: Pose, moves: Array) -> list[Pose]:
    """Return a pose displaced in its own axes, by half a turn at most."""
    shifts, turns = moves[:, :3], np.array(moves[:, 3:])
    turns *= np.minimum(1.0, np.pi / np.maximum(np.linalg.norm(turns, axis=1), 1e-12))[:, None]
    positions = base.position + rotation.rotate(base.quaternion, shifts)
    quaternions = rotation.multiply(base.quaternion, rotation.exp(turns))
    return [Pose(p, a) for p, a in zip(positions, quaternions, strict=True)]
