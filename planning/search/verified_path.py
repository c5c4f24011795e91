"""VerifiedPath: a path whose edges are free at a finer resolution than the planner's.

A planner's edge may pass a thin obstacle between two samples. So a path is checked at the fine
resolution before it is returned; where that check finds a collision that cannot be avoided, the
planner starts anew with half the resolution, until it checks as finely itself.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.value import Value
from planning.search.cars.steering_edges import SteeringEdgeChecker
from planning.search.cars.steering_shortcut import shortcut_steering_path
from planning.search.edges import EdgeChecker
from planning.search.ompl.objective import Objective
from planning.search.ompl.run_planner import Attempt, run_planner
from planning.search.query import Query
from planning.search.shortcut.polyline import path_length, unwrap
from planning.search.shortcut.repair import repair_path
from planning.search.shortcut.resampling import resample_within_budget
from planning.search.shortcut.shortcut_path import shortcut

# Factor by which results are checked more finely than the search, and halvings up to it.
FINE_FACTOR = 4
_MAX_HALVINGS = 2
# Share of the remaining time that shortcutting may use; the rest is for the final check.
_SHORTCUT_TIME_FRACTION = 0.7


@dataclass(frozen=True)
class CheckResolution:
    """Resolutions of the search and of the final check.

    Attributes:
        search_resolution: Resolution at which the planner begins to check edges (joint-space
            length).
        num_states: Least number of waypoints, or None.
        fine: Checker of edges at a quarter of that resolution.
        objective: Cost of paths.
    """

    search_resolution: float
    num_states: int | None
    fine: EdgeChecker
    objective: Objective


@dataclass(frozen=True, eq=False)
class VerifiedPath(Value):
    """Path whose every edge is free at the fine resolution.

    Attributes:
        waypoints: From start to goal, shape (n, nq).
        goal_row: Row of the goal in which it ends.
        raw_length: Length before shortcutting.
        length: Length after shortcutting.
        cost: Cost by the objective.
        is_interpolated: Whether it has the requested number of waypoints.
    """

    waypoints: Float64[np.ndarray, "n nq"]
    goal_row: int
    raw_length: float
    length: float
    cost: float
    is_interpolated: bool = True


@dataclass(frozen=True, eq=False)
class VerificationTrial(Value):
    """Result of one attempt, its repetitions at finer resolutions included.

    Attributes:
        attempt: The planner's last result.
        path: The verified path, or None.
        num_motions: Edges that the planner checked.
    """

    attempt: Attempt
    path: VerifiedPath | None
    num_motions: int


def coarse_checker(query: Query, resolution: float) -> EdgeChecker:
    """Return the edge checker of planners, for a search at `resolution`."""
    objective = query.objective
    norm = None if objective.is_euclidean else objective.norm
    return query.space.checker(query.oracle, resolution, norm)


def fine_checker(query: Query, resolution: float) -> EdgeChecker:
    """Return the edge checker of results, for a search at `resolution`."""
    return coarse_checker(query, resolution / FINE_FACTOR)


def verify_path(
    query: Query, resolution: CheckResolution, raw: Array, goal_row: int
) -> VerificationTrial:
    """Shorten and check a path from another source than a planner, shape (n, nq).

    Raises:
        Canceled: The request was canceled.
        DeadlineExceeded: The time has run out.
    """
    edges = coarse_checker(query, resolution.search_resolution)
    attempt_result = Attempt("Exact solution", raw, goal_row, {}, None, has_given_up=False)
    path = shorten_and_verify(query, attempt_result, edges, resolution)
    return VerificationTrial(attempt_result, path, edges.num_motions)


def verified_attempt(
    query: Query, resolution: CheckResolution, seeds: np.random.SeedSequence
) -> VerificationTrial:
    """Search, shorten and check; repeat with half the resolution if the check finds a collision.

    Raises:
        Canceled: The request was canceled.
        DeadlineExceeded: The time has run out.
    """
    num_motions = halvings = 0
    while True:
        child = seeds.spawn(1)[0]
        edges = coarse_checker(query, resolution.search_resolution / 2**halvings)
        seed = max(1, int(child.generate_state(1)[0]))
        attempt_result = run_planner(query, edges, resolution.fine, seed)
        path = shorten_and_verify(query, attempt_result, edges, resolution)
        num_motions += edges.num_motions
        if (
            path is None
            and len(attempt_result.waypoints)
            and (attempt_result.is_optimizing or query.is_canceled_keeping_best)
        ):
            path = _repaired(query, attempt_result, resolution, seed)
        if path is not None or not len(attempt_result.waypoints) or halvings == _MAX_HALVINGS:
            return VerificationTrial(attempt_result, path, num_motions)
        halvings += 1


def _repaired(
    query: Query, attempt_result: Attempt, resolution: CheckResolution, seed: int
) -> VerifiedPath | None:
    raw = repair_path(query, attempt_result.waypoints, resolution.fine, seed)
    if raw is None:
        return None
    return shorten_and_verify(
        query, replace(attempt_result, waypoints=raw), resolution.fine, resolution
    )


def shorten_and_verify(
    query: Query, attempt_result: Attempt, coarse: EdgeChecker, resolution: CheckResolution
) -> VerifiedPath | None:
    """Return a shorter path that is free at the fine resolution, if there is one.

    After a cancel with the option "best" the path is only checked.
    """
    if not len(attempt_result.waypoints):
        return None
    is_over = _shortcut_end(query)
    raw, fine = attempt_result.waypoints, resolution.fine
    with query.watch.stage("shortcut"), query.oracle.with_deadline(query.completion_deadline):
        if isinstance(fine, SteeringEdgeChecker):
            shorter = shortcut_steering_path(raw, fine, is_over)
        else:
            shorter = shortcut(raw, coarse, fine, is_over)
        if shorter is None:
            return None
        path = unwrap(shorter, query.space.manifold)
        best = make_verified_path(query, path, raw, attempt_result.goal_row, resolution)
        if query.objective.name == "clearance" and fine.are_free(raw[:-1], raw[1:]).all():
            # A shorter path may be nearer to obstacles.
            unshortened = make_verified_path(query, raw, raw, attempt_result.goal_row, resolution)
            both = [path for path in (best, unshortened) if path is not None]
            best = min(both, key=lambda path: path.cost, default=None)
    return best


def _shortcut_end(query: Query) -> Callable[[], bool]:
    """Return a function that says whether the time for shortcutting is over."""
    seconds = query.options.shortcut_time
    shortcut_deadline = query.deadline.at_fraction(_SHORTCUT_TIME_FRACTION).within(seconds)
    # A budget of zero means no shortcuts by request, not a cut by the clock.
    return (lambda: True) if seconds == 0 else (lambda: shortcut_deadline.is_over)


def make_verified_path(
    query: Query, waypoints: Array, raw: Array, goal_row: int, resolution: CheckResolution
) -> VerifiedPath | None:
    """Return the path with the requested number of waypoints; None if a new edge is blocked.

    Args:
        query: Its options bound the time for adding waypoints.
        waypoints: A path of edges that are free at the fine resolution, shape (n, nq).
        raw: The path before shortcutting, shape (m, nq).
        goal_row: Row of the goal in which it ends.
        resolution: Resolutions and number of waypoints.
    """
    fine = resolution.fine
    objective = resolution.objective
    lengths = path_length(raw, fine.manifold), path_length(waypoints, fine.manifold)
    cost = lengths[1] if objective.is_length else objective.cost(waypoints)
    path = VerifiedPath(waypoints, goal_row, *lengths, cost)
    if resolution.num_states is None:
        return path
    dense = resample_within_budget(query, fine, waypoints, resolution.num_states)
    return dense and replace(path, waypoints=dense[0], is_interpolated=dense[1])
