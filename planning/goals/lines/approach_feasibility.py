"""ApproachFeasibility: check of approach and retreat at configurations near an infeasible goal."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Bool, Float64, Int64

from planning.domain.arrays import Array
from planning.domain.geometry import rotation
from planning.domain.geometry.pose import Pose
from planning.domain.goals.goal import LinedGoal
from planning.domain.goals.goal_configurations import Bounds
from planning.domain.request.deadline import Deadline
from planning.errors import DeadlineExceeded
from planning.goals.diagnosis.nearest_program import Target, moved_along
from planning.goals.feasibility import Feasibility
from planning.goals.goal_query import GoalQuery
from planning.goals.ik.pose_solvers import exact_kernel_solver
from planning.goals.lines.approach import ApproachChecker, filter_by_approach
from planning.goals.lines.line_tracer import TraceResolution
from planning.goals.targets.tool_target import ToolTarget
from planning.world.mechanics.tool_kinematics import ToolKinematics
from planning.world.world import World

# Resolution without bisection: whether a line reaches its end matters, not where it is blocked.
_VERDICTS = TraceResolution(end=1.0)
# Quick check of a line: least and most sample points, and their spacing [m]; and the largest joint
# motion between two of them [rad or m]: lines with larger ones are hardly ever free.
_LEAST, _MOST, _OFTEN = 4, 16, 0.05
_JUMP = 1.0


class ApproachFeasibility:
    """Check of approach and retreat lines at configurations that miss the goal's pose.

    The lines are traced as in plans and have the requested lengths. Either the goal moves to the
    reached pose together with its axes (`are_free`), or it stays in place with a larger tolerance
    (`are_free_from`).
    """

    def __init__(
        self,
        world: World,
        query: GoalQuery,
        goal: LinedGoal,
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
        return self._judged(rows, self._moved(self._reached(rows), indices))

    def may_be_free(
        self, rows: Float64[np.ndarray, "n nq"], indices: Int64[np.ndarray, " n"]
    ) -> Bool[np.ndarray, " n"]:
        """Return which rows may have all lines, by a quick check: sampled IK instead of tracing.

        A heuristic to discard rows; it neither proves nor refutes a line.
        """
        good = np.ones(len(rows), dtype=bool)
        if not len(rows):
            return good
        reached = self._reached(rows)
        axes = np.array([pose.quaternion for pose in self._moved(reached, indices)])
        at = np.array([pose.position for pose in reached])
        turns = np.array([pose.quaternion for pose in reached])
        for way in (self._goal.approach, self._goal.retreat):
            if way is not None:
                outwards = rotation.rotate(axes, np.asarray(way)[None])
                good[good] = self._glanced(rows[good], (at[good], turns[good]), outwards[good])
        return good

    def _glanced(self, rows: Array, reached: tuple[Array, Array], outwards: Array) -> Any:
        """Return whether each row can follow a line through sampled poses, feasible at each."""
        good, q = np.ones(len(rows), dtype=bool), np.array(rows)
        if not len(rows):
            return good
        length = float(np.linalg.norm(outwards, axis=1).max())
        count = int(np.clip(np.ceil(length / _OFTEN), _LEAST, _MOST))
        for share in np.arange(1, count + 1) / count:
            poses = reached[0] + share * outwards, reached[1]
            solver = exact_kernel_solver(self._world, self._query.group, self._frame, poses)
            if solver is None:
                return good
            asked = np.flatnonzero(good)
            good[asked], found = solver.solve(q[asked], asked, len(asked) + 1)
            good[asked] &= np.abs(found - q[asked]).max(axis=1) < _JUMP
            q[asked] = found
            good[good] = self._feasibility.are_met(q[good])
        return good

    def are_free_from(
        self, rows: Float64[np.ndarray, "n nq"], index: int
    ) -> Bool[np.ndarray, " n"]:
        """Return which rows have all lines, path constraints included, with the target in place."""
        return self._judged(rows, [self._targets[index].pose] * len(rows))

    def bounds_of(self, q: Float64[np.ndarray, " nq"], index: int) -> Bounds:
        """Return the constraints that block the lines of q with the goal moved there.

        These are the stop of a line, or else the violated path constraints; empty if the time runs
        out.
        """
        rules, judge = self._query.rules, self._judge(self._moved(self._reached(q[None]), [index]))
        try:
            stop = judge.stop_of(q, 0)
            if stop is not None or rules is None or not judge.admit(q[None], np.array([0]))[0]:
                return Bounds(line=stop)
        except DeadlineExceeded:
            return Bounds()
        (legs,) = judge.legs_of(q[None], q[None])
        rows = np.concatenate([leg.positions for leg in legs.all])
        broken = [entry["constraint"] for row in rows for entry in rules.violations(row)]
        return Bounds(constraints=tuple(dict.fromkeys(broken)))

    def _reached(self, rows: Array) -> list[Pose]:
        return [
            Pose(p_WT, rotation.from_matrix(R_WT))
            for R_WT, p_WT in zip(*self._kinematics.poses(rows), strict=True)
        ]

    def _moved(self, reached: list[Pose], indices: Any) -> list[Pose]:
        return [
            moved_along(self._targets[int(i)], pose)
            for i, pose in zip(indices, reached, strict=True)
        ]

    def _judged(self, rows: Array, poses: list[Pose]) -> Any:
        if not poses:
            return np.zeros(0, dtype=bool)
        judge = self._judge(poses, _VERDICTS)
        try:
            good = judge.admit(rows, np.arange(len(rows)))
        except DeadlineExceeded:
            return np.zeros(len(rows), dtype=bool)
        good[good] = judge.keep_rules(rows[good])
        return good

    def _judge(self, poses: list[Pose], fineness: TraceResolution | None = None) -> ApproachChecker:
        exact = np.zeros(3)
        targets = [ToolTarget(self._frame, pose, exact, exact) for pose in poses]
        return ApproachChecker(
            self._world, self._query, self._goal, targets, self._deadline, fineness
        )


def approach_feasibility(
    world: World, query: GoalQuery, targets: Sequence[Target], deadline: Deadline
) -> ApproachFeasibility | None:
    """Return the approach feasibility check of a goal; None if it has no approach or retreat."""
    goal = filter_by_approach(query.goal)
    return None if goal is None else ApproachFeasibility(world, query, goal, targets, deadline)
