"""search(): a path from the start to one of several goal configurations; entry of the stage.

A straight line to one of the nearest goals comes first. If there is none, or only one to a goal
much farther than the nearest, the guide and the roadmap are queried if there are any. If these have
no path, a planner searches for one. Its path is shortened and checked again, edge by edge, at a
quarter of the resolution of the search; if that finds a collision, the attempt starts anew with
half the resolution. The best of all attempts by `objective` is kept (see `solve_concurrently`).
"""

from contextlib import nullcontext

import numpy as np

from planning.domain.curves.path import JointPath
from planning.domain.report.search_report import SearchReport
from planning.domain.request.deadline import Deadline
from planning.domain.request.stopwatch import Stopwatch
from planning.domain.robot.joints import JointGroup, JointLimits
from planning.errors import Canceled, DeadlineExceeded, NoPathFound, ProblemInvalid
from planning.search.collision_oracle import CollisionOracle
from planning.search.multi_planner import solve_concurrently
from planning.search.ompl.graph import line_graph
from planning.search.query import Query, make_query
from planning.search.request import SearchResult, SearchTask
from planning.search.roadmap.query_roadmap import make_roadmap_report, query_roadmap
from planning.search.space_options import resolve_space
from planning.search.statistics import SearchStatistics
from planning.search.verified_path import (
    CheckResolution,
    VerifiedPath,
    fine_checker,
    make_verified_path,
    verify_path,
)

# A straight line is taken at once only if it is no longer than this factor times the distance to
# the nearest goal, plus a constant (joint-space length).
_MAX_DETOUR_FACTOR = 1.3
_DETOUR_ALLOWANCE = 0.5
# Number of goals to which straight lines are checked.
_MAX_STRAIGHT_LINES = 16

_REQUIREMENTS = {
    "start": "it must be one finite number per coordinate",
    "goal": "every row must be one finite number per coordinate",
    "search.resolution": "it must be positive",
    "search.attempts": "it must be at least 1",
    "search.num_states": "it must be at least 2",
    "search.planner": "it must name at least one planner",
    "search.setup_time": "it must be positive",
    "search.solve_time": "it must be positive",
    "search.shortcut_time": "it must not be negative",
    "search.interpolate_time": "it must not be negative",
    "seed": "it must not be negative",
}


def search(
    group: JointGroup,
    limits: JointLimits,
    oracle: CollisionOracle,
    task: SearchTask,
    deadline: Deadline,
    watch: Stopwatch | None = None,
) -> SearchResult:
    """Return a path from the start to one of the goals, free at a quarter of the resolution.

    The same arguments give the same bytes, as long as the deadline cuts nothing. OMPL's random
    numbers are global to the process, so there must be one search at a time in it. Where a planar
    or floating joint has no limits, only the first 10 m around the world's origin are searched.

    Not promised: the shortest path, or freedom between the checked states (the certifier's job).

    Args:
        group: The joints that move.
        limits: Their position limits.
        oracle: Collision oracle.
        task: Start, goals and options of the search.
        deadline: End of the search, by time or by a cancel.
        watch: Records the durations of "setup", "solve", "shortcut" and "interpolate".

    Raises:
        ProblemInvalid: A number in the task is out of range.
        UnknownName: There is no such planner, or it has no such parameter.
        NoPathFound: The planner ended without an exact solution.
        DeadlineExceeded: The time ran out before there was any path.
        Canceled: The request was canceled.
    """
    _validate_task(group, task)
    group = resolve_space(group, task.options.spaces)
    query, rows = make_query(group, limits, oracle, task, deadline, watch)
    fine = fine_checker(query, task.resolution)
    resolution = CheckResolution(task.resolution, task.options.num_states, fine, query.objective)
    # With one attempt the end of the search gives the same report.
    on_best = task.on_best if task.options.num_attempts > 1 else None
    statistics = SearchStatistics(on_best, straight_line=_straight_line(query, resolution))
    if statistics.best is None or _is_detour(statistics.best, query):
        _query_guide_roadmap_and_planners(query, resolution, task, statistics)
    best = statistics.best
    if best is None:
        raise _no_path_found(query, statistics)
    graph = statistics.graph
    if graph is None and task.options.keep_graph and best is statistics.straight_line:
        graph = line_graph(best.waypoints[[0, -1]])
    path = JointPath(group, best.waypoints)
    return SearchResult(
        path, int(rows[best.goal_row]), _report(query, resolution, task, statistics, best), graph
    )


def _query_guide_roadmap_and_planners(
    query: Query, resolution: CheckResolution, task: SearchTask, statistics: SearchStatistics
) -> None:
    """Query the guide and the roadmap if there are any, then the planners unless one has a path.

    If the search is interrupted, the best path recorded so far counts.

    Raises:
        Canceled: The request was canceled, and there is no path yet or it is not wanted.
        DeadlineExceeded: The time ran out before there was any path.
    """
    try:
        has_guided_path = _has_guided_path(query, resolution, task, statistics)
        if task.roadmap is not None and not has_guided_path:
            query_roadmap(task.roadmap, query, resolution, statistics)
        if not has_guided_path and not (statistics.roadmap and statistics.roadmap.used):
            solve_concurrently(query, resolution, task, statistics)
        statistics.was_canceled = query.is_canceled_keeping_best
    except Canceled:
        if query.options.on_cancel == "discard" or statistics.best is None:
            raise
        statistics.was_canceled = True
    except DeadlineExceeded as error:
        if statistics.best is not None:
            return
        statistics.record_failure_evidence(error.evidence)
        raise error.saying(error.detail, statistics.evidence(query)) from error


def _report(
    query: Query,
    resolution: CheckResolution,
    task: SearchTask,
    statistics: SearchStatistics,
    best: VerifiedPath,
) -> SearchReport:
    fine = resolution.fine
    roadmap = statistics.roadmap
    if roadmap is None and task.roadmap is not None:
        roadmap = make_roadmap_report(task.roadmap, "straight_line")
    return SearchReport(
        planner=statistics.best_planner or query.planner,
        attempts=statistics.num_attempts,
        solved=statistics.num_solved,
        num_states_checked=query.oracle.num_states,
        num_motions_checked=statistics.num_motions + fine.num_motions,
        raw_length=best.raw_length,
        length=best.length,
        num_waypoints=len(best.waypoints),
        resolution=fine.resolution,
        padding=task.padding,
        direct=best is statistics.straight_line,
        objective=task.options.objective,
        cost=best.cost,
        attempts_log=tuple(statistics.log),
        was_canceled=statistics.was_canceled,
        roadmap=roadmap,
        interpolated=best.is_interpolated,
    )


def _has_guided_path(
    query: Query, resolution: CheckResolution, task: SearchTask, statistics: SearchStatistics
) -> bool:
    """Return whether the task's guide has a path that is free; it is recorded then."""
    with query.watch.measure("guide") if task.guide else nullcontext():
        proposal = None if task.guide is None else task.guide.propose_path(query.goals)
    if task.guide is None or proposal is None:
        return False
    before = query.oracle.num_states
    trial = verify_path(query, resolution, *proposal)
    statistics.num_attempts += 1
    statistics.record(task.guide.name, trial, query.oracle.num_states - before)
    return trial.path is not None


def _is_detour(direct: VerifiedPath, query: Query) -> bool:
    """Return whether a path to a nearer goal may well be shorter than this straight line."""
    nearest = float(query.space.manifold.distance(query.goals[0], query.start))
    return direct.length > _MAX_DETOUR_FACTOR * nearest + _DETOUR_ALLOWANCE


def _validate_task(group: JointGroup, task: SearchTask) -> None:
    """Check that the numbers of a task are in range.

    Raises:
        ProblemInvalid: One is not; the message names it.
    """
    nq = group.num_positions
    options = task.options
    num_states = options.num_states
    faults = {
        "start": task.start.shape != (nq,) or not np.isfinite(task.start).all(),
        "goal": task.goals.shape[1:] != (nq,) or not np.isfinite(task.goals).all(),
        "search.resolution": not (np.isfinite(task.resolution) and task.resolution > 0),
        "search.attempts": options.attempts < 1,
        "search.num_states": num_states is not None and num_states < 2,
        "search.planner": not options.planners,
        "search.setup_time": options.setup_time is not None and not options.setup_time > 0,
        "search.solve_time": options.solve_time is not None and not options.solve_time > 0,
        "search.shortcut_time": options.shortcut_time is not None
        and not options.shortcut_time >= 0,
        "search.interpolate_time": options.interpolate_time is not None
        and not options.interpolate_time >= 0,
        "seed": task.seed < 0,
    }
    for field, is_fault in faults.items():
        if is_fault:
            raise ProblemInvalid(f"{field}: {_REQUIREMENTS[field]}", {"field": field})


def _straight_line(query: Query, resolution: CheckResolution) -> VerifiedPath | None:
    """Return the first free geodesic to one of the nearest goals."""
    for row, goal in enumerate(query.goals[:_MAX_STRAIGHT_LINES]):
        if resolution.fine.is_free(query.start, goal):
            waypoints = resolution.fine.local_path(query.start, goal)
            path = make_verified_path(query, waypoints, waypoints, row, resolution)
            if path is not None:
                return path
    return None


def _no_path_found(query: Query, statistics: SearchStatistics) -> NoPathFound:
    last_attempt, evidence = statistics.last_attempt, statistics.evidence(query)
    is_blocked = last_attempt is not None and len(last_attempt.waypoints) > 0
    why = (
        "its path collides when checked at the fine resolution"
        if is_blocked
        else "it ended without a solution"
    )
    advice = "more attempts, more samples or another planner may find one"
    if last_attempt is not None and last_attempt.failure_evidence.get("reason") == "setup":
        budget, setup_seconds = evidence["budget"], evidence["spent"]
        why = f"the planner's setup took {setup_seconds:.3g} s, its budget is {budget:g} s"
        advice = "raise search.setup_time"
    message = (
        f"{', '.join(query.options.planners)} found no path in {statistics.num_attempts} attempts: "
        f"{why}; {advice}"
    )
    return NoPathFound(message, evidence)
