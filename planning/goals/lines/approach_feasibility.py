"""ApproachFeasibility: check of approach and retreat at configurations near an infeasible goal."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Bool, Float64, Int64

from planning.domain.arrays import Array
from planning.domain.geometry import rotation
from planning.domain.geometry.pose import Pose
from planning.domain.goals.goal import GoalWithLinearMoves
from planning.domain.goals.goal_configurations import ActiveConstraints
from planning.domain.request.deadline import Deadline
from planning.errors import DeadlineExceeded
from planning.goals.diagnosis.nearest_program import Target, displaced_target_pose
from planning.goals.feasibility import Feasibility
from planning.goals.goal_query import GoalQuery
from planning.goals.ik.pose_solvers import exact_kernel_solver
from planning.goals.lines.approach_checker import ApproachChecker, goal_with_approach
from planning.goals.lines.line_tracer import TraceResolution
from planning.goals.targets.tool_target import ToolTarget
from planning.world.mechanics.tool_kinematics import ToolKinematics
from planning.world.world import World

# Resolution without bisection: whether a line reaches its end matters, not where it is blocked.
_COARSE_RESOLUTION = TraceResolution(bisection_tolerance=1.0)
# Quick check of a line: least and most sample points, and their spacing [m]; and the largest joint
# motion between two of them [rad or m]: lines with larger ones are hardly ever free.
_MIN_SAMPLES, _MAX_SAMPLES, _SAMPLE_SPACING = 4, 16, 0.05
_MAX_JOINT_MOTION = 1.0


class ApproachFeasibility:
    """Check of approach and retreat lines at configurations that miss the goal's pose.

    The lines are traced as in plans and have the requested lengths. Either the goal moves to the
    reached pose together with its axes (`are_free`), or it stays in place with a larger tolerance
    (`are_free_in_place`).
    """

    def __init__(
        self,
        world: World,
        query: GoalQuery,
        goal: GoalWithLinearMoves,
        targets: Sequence[Target],
        deadline: Deadline,
    ) -> None:
        """Prepare for the goal's targets in world; after the deadline lines count as blocked."""
        self._world, self._query, self._goal = world, query, goal
        self._targets, self._deadline = targets, deadline
        self._frame = targets[0].frame
        self._kinematics = ToolKinematics(world, query.group, self._frame)
        self._feasibility = Feasibility(world, query)

    def are_free(
        self, rows: Float64[np.ndarray, "n nq"], indices: Int64[np.ndarray, " n"]
    ) -> Bool[np.ndarray, " n"]:
        """Return which rows have all lines, path constraints included, with the goal moved there.

        Args:
            rows: Configurations that are feasible themselves.
            indices: Index of the target that is moved to each.
        """
        return self._check(rows, self._moved_targets(self._tool_poses(rows), indices))

    def may_be_free(
        self, rows: Float64[np.ndarray, "n nq"], indices: Int64[np.ndarray, " n"]
    ) -> Bool[np.ndarray, " n"]:
        """Return which rows may have all lines, by a quick check: sampled IK instead of tracing.

        A heuristic to discard rows; it neither proves nor refutes a line.
        """
        is_candidate = np.ones(len(rows), dtype=bool)
        if not len(rows):
            return is_candidate
        tool_poses = self._tool_poses(rows)
        axes = np.array([pose.quaternion for pose in self._moved_targets(tool_poses, indices)])
        positions = np.array([pose.position for pose in tool_poses])
        quaternions = np.array([pose.quaternion for pose in tool_poses])
        for vector in (self._goal.approach, self._goal.retreat):
            if vector is not None:
                displacements = rotation.rotate(axes, np.asarray(vector)[None])
                is_candidate[is_candidate] = self._may_follow(
                    rows[is_candidate],
                    (positions[is_candidate], quaternions[is_candidate]),
                    displacements[is_candidate],
                )
        return is_candidate

    def _may_follow(
        self, rows: Array, tool_poses: tuple[Array, Array], displacements: Array
    ) -> Any:
        """Return whether each row can follow a line through sampled poses, feasible at each."""
        is_candidate, q = np.ones(len(rows), dtype=bool), np.array(rows)
        if not len(rows):
            return is_candidate
        length = float(np.linalg.norm(displacements, axis=1).max())
        count = int(np.clip(np.ceil(length / _SAMPLE_SPACING), _MIN_SAMPLES, _MAX_SAMPLES))
        for fraction in np.arange(1, count + 1) / count:
            poses = tool_poses[0] + fraction * displacements, tool_poses[1]
            solver = exact_kernel_solver(self._world, self._query.group, self._frame, poses)
            if solver is None:
                return is_candidate
            indices = np.flatnonzero(is_candidate)
            is_candidate[indices], next_q = solver.solve(q[indices], indices, len(indices) + 1)
            is_candidate[indices] &= np.abs(next_q - q[indices]).max(axis=1) < _MAX_JOINT_MOTION
            q[indices] = next_q
            is_candidate[is_candidate] = self._feasibility.are_feasible(q[is_candidate])
        return is_candidate

    def are_free_in_place(
        self, rows: Float64[np.ndarray, "n nq"], index: int
    ) -> Bool[np.ndarray, " n"]:
        """Return which rows have all lines, path constraints included, with the target in place."""
        return self._check(rows, [self._targets[index].pose] * len(rows))

    def active_constraints_at(self, q: Float64[np.ndarray, " nq"], index: int) -> ActiveConstraints:
        """Return the constraints that block the lines of q with the goal moved there.

        These are the stop of a line, or else the violated path constraints; empty if the time runs
        out.
        """
        constraints = self._query.constraints
        checker = self._make_checker(self._moved_targets(self._tool_poses(q[None]), [index]))
        try:
            stop = checker.stop_of(q, 0)
            if (
                stop is not None
                or constraints is None
                or not checker.check(q[None], np.array([0]))[0]
            ):
                return ActiveConstraints(linear_move_stop=stop)
        except DeadlineExceeded:
            return ActiveConstraints()
        (moves,) = checker.moves_of(q[None], q[None])
        rows = np.concatenate([move.positions for move in moves.all])
        violated = [entry["constraint"] for row in rows for entry in constraints.violations(row)]
        return ActiveConstraints(constraints=tuple(dict.fromkeys(violated)))

    def _tool_poses(self, rows: Array) -> list[Pose]:
        return [
            Pose(p_WT, rotation.from_matrix(R_WT))
            for R_WT, p_WT in zip(*self._kinematics.poses(rows), strict=True)
        ]

    def _moved_targets(self, tool_poses: list[Pose], indices: Any) -> list[Pose]:
        return [
            displaced_target_pose(self._targets[int(i)], pose)
            for i, pose in zip(indices, tool_poses, strict=True)
        ]

    def _check(self, rows: Array, poses: list[Pose]) -> Any:
        if not poses:
            return np.zeros(0, dtype=bool)
        checker = self._make_checker(poses, _COARSE_RESOLUTION)
        try:
            is_free = checker.check(rows, np.arange(len(rows)))
        except DeadlineExceeded:
            return np.zeros(len(rows), dtype=bool)
        is_free[is_free] = checker.moves_satisfy_constraints(rows[is_free])
        return is_free

    def _make_checker(
        self, poses: list[Pose], resolution: TraceResolution | None = None
    ) -> ApproachChecker:
        exact = np.zeros(3)
        targets = [ToolTarget(self._frame, pose, exact, exact) for pose in poses]
        return ApproachChecker(
            self._world, self._query, self._goal, targets, self._deadline, resolution
        )


def approach_feasibility(
    world: World, query: GoalQuery, targets: Sequence[Target], deadline: Deadline
) -> ApproachFeasibility | None:
    """Return the approach feasibility check of a goal; None if it has no approach or retreat."""
    goal = goal_with_approach(query.goal)
    return None if goal is None else ApproachFeasibility(world, query, goal, targets, deadline)
