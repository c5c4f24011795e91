"""ShorterMoves: shortened approach and retreat with which a blocked goal becomes feasible."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from planning.domain.arrays import Array
from planning.domain.goals.goal import PoseGoal, RegionGoal
from planning.domain.request.deadline import Deadline
from planning.domain.value import Value
from planning.goals.goal_query import GoalQuery
from planning.goals.lines.approach import ApproachChecker
from planning.world.world import World

# Number of configurations tried, those whose lines get farthest.
_NUM_ASKED = 8
# Share of the reached length that is suggested: the rest is a reserve for the next search.
_TOLD = 0.98


@dataclass(frozen=True, eq=False)
class ShorterMoves(Value):
    """Feasible lengths of the approach and the retreat of one goal configuration.

    Attributes:
        pose_index: Index of the candidate pose that it reaches.
        lengths: Length [m] by name, "approach" and "retreat", of the requested ones; 0 for a line
            to be left out.
        positions: Goal configuration, shape (nq,).
    """

    pose_index: int
    lengths: dict[str, float]
    positions: Array

    @property
    def evidence(self) -> dict[str, Any]:
        """Plain values for the evidence of a failure."""
        return {
            "approach": self.lengths.get("approach"),
            "retreat": self.lengths.get("retreat"),
            "pose_index": self.pose_index,
            "positions": self.positions.tolist(),
        }


def shorter_moves(
    world: World, query: GoalQuery, judge: ApproachChecker, deadline: Deadline
) -> ShorterMoves | None:
    """Return the longest feasible lines of one checked configuration; None if none has any.

    Args:
        world: Loaded scene.
        query: Goal query whose goal has an approach or a retreat.
        judge: Checker that has traced the lines of the goal's configurations.
        deadline: Time limit; None is returned after it.
    """
    goal = query.goal
    assert isinstance(goal, PoseGoal | RegionGoal)  # noqa: S101  (no other goal has a judge)
    ways = {"approach": goal.approach, "retreat": goal.retreat}
    asked = {name: way for name, way in ways.items() if way is not None}
    for target, q, shares in _farthest(judge, asked):
        if deadline.is_over:
            return None
        scaled = {name: way * shares[name] for name, way in asked.items()}
        left = {name: way if way.any() else None for name, way in scaled.items()}
        shorter = replace(goal, **left)
        again = ApproachChecker(
            world, replace(query, goal=shorter), shorter, judge.targets, deadline
        )
        if again.admit(q[None], np.array([target]))[0] and again.keep_rules(q[None])[0]:
            lengths = {name: float(np.linalg.norm(way)) for name, way in scaled.items()}
            return ShorterMoves(target, lengths, q)
    return None


def _farthest(
    judge: ApproachChecker, asked: dict[str, Array]
) -> list[tuple[int, Array, dict[str, float]]]:
    """Return targets, configurations and the free share of each line, longest lines first."""
    ended = sorted(judge.ended, key=lambda entry: -entry[2].at)[:_NUM_ASKED]
    found: list[tuple[int, Array, dict[str, float]]] = []
    for name, target, course in ended:
        q, reached = course.waypoints[0], {name: course.at}
        for other in asked.keys() - reached.keys():
            (line,) = judge.reach(other, q[None], np.array([target]))
            reached[other] = line.at
        shares = {leg: share if share == 1 else _TOLD * share for leg, share in reached.items()}
        if any(shares.values()):
            found.append((target, q, shares))
    lengths = {name: float(np.linalg.norm(way)) for name, way in asked.items()}
    found.sort(key=lambda entry: -sum(lengths[leg] * share for leg, share in entry[2].items()))
    return found
