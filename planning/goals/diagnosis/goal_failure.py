"""Failure of a goal without configuration: unreachable, in collision or approach blocked.

The evidence of the error has the nearest feasible pose and sufficient relaxations.
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from planning.domain.arrays import Array
from planning.domain.goals.funnel import LinearMoveTally, PairTally, funnel_evidence
from planning.domain.request.deadline import Deadline
from planning.domain.robot.manifold import Manifold
from planning.errors import ApproachBlocked, GoalInCollision, GoalTooNear, GoalUnreachable
from planning.goals.diagnosis.collision_tally import count_collisions
from planning.goals.diagnosis.relaxation import shallowest_collision
from planning.goals.diagnosis.relaxed_search import sufficient_removal
from planning.goals.diagnosis.suggestions import suggest_nearest_pose
from planning.goals.goal_query import GoalQuery
from planning.goals.ik.pose_search import PoseSearch
from planning.goals.lines.shorter_moves import shorter_moves
from planning.goals.ranking import UniqueSolutions
from planning.goals.start_validation import describe_pairs, pair_evidence
from planning.goals.targets.target_selection import TargetSelection
from planning.world.world import World

# Largest number of colliding configurations measured for the evidence.
_MAX_MEASURED = 256
# Largest number of distinct ones among them, used as hints and for relaxations.
_NUM_DISTINCT = 32
# Share of the remaining time for goals that searches with a body removed may take.
_REMOVAL_TIME_FRACTION = 0.3


def goal_failure(
    world: World,
    query: GoalQuery,
    selection: TargetSelection,
    search: PoseSearch,
    rng: np.random.Generator,
    deadline: Deadline,
) -> ApproachBlocked | GoalInCollision | GoalTooNear | GoalUnreachable:
    """Return the failure of a search: unreachable, reachable only in collision, or blocked lines.

    The evidence has the nearest free pose, and relaxations each of which is sufficient.

    Args:
        world: Loaded scene, with the joint limits under the query's path constraints.
        query: Goal query.
        selection: Target selection of the goal.
        search: Finished search without result.
        rng: Random generator of the attempts.
        deadline: Time limit of the diagnosis.
    """
    funnel = search.funnel(())
    if funnel.collision_free > 0 and search.checker is not None:
        return _approach_failure(world, query, selection, search, rng, deadline)
    hints = _distinct(query, search.colliding)
    evidence, suggestion = suggest_nearest_pose(world, query, selection, hints, rng, deadline)
    if search.colliding:
        return collision_failure(world, query, search, deadline, evidence, suggestion)
    message = (
        f"no configuration of {query.group.name} brings {selection.accepted[0].frame} to the goal"
        f"{suggestion}"
    )
    return GoalUnreachable(message, {"funnel": funnel_evidence(funnel), **evidence})


def collision_failure(
    world: World,
    query: GoalQuery,
    search: PoseSearch,
    deadline: Deadline,
    evidence: Mapping[str, Any] = MappingProxyType({}),
    suggestion: str = "",
) -> GoalInCollision | GoalTooNear:
    """Return the failure of a goal all of whose configurations collide or violate margins.

    It is `GoalInCollision` only if bodies overlap in all configurations that were measured.

    Args:
        world: Loaded scene.
        query: Goal query.
        search: Finished search with colliding solutions.
        deadline: Time limit of the measurements.
        evidence: Further evidence; obstacles are added to its `relaxation`.
        suggestion: Text of that evidence, appended to the message.
    """
    rows = _distinct(query, search.colliding)
    tally = count_collisions(
        world, query, search.colliding, max(_MAX_MEASURED, query.num_measured), deadline
    )
    funnel = search.funnel(tally.summary)
    relaxation = dict(evidence.get("relaxation", {}))
    is_margin_only = tally.num_margin_only > 0
    text = "violate margins" if is_margin_only else "collide"
    message = f"all {funnel.within_limits} configurations that reach the goal {text}"
    verb = "violate the margin of" if is_margin_only else "hit"
    message += _describe_tallies(funnel.rejected_by, verb, is_cut_short=deadline.is_over)
    if query.constraints is not None:
        rows = rows[query.constraints.are_satisfied(rows)]
    if len(rows):
        q, pairs = shallowest_collision(world, query, rows)
        relaxation["obstacles"] = pair_evidence(pairs, query.margins)
        relaxation["positions"] = q.tolist()
        kind = "smallest margin violation" if is_margin_only else "shallowest collision"
        message += f"; the {kind} is {describe_pairs(pairs, query.margins)}"
    if is_margin_only:
        message += f"; in {tally.num_margin_only} of them no bodies overlap"
    evidence = {**evidence, "funnel": funnel_evidence(funnel), "relaxation": relaxation}
    failure = GoalTooNear if is_margin_only else GoalInCollision
    return failure(message + suggestion, evidence)


def _describe_tallies(tallies: tuple[PairTally, ...], verb: str, *, is_cut_short: bool) -> str:
    if not tallies:
        return ""
    text = ", ".join(
        f"{tally.count} {verb} {'-'.join(tally.bodies)} by {1000 * tally.min_depth:.1f} to "
        f"{1000 * tally.max_depth:.1f} mm"
        for tally in tallies[:3]
    )
    measured = sum(tally.count for tally in tallies)
    return f": of the {measured} measured in time {text}" if is_cut_short else f": {text}"


def _approach_failure(
    world: World,
    query: GoalQuery,
    selection: TargetSelection,
    search: PoseSearch,
    rng: np.random.Generator,
    deadline: Deadline,
) -> ApproachBlocked:
    funnel, checker = search.funnel(()), search.checker
    assert checker is not None  # noqa: S101  (something was blocked)
    text = ", ".join(map(_describe_blocked, funnel.blocked_by[:3]))
    message = f"no goal configuration has a free approach and retreat: {text}"
    shorter = shorter_moves(world, query, checker, deadline)
    if shorter is not None:
        lengths = " and ".join(
            f"{1000 * m:.1f} mm of {move_name}" for move_name, m in shorter.lengths.items()
        )
        message += f"; with {lengths} a goal configuration exists"
    removal = sufficient_removal(
        world, query, search, rng, deadline.at_fraction(_REMOVAL_TIME_FRACTION)
    )
    if removal is not None:
        message += f"; without {removal['body']} a goal configuration exists"
    hints = _distinct(query, search.blocked.rows)
    evidence, text = suggest_nearest_pose(world, query, selection, hints, rng, deadline)
    lengths = {"approach": None, "retreat": None, "pose_index": None}
    relaxation = {**evidence["relaxation"], **lengths, **(shorter.evidence if shorter else {})}
    evidence = {"nearest": evidence["nearest"], "relaxation": {**relaxation, "remove": removal}}
    return ApproachBlocked(message + text, {"funnel": funnel_evidence(funnel), **evidence})


def _describe_blocked(tally: LinearMoveTally) -> str:
    reason = {
        "collision": f"a collision of {tally.where}",
        "limit": f"the limit of {tally.where}",
        "singularity": "a singularity",
        "unreachable": "a direction in which the joints cannot move the tool",
    }[tally.reason]
    return (
        f"the {tally.move} is blocked {tally.count} times by {reason} "
        f"(at most {100 * tally.max_fraction:.0f} % of its length is free)"
    )


def _distinct(query: GoalQuery, configurations: list[Array] | Array) -> Array:
    """Return up to `_NUM_DISTINCT` distinct configurations of some infeasible ones."""
    rows = np.reshape(configurations[:_MAX_MEASURED], (-1, query.group.num_positions))
    unique = UniqueSolutions(query.group, Manifold(query.group.joints))
    return rows[unique.are_new(rows, np.zeros(len(rows), dtype=np.int64))][:_NUM_DISTINCT]
