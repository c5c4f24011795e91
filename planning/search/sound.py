"""A path that stays free when it is looked at more closely than the planner looked.

A planner's edge may pass a thin obstacle between two samples, and what shortcutting leaves of an
edge is sampled elsewhere. So the whole path is checked at the fine resolution; where that finds a
collision, the planner starts anew and checks its edges with half the resolution, until it looks
as closely as the final check does.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from jaxtyping import Float64

from planning.domain.value import Value
from planning.search.attempt import Array, Attempt, Query, attempt
from planning.search.densify import densified
from planning.search.edges import EdgeChecker
from planning.search.shortcut import path_length, shortcut

# How much finer than the search the result is checked, and the halvings that lead there.
_FINER = 4
_HALVINGS = 2
# Of the time that is left, what shortcutting may use; the rest is for the final check.
_SHORTCUT_SHARE = 0.7


@dataclass(frozen=True)
class Closeness:
    """How closely to look.

    Attributes:
        resolution: At which the planner begins to check edges.
        num_states: Least number of waypoints, or None.
        fine: Checks edges at a quarter of the resolution, and remembers those that are free.
    """

    resolution: float
    num_states: int | None
    fine: EdgeChecker


@dataclass(frozen=True, eq=False)
class SoundPath(Value):
    """A path whose every edge is free at the fine resolution.

    Attributes:
        waypoints: Shape (n, nq).
        goal_row: The goal that it ends in.
        raw_length: Before shortcutting.
        length: And after it.
    """

    waypoints: Float64[np.ndarray, "n nq"]
    goal_row: int
    raw_length: float
    length: float


@dataclass(frozen=True, eq=False)
class Trial(Value):
    """What came of one attempt, its repetitions included.

    Attributes:
        last: The planner's last answer.
        path: What was made of it, or None.
        num_motions: Edges that the planner checked.
    """

    last: Attempt
    path: SoundPath | None
    num_motions: int


def fine_checker(query: Query, resolution: float) -> EdgeChecker:
    """Return what checks results, for a search at `resolution`."""
    return EdgeChecker(query.space.manifold, query.oracle, resolution / _FINER)


def sound_attempt(query: Query, closeness: Closeness, seeds: np.random.SeedSequence) -> Trial:
    """Search, shorten and check, again with half the resolution if that finds a collision.

    Raises:
        Canceled: Somebody asked for the end.
        DeadlineExceeded: The time has run out.
    """
    num_motions = halvings = 0
    while True:
        child = seeds.spawn(1)[0]
        edges = EdgeChecker(query.space.manifold, query.oracle, closeness.resolution / 2**halvings)
        found = attempt(query, edges, max(1, int(child.generate_state(1)[0])))
        path = _shortened(query, found, edges, closeness, np.random.default_rng(child.spawn(1)[0]))
        num_motions += edges.num_motions
        if path is None and halvings == _HALVINGS and len(found.waypoints):
            path = checked(found.waypoints, found.waypoints, found.goal_row, closeness)
        if path is not None or not len(found.waypoints) or halvings == _HALVINGS:
            return Trial(found, path, num_motions)
        halvings += 1


def _shortened(
    query: Query,
    found: Attempt,
    edges: EdgeChecker,
    closeness: Closeness,
    rng: np.random.Generator,
) -> SoundPath | None:
    """Return a shorter path; shortcuts are as coarse as the search unless that proves too bold."""
    if not len(found.waypoints):
        return None
    for checker in (edges, closeness.fine):
        time = query.deadline.share(_SHORTCUT_SHARE)
        with query.watch.stage("shortcut"):
            shorter = shortcut(found.waypoints, checker, rng, lambda at=time: at.is_over)
            path = checked(shorter, found.waypoints, found.goal_row, closeness)
        if path is not None:
            return path
    return None


def checked(waypoints: Array, raw: Array, goal_row: int, closeness: Closeness) -> SoundPath | None:
    """Return the path with enough waypoints if it is free at the fine resolution.

    Args:
        waypoints: What is to be delivered, shape (n, nq).
        raw: What it was made of, shape (m, nq).
        goal_row: Where it ends.
        closeness: How closely to look.
    """
    fine = closeness.fine
    length = path_length(waypoints, fine)
    if closeness.num_states is not None:
        waypoints = densified(fine, waypoints, closeness.num_states)
    if not all(fine.is_known_free(q0, q1) for q0, q1 in pairwise(waypoints)):
        return None
    return SoundPath(waypoints, goal_row, path_length(raw, fine), length)
