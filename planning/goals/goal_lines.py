"""GoalLines: which configurations near a goal have its approach and retreat."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Bool, Float64, Int64

from planning.domain import rotation
from planning.domain.deadline import Deadline
from planning.domain.goal import PoseGoal
from planning.domain.line_trace import LegStop
from planning.domain.pose import Pose
from planning.errors import DeadlineExceeded
from planning.goals.goal_query import GoalQuery
from planning.goals.leg_judge import LegJudge
from planning.goals.line_tracer import Fineness
from planning.goals.nearest_program import Target, moved_along
from planning.goals.tool_target import ToolTarget
from planning.world.tool_kinematics import ToolKinematics
from planning.world.world import World

type Array = np.ndarray[Any, np.dtype[np.float64]]

# Whether a line reaches its end is wanted, not where else it ends.
_VERDICTS = Fineness(end=1.0)


class GoalLines:
    """Judges lines as plans do, from configurations that reach another pose than was asked for.

    The lines are as long as asked for. Either the goal moves along with the pose, and its axes
    with it, or it stays where it is and tolerates more.
    """

    def __init__(
        self,
        world: World,
        query: GoalQuery,
        goal: PoseGoal,
        targets: Sequence[Target],
        deadline: Deadline,
    ) -> None:
        """Judge for the goal's targets in world; after the deadline no line is free."""
        self._world, self._query, self._goal = world, query, goal
        self._targets, self._deadline = targets, deadline
        self._kinematics = ToolKinematics(world, query.group, targets[0].frame)

    def are_free(
        self, rows: Float64[np.ndarray, "n nq"], indices: Int64[np.ndarray, " n"]
    ) -> Bool[np.ndarray, " n"]:
        """Return which rows have all lines, and keep the rules on them, were the goal moved there.

        Args:
            rows: Configurations that are feasible themselves.
            indices: Which of the targets is moved to each.
        """
        return self._judged(rows, self._moved(rows, indices))

    def are_free_from(
        self, rows: Float64[np.ndarray, "n nq"], index: int
    ) -> Bool[np.ndarray, " n"]:
        """Return the same for a target that stays where it is."""
        return self._judged(rows, [self._targets[index].pose] * len(rows))

    def stop_of(self, q: Float64[np.ndarray, " nq"], index: int) -> LegStop | None:
        """Return what stops a line, were the goal moved there; None if nothing does."""
        poses = self._moved(q[None], np.array([index]))
        return self._judge(poses, Fineness()).stop_of(q, 0)

    def broken_by(self, q: Float64[np.ndarray, " nq"], index: int) -> tuple[str, ...]:
        """Return which rules the whole lines of q break, were the goal moved there."""
        judge = self._judge(self._moved(q[None], np.array([index])), Fineness())
        rules = self._query.rules
        if rules is None or not judge.admit(q[None], np.array([0]))[0]:
            return ()
        (legs,) = judge.legs_of(q[None], q[None])
        broken = [
            entry["constraint"]
            for leg in legs.all
            for row in leg.positions
            for entry in rules.violations(row)
        ]
        return tuple(dict.fromkeys(broken))

    def _moved(self, rows: Array, indices: Any) -> list[Pose]:
        reached = zip(*self._kinematics.poses(rows), strict=True)
        return [
            moved_along(self._targets[int(i)], Pose(p_WT, rotation.from_matrix(R_WT)))
            for i, (R_WT, p_WT) in zip(indices, reached, strict=True)
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

    def _judge(self, poses: list[Pose], fineness: Fineness) -> LegJudge:
        exact, frame = np.zeros(3), self._targets[0].frame
        targets = [ToolTarget(frame, pose, exact, exact) for pose in poses]
        return LegJudge(self._world, self._query, self._goal, targets, self._deadline, fineness)


def goal_lines(
    world: World, query: GoalQuery, targets: Sequence[Target], deadline: Deadline
) -> GoalLines | None:
    """Return the judge of lines near a goal, None if it asks for none."""
    goal = query.goal
    if not isinstance(goal, PoseGoal) or (goal.approach is None and goal.retreat is None):
        return None
    return GoalLines(world, query, goal, targets, deadline)
