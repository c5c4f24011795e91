"""ShorterMoves: shortened approach and retreat with which a blocked goal becomes feasible."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from planning.domain.arrays import Array
from planning.domain.goals.goal import PoseGoal, RegionGoal
from planning.domain.request.deadline import Deadline
from planning.domain.value import Value
from planning.goals.goal_query import GoalQuery
from planning.goals.lines.approach_checker import ApproachChecker
from planning.world.world import World

# Number of configurations tried, those whose lines get farthest.
_NUM_CANDIDATES = 8
# Share of the reached length that is suggested: the rest is a reserve for the next search.
_SUGGESTED_FRACTION = 0.98


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
    world: World, query: GoalQuery, checker: ApproachChecker, deadline: Deadline
) -> ShorterMoves | None:
    """Return the longest feasible lines of one checked configuration; None if none has any.

    Args:
        world: Loaded scene.
        query: Goal query whose goal has an approach or a retreat.
        checker: Checker that has traced the lines of the goal's configurations.
        deadline: Time limit; None is returned after it.
    """
    goal = query.goal
    assert isinstance(goal, PoseGoal | RegionGoal)  # noqa: S101  (no other goal has a judge)
    vectors = {"approach": goal.approach, "retreat": goal.retreat}
    requested = {name: vector for name, vector in vectors.items() if vector is not None}
    for target, q, fractions in _longest_traces(checker, requested):
        if deadline.is_over:
            return None
        scaled = {name: way * fractions[name] for name, way in requested.items()}
        remaining = {name: way if way.any() else None for name, way in scaled.items()}
        shorter = replace(goal, **remaining)
        shorter_checker = ApproachChecker(
            world, replace(query, goal=shorter), shorter, checker.targets, deadline
        )
        if (
            shorter_checker.check(q[None], np.array([target]))[0]
            and shorter_checker.moves_satisfy_constraints(q[None])[0]
        ):
            lengths = {name: float(np.linalg.norm(way)) for name, way in scaled.items()}
            return ShorterMoves(target, lengths, q)
    return None


def _longest_traces(
    checker: ApproachChecker, requested: dict[str, Array]
) -> list[tuple[int, Array, dict[str, float]]]:
    """Return targets, configurations and the free share of each line, longest lines first."""
    blocked_lines = sorted(checker.blocked_lines, key=lambda entry: -entry[2].fraction)[
        :_NUM_CANDIDATES
    ]
    candidates: list[tuple[int, Array, dict[str, float]]] = []
    for name, target, trace_state in blocked_lines:
        q, reached_fractions = trace_state.waypoints[0], {name: trace_state.fraction}
        for other_name in requested.keys() - reached_fractions.keys():
            (other_state,) = checker.trace(other_name, q[None], np.array([target]))
            reached_fractions[other_name] = other_state.fraction
        fractions = {
            move_name: fraction if fraction == 1 else _SUGGESTED_FRACTION * fraction
            for move_name, fraction in reached_fractions.items()
        }
        if any(fractions.values()):
            candidates.append((target, q, fractions))
    lengths = {name: float(np.linalg.norm(vector)) for name, vector in requested.items()}
    candidates.sort(
        key=lambda entry: -sum(lengths[move] * share for move, share in entry[2].items())
    )
    return candidates
