"""PoseAttempts: free configurations at poses near a pose, of many tries the nearest first."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Bool, Float64, Int64

from planning.domain.geometry import rotation
from planning.domain.geometry.pose import Pose
from planning.domain.request.deadline import Deadline
from planning.goals.diagnosis.nearest_program import Target
from planning.goals.feasibility import Feasibility
from planning.goals.goal_query import GoalQuery
from planning.goals.ik.pose_solvers import DrakePoseSolver, exact_kernel_solver
from planning.goals.ik.seeds import Seeds
from planning.goals.lines.approach_feasibility import approach_feasibility
from planning.goals.targets.tool_target import ToolTarget
from planning.world.kernel.kernel_tree import kernel_chain
from planning.world.world import World

type Array = np.ndarray[Any, np.dtype[np.float64]]

# How many of the free ones are handed out.
_NUM_KEPT = 4
# Of so many configurations at once it is looked whether they have lines.
_NUM_LINED = 12
_NUM_BY_DRAKE = 24


class PoseAttempts:
    """Tries to reach poses exactly, from what reached others, from hints and from anywhere.

    Attributes:
        frame: Full name of the tool frame.
        hints: What many tries begin with.
        lines: The judge of the goal's lines, if it asks for any.
    """

    def __init__(
        self,
        world: World,
        query: GoalQuery,
        targets: Sequence[Target],
        rng: np.random.Generator,
        deadline: Deadline,
    ) -> None:
        """Bring a tool frame to poses near targets; solve no more once the deadline is over."""
        self._world, self._query = world, query
        self.frame = targets[0].frame
        self._deadline = deadline
        self._feasibility = Feasibility(world, query)
        self.lines = approach_feasibility(world, query, targets, deadline)
        self._seeds = Seeds(query.group, world.limits(query.group), query.start, rng)
        self.hints: Array = np.zeros((0, query.group.num_positions))

    @property
    def are_fast(self) -> bool:
        """Whether hundreds of tries take no longer than a few by Drake."""
        chain = kernel_chain(self._world.drake, self._query.group, self._world.state, self.frame)
        return chain is not None

    def random(self, count: int) -> Float64[np.ndarray, "count nq"]:
        """Return configurations within limits: the start, some near it, then any."""
        return self._seeds.take(count)

    def are_feasible(self, rows: Float64[np.ndarray, "n nq"]) -> Bool[np.ndarray, " n"]:
        """Return which rows are within limits and free, and keep the query's rules.

        Of the goal's lines nothing is said.
        """
        return self._feasibility.are_met(rows)

    def lined(
        self, rows: Float64[np.ndarray, "n nq"], indices: Int64[np.ndarray, " n"]
    ) -> Int64[np.ndarray, " m"]:
        """Return which of some feasible rows have the goal's lines, in their order.

        Lines take long: none is looked at beyond the first few that have them, nor of many that may
        have them more than some, of which the last are spread over all.

        Args:
            rows: The best first.
            indices: To which of the targets each is near.
        """
        if self.lines is None or not len(rows):
            return np.arange(len(rows))
        likely = np.flatnonzero(self.lines.may_be_free(rows, indices))
        spread = np.linspace(0, len(likely) - 1, _NUM_LINED).astype(np.int64)
        for asked in (likely[:_NUM_LINED], np.unique(likely[spread]) if len(likely) else likely):
            found = asked[self.lines.are_free(rows[asked], indices[asked])]
            if len(found):
                return found
        return np.zeros(0, dtype=np.int64)

    def pose_at(self, q: Float64[np.ndarray, " nq"]) -> Pose:
        """Return X_WT of the tool frame."""
        return self._world.frame_pose(self.frame, self._world.embed(self._query.group, q))

    def reach(
        self,
        base: Pose,
        moves: Float64[np.ndarray, "n 6"],
        near: Float64[np.ndarray, " nq"] | None,
        index: int = 0,
    ) -> Float64[np.ndarray, "m nq"]:
        """Return feasible configurations at the smallest displacements that have any, a few.

        Args:
            base: X_WB.
            moves: Displacements in B: shift [m] and rotation vector [rad], of any norm.
            near: A configuration to begin with, often.
            index: Which of the targets is near.
        """
        metric = self._query.options.pose_metric
        group, poses = self._query.group, _moved(base, moves)
        solver = exact_kernel_solver(self._world, group, self.frame, poses) or self._by_drake(poses)
        count = len(moves) if self.are_fast else min(len(moves), _NUM_BY_DRAKE)
        seeds = self._seeds.take(count).copy()
        if near is not None:
            seeds[::4] = near
        if len(self.hints):
            seeds[1::2] = np.resize(self.hints, seeds[1::2].shape)
        converged, rows = solver.solve(seeds, np.arange(len(seeds)), len(seeds))
        converged = converged[: len(rows)]
        weighted = moves * np.repeat([metric.translation, metric.rotation], 3)
        costs = np.linalg.norm(weighted[: len(rows)], axis=1)[converged]
        rows = rows[converged][np.argsort(costs, kind="stable")]
        rows = rows[self.are_feasible(rows)]
        return rows[self.lined(rows, np.full(len(rows), index))][:_NUM_KEPT]

    def _by_drake(self, poses: tuple[Array, Array]) -> DrakePoseSolver:
        targets = [
            ToolTarget(self.frame, Pose(p, a), np.zeros(3), np.zeros(3))
            for p, a in zip(poses[0][:_NUM_BY_DRAKE], poses[1], strict=False)
        ]
        return DrakePoseSolver(self._world, self._query.group, self._deadline, targets)


def _moved(base: Pose, moves: Array) -> tuple[Array, Array]:
    """Return a pose displaced in its own axes, by half a turn at most: p_WT and quaternions."""
    shifts, turns = moves[:, :3], np.array(moves[:, 3:])
    turns *= np.minimum(1.0, np.pi / np.maximum(np.linalg.norm(turns, axis=1), 1e-12))[:, None]
    positions = base.position + rotation.rotate(base.quaternion, shifts)
    return positions, rotation.multiply(base.quaternion, rotation.exp(turns))
