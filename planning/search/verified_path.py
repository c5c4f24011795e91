"""VerifiedPath: a path whose edges are free at a finer resolution than the planner's.

A planner's edge may pass a thin obstacle between two samples. So a path is checked at the fine
resolution before it is returned; where that check finds a collision that cannot be avoided, the
planner starts anew with half the resolution, until it checks as finely itself.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float64

from planning.domain.value import Value
from planning.search.cars.drive_shortcut import shortened_drive
from planning.search.cars.steering_edges import SteeringEdgeChecker
from planning.search.edges import EdgeChecker
from planning.search.ompl.attempt import Array, Attempt, attempt
from planning.search.ompl.objective import Objective
from planning.search.query import Query
from planning.search.shortcut.polyline import path_length, unrolled
from planning.search.shortcut.repair import repair_path
from planning.search.shortcut.resampling import interpolated
from planning.search.shortcut.shortcut_path import shortcut

# Factor by which results are checked more finely than the search, and halvings up to it.
FINER = 4
_HALVINGS = 2
# Share of the remaining time that shortcutting may use; the rest is for the final check.
_SHORTCUT_SHARE = 0.7


@dataclass(frozen=True)
class CheckResolution:
    """Resolutions of the search and of the final check.

    Attributes:
        resolution: Resolution at which the planner begins to check edges (joint-space length).
        num_states: Least number of waypoints, or None.
        fine: Checker of edges at a quarter of that resolution.
        objective: Cost of paths.
    """

    resolution: float
    num_states: int | None
    fine: EdgeChecker
    objective: Objective


@dataclass(frozen=True, eq=False)
class VerifiedPath(Value):
    """Path whose every edge is free at the fine resolution.

    Attributes:
        waypoints: Shape (n, nq).
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
        last: The planner's last result.
        path: The verified path, or None.
        num_motions: Edges that the planner checked.
    """

    last: Attempt
    path: VerifiedPath | None
    num_motions: int


def coarse_checker(query: Query, resolution: float) -> EdgeChecker:
    """Return the edge checker of planners, for a search at `resolution`."""
    return query.space.checker(query.oracle, resolution, query.objective.norm)


def fine_checker(query: Query, resolution: float) -> EdgeChecker:
    """Return the edge checker of results, for a search at `resolution`."""
    return coarse_checker(query, resolution / FINER)


def followed(
    query: Query, closeness: CheckResolution, raw: Array, goal_row: int
) -> VerificationTrial:
    """Shorten and check a path from another source than a planner, shape (n, nq).

    Raises:
        Canceled: The request was canceled.
        DeadlineExceeded: The time has run out.
    """
    edges = coarse_checker(query, closeness.resolution)
    found = Attempt("Exact solution", raw, goal_row, {}, None, is_spent=False)
    return VerificationTrial(found, shortened(query, found, edges, closeness), edges.num_motions)


def verified_attempt(
    query: Query, closeness: CheckResolution, seeds: np.random.SeedSequence
) -> VerificationTrial:
    """Search, shorten and check; repeat with half the resolution if the check finds a collision.

    Raises:
        Canceled: The request was canceled.
        DeadlineExceeded: The time has run out.
    """
    num_motions = halvings = 0
    while True:
        child = seeds.spawn(1)[0]
        edges = coarse_checker(query, closeness.resolution / 2**halvings)
        seed = max(1, int(child.generate_state(1)[0]))
        found = attempt(query, edges, closeness.fine, seed)
        path = shortened(query, found, edges, closeness)
        num_motions += edges.num_motions
        if path is None and len(found.waypoints) and (found.improves or query.is_hurried):
            path = _mended(query, found, closeness, seed)
        if path is not None or not len(found.waypoints) or halvings == _HALVINGS:
            return VerificationTrial(found, path, num_motions)
        halvings += 1


def _mended(
    query: Query, found: Attempt, closeness: CheckResolution, seed: int
) -> VerifiedPath | None:
    raw = repair_path(query, found.waypoints, closeness.fine, seed)
    if raw is None:
        return None
    return shortened(query, replace(found, waypoints=raw), closeness.fine, closeness)


def shortened(
    query: Query, found: Attempt, coarse: EdgeChecker, closeness: CheckResolution
) -> VerifiedPath | None:
    """Return a shorter path that is free at the fine resolution, if there is one.

    After a cancel with the option "best" the path is only checked.
    """
    if not len(found.waypoints):
        return None
    is_late = _shortcut_end(query)
    raw, fine = found.waypoints, closeness.fine
    with query.watch.stage("shortcut"), query.oracle.until(query.patience):
        if isinstance(fine, SteeringEdgeChecker):
            shorter = shortened_drive(raw, fine, is_late)
        else:
            shorter = shortcut(raw, coarse, fine, is_late)
        if shorter is None:
            return None
        path = unrolled(shorter, query.space.manifold)
        best = delivered(query, path, raw, found.goal_row, closeness)
        if query.objective.name == "clearance" and fine.are_free(raw[:-1], raw[1:]).all():
            # A shorter path may be nearer to obstacles.
            untouched = delivered(query, raw, raw, found.goal_row, closeness)
            both = [path for path in (best, untouched) if path is not None]
            best = min(both, key=lambda path: path.cost, default=None)
    return best


def _shortcut_end(query: Query) -> Callable[[], bool]:
    """Return a function that says whether the time for shortcutting is over."""
    seconds = query.options.shortcut_time
    time = query.deadline.share(_SHORTCUT_SHARE).within(seconds)
    # A budget of zero means no shortcuts by request, not a cut by the clock.
    return (lambda: True) if seconds == 0 else (lambda: time.is_over)


def delivered(
    query: Query, waypoints: Array, raw: Array, goal_row: int, closeness: CheckResolution
) -> VerifiedPath | None:
    """Return the path with the requested number of waypoints; None if a new edge is blocked.

    Args:
        query: Its options bound the time for adding waypoints.
        waypoints: A path of edges that are free at the fine resolution, shape (n, nq).
        raw: The path before shortcutting, shape (m, nq).
        goal_row: Row of the goal in which it ends.
        closeness: Resolutions and number of waypoints.
    """
    fine = closeness.fine
    objective = closeness.objective
    lengths = path_length(raw, fine.manifold), path_length(waypoints, fine.manifold)
    cost = lengths[1] if objective.is_length else objective.cost(waypoints)
    path = VerifiedPath(waypoints, goal_row, *lengths, cost)
    if closeness.num_states is None:
        return path
    dense = interpolated(query, fine, waypoints, closeness.num_states)
    return dense and replace(path, waypoints=dense[0], is_interpolated=dense[1])
