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
from planning.search.query import Query, query_of
from planning.search.request import SearchResult, SearchTask
from planning.search.roadmap.query_roadmap import query_roadmap, report_of
from planning.search.space_options import resolve_space
from planning.search.statistics import SearchStatistics
from planning.search.verified_path import (
    CheckResolution,
    VerifiedPath,
    delivered,
    fine_checker,
    followed,
)

# A straight line is taken at once only if it is no longer than this factor times the distance to
# the nearest goal, plus a constant (joint-space length).
_DETOUR = 1.3
_NEAR = 0.5
# Number of goals to which straight lines are checked.
_MOST_LINES = 16

_FIELDS = {
    "start": "one finite number per coordinate is needed",
    "goal": "one finite number per coordinate is needed in every row",
    "search.resolution": "it must be positive",
    "search.attempts": "at least 1 is needed",
    "search.num_states": "at least 2 are needed",
    "search.planner": "at least one is needed",
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
        DeadlineExceeded: The time ran out before there was any.
        Canceled: The request was canceled.
    """
    _require_sense(group, task)
    group = resolve_space(group, task.options.spaces)
    query, rows = query_of(group, limits, oracle, task, deadline, watch)
    fine = fine_checker(query, task.resolution)
    closeness = CheckResolution(task.resolution, task.options.num_states, fine, query.objective)
    # With one attempt the end of the search gives the same report.
    on_best = task.on_best if task.options.num_attempts > 1 else None
    tally = SearchStatistics(on_best, direct=_straight_line(query, closeness))
    if tally.best is None or _is_detour(tally.best, query):
        _look(query, closeness, task, tally)
    best = tally.best
    if best is None:
        raise _no_path(query, tally)
    graph = tally.graph
    if graph is None and task.options.keep_graph and best is tally.direct:
        graph = line_graph(best.waypoints[[0, -1]])
    path = JointPath(group, best.waypoints)
    return SearchResult(
        path, int(rows[best.goal_row]), _report(query, closeness, task, tally, best), graph
    )


def _look(
    query: Query, closeness: CheckResolution, task: SearchTask, tally: SearchStatistics
) -> None:
    """Query the guide and the roadmap if there are any, then the planners unless one has a path.

    If the search is interrupted, the best path recorded so far counts.

    Raises:
        Canceled: The request was canceled, and there is no path yet or it is not wanted.
        DeadlineExceeded: The time ran out before there was any path.
    """
    try:
        is_led = _is_led(query, closeness, task, tally)
        if task.roadmap is not None and not is_led:
            query_roadmap(task.roadmap, query, closeness, tally)
        if not is_led and not (tally.roadmap and tally.roadmap.used):
            solve_concurrently(query, closeness, task, tally)
        tally.was_canceled = query.is_hurried
    except Canceled:
        if query.options.on_cancel == "discard" or tally.best is None:
            raise
        tally.was_canceled = True
    except DeadlineExceeded as error:
        if tally.best is not None:
            return
        tally.note_growth(error.evidence)
        raise error.saying(error.detail, tally.evidence(query)) from error


def _report(
    query: Query,
    closeness: CheckResolution,
    task: SearchTask,
    tally: SearchStatistics,
    best: VerifiedPath,
) -> SearchReport:
    fine = closeness.fine
    roadmap = tally.roadmap
    if roadmap is None and task.roadmap is not None:
        roadmap = report_of(task.roadmap, "straight_line")
    return SearchReport(
        planner=tally.winner or query.planner,
        attempts=tally.num_attempts,
        solved=tally.num_solved,
        num_states_checked=query.oracle.num_states,
        num_motions_checked=tally.num_motions + fine.num_motions,
        raw_length=best.raw_length,
        length=best.length,
        num_waypoints=len(best.waypoints),
        resolution=fine.resolution,
        padding=task.padding,
        direct=best is tally.direct,
        objective=task.options.objective,
        cost=best.cost,
        attempts_log=tuple(tally.log),
        was_canceled=tally.was_canceled,
        roadmap=roadmap,
        interpolated=best.is_interpolated,
    )


def _is_led(
    query: Query, closeness: CheckResolution, task: SearchTask, tally: SearchStatistics
) -> bool:
    """Return whether the task's guide has a path that is free; it is recorded then."""
    with query.watch.note("guide") if task.guide else nullcontext():
        found = None if task.guide is None else task.guide.lead(query.goals)
    if task.guide is None or found is None:
        return False
    before = query.oracle.num_states
    trial = followed(query, closeness, *found)
    tally.num_attempts += 1
    tally.note(task.guide.name, trial, query.oracle.num_states - before)
    return trial.path is not None


def _is_detour(direct: VerifiedPath, query: Query) -> bool:
    """Return whether a path to a nearer goal may well be shorter than this straight line."""
    nearest = float(query.space.manifold.distance(query.goals[0], query.start))
    return direct.length > _DETOUR * nearest + _NEAR


def _require_sense(group: JointGroup, task: SearchTask) -> None:
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
            raise ProblemInvalid(f"{field} makes no sense: {_FIELDS[field]}", {"field": field})


def _straight_line(query: Query, closeness: CheckResolution) -> VerifiedPath | None:
    """Return the first free geodesic to one of the nearest goals."""
    for row, goal in enumerate(query.goals[:_MOST_LINES]):
        if closeness.fine.is_free(query.start, goal):
            waypoints = closeness.fine.way(query.start, goal)
            path = delivered(query, waypoints, waypoints, row, closeness)
            if path is not None:
                return path
    return None


def _no_path(query: Query, tally: SearchStatistics) -> NoPathFound:
    last, evidence = tally.last, tally.evidence(query)
    blocked = last is not None and len(last.waypoints) > 0
    why = "what it found collides on a closer look" if blocked else "it ended without a solution"
    advice = "more attempts, more samples or another planner may find one"
    if last is not None and last.growth.get("reason") == "setup":
        budget, spent = evidence["budget"], evidence["spent"]
        why = f"setting the last one up took {spent:.3g} s of the {budget:g} s that it may"
        advice = "search.setup_time is what to raise"
    message = (
        f"{', '.join(query.options.planners)} found no path in {tally.num_attempts} attempts: "
        f"{why}; {advice}"
    )
    return NoPathFound(message, evidence)
