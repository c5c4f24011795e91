"""PoseAttempts: IK attempts at displaced poses near a pose, feasible results nearest first."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Bool, Float64, Int64

from planning.domain.arrays import Array
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

# Largest number of feasible configurations returned.
_MAX_RESULTS = 4
# Number of configurations whose lines are traced at once.
_NUM_TRACED = 12
_MAX_DRAKE_ATTEMPTS = 24


class PoseAttempts:
    """IK attempts that reach poses exactly, seeded by a near configuration, hints and samples.

    Attributes:
        frame: Full name of the tool frame.
        hints: Configurations that seed half of the attempts, shape (n, nq).
        approach_check: Check of the goal's approach and retreat; None if it has neither.
    """

    def __init__(
        self,
        world: World,
        query: GoalQuery,
        targets: Sequence[Target],
        rng: np.random.Generator,
        deadline: Deadline,
    ) -> None:
        """Prepare for the tool frame of some targets; no IK is solved after the deadline."""
        self._world, self._query = world, query
        self.frame = targets[0].frame
        self._deadline = deadline
        self._feasibility = Feasibility(world, query)
        self.approach_check = approach_feasibility(world, query, targets, deadline)
        self._seeds = Seeds(query.group, world.limits(query.group), query.start, rng)
        self.hints: Array = np.zeros((0, query.group.num_positions))

    @property
    def uses_kernel(self) -> bool:
        """Whether the native kernel solves the IK: hundreds of attempts in the time of a few."""
        chain = kernel_chain(self._world.drake, self._query.group, self._world.state, self.frame)
        return chain is not None

    def next_seeds(self, count: int) -> Float64[np.ndarray, "count nq"]:
        """Return the next seeds within limits: the start, samples near it, then uniform ones."""
        return self._seeds.take(count)

    def are_feasible(self, rows: Float64[np.ndarray, "n nq"]) -> Bool[np.ndarray, " n"]:
        """Return which rows are within limits, free and satisfy the query's path constraints.

        The goal's approach and retreat are not checked.
        """
        return self._feasibility.are_feasible(rows)

    def with_free_approach(
        self, rows: Float64[np.ndarray, "n nq"], indices: Int64[np.ndarray, " n"]
    ) -> Int64[np.ndarray, " m"]:
        """Return the indices of feasible rows that have the goal's approach and retreat.

        Not promised: all such rows. Tracing is slow, so of the rows that pass a quick check only
        the first `_NUM_TRACED` are traced, and if none of these has the lines, `_NUM_TRACED` spread
        over all.

        Args:
            rows: Feasible configurations, best first.
            indices: Index of the target that each is near.
        """
        if self.approach_check is None or not len(rows):
            return np.arange(len(rows))
        likely = np.flatnonzero(self.approach_check.may_be_free(rows, indices))
        spread = np.linspace(0, len(likely) - 1, _NUM_TRACED).astype(np.int64)
        spread_candidates = np.unique(likely[spread]) if len(likely) else likely
        for candidates in (likely[:_NUM_TRACED], spread_candidates):
            is_free = self.approach_check.are_free(rows[candidates], indices[candidates])
            if is_free.any():
                return candidates[is_free]
        return np.zeros(0, dtype=np.int64)

    def pose_at(self, q: Float64[np.ndarray, " nq"]) -> Pose:
        """Return the tool frame's pose X_WT with the group at q."""
        return self._world.frame_pose(self.frame, self._world.embed(self._query.group, q))

    def solve_displaced(
        self,
        base: Pose,
        displacements: Float64[np.ndarray, "n 6"],
        seed: Float64[np.ndarray, " nq"] | None,
        index: int = 0,
    ) -> Float64[np.ndarray, "m nq"]:
        """Return a few feasible configurations at displaced poses, smallest displacements first.

        Displacements are ordered by the query's pose metric.

        Args:
            base: X_WB, the pose that is displaced.
            displacements: Displacements in B: translation [m] and rotation vector [rad], of any
                norm.
            seed: Configuration that seeds a quarter of the attempts; None for none.
            index: Index of the target that is near.
        """
        metric = self._query.options.pose_metric
        group, poses = self._query.group, _displaced_poses(base, displacements)
        kernel_solver = exact_kernel_solver(self._world, group, self.frame, poses)
        solver = kernel_solver or self._drake_solver(poses)
        max_attempts = len(displacements) if self.uses_kernel else _MAX_DRAKE_ATTEMPTS
        count = min(len(displacements), max_attempts)
        seeds = self._seeds.take(count).copy()
        if seed is not None:
            seeds[::4] = seed
        if len(self.hints):
            seeds[1::2] = np.resize(self.hints, seeds[1::2].shape)
        converged, rows = solver.solve(seeds, np.arange(len(seeds)), len(seeds))
        converged = converged[: len(rows)]
        weighted = displacements * np.repeat([metric.translation, metric.rotation], 3)
        costs = np.linalg.norm(weighted[: len(rows)], axis=1)[converged]
        rows = rows[converged][np.argsort(costs, kind="stable")]
        rows = rows[self.are_feasible(rows)]
        return rows[self.with_free_approach(rows, np.full(len(rows), index))][:_MAX_RESULTS]

    def _drake_solver(self, poses: tuple[Array, Array]) -> DrakePoseSolver:
        targets = [
            ToolTarget(self.frame, Pose(p, a), np.zeros(3), np.zeros(3))
            for p, a in zip(poses[0][:_MAX_DRAKE_ATTEMPTS], poses[1], strict=False)
        ]
        return DrakePoseSolver(self._world, self._query.group, self._deadline, targets)


def _displaced_poses(base: Pose, displacements: Array) -> tuple[Array, Array]:
    """Return poses displaced in the base's axes, rotations limited to pi: p_WT and quaternions."""
    shifts, turns = displacements[:, :3], np.array(displacements[:, 3:])
    turns *= np.minimum(1.0, np.pi / np.maximum(np.linalg.norm(turns, axis=1), 1e-12))[:, None]
    positions = base.position + rotation.rotate(base.quaternion, shifts)
    return positions, rotation.multiply(base.quaternion, rotation.exp(turns))
