"""search(): from goal configurations to a path. The stage's one entry.

A straight line to one of the nearest goals comes first. If there is none, or only to a goal much
farther than the nearest, the planner looks for a path, which is
shortened and checked again, edge by edge, four times as finely as it was searched; if that finds a
collision the attempt starts anew with half the resolution. The shortest of all attempts is kept.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from planning.domain.deadline import Deadline
from planning.domain.joints import JointGroup, JointLimits
from planning.domain.path import JointPath
from planning.domain.report import SearchReport
from planning.errors import DeadlineExceeded, NoPathFound, ProblemInvalid
from planning.search.attempt import Attempt, Query
from planning.search.oracle import CollisionOracle, WatchedOracle
from planning.search.planners import check_planner
from planning.search.projected import ProjectedSpace
from planning.search.sound import Closeness, SoundPath, delivered, fine_checker, sound_attempt
from planning.search.spaces import SearchSpace
from planning.search.task import SearchResult, SearchTask
from planning.stopwatch import Stopwatch

type Array = np.ndarray[Any, np.dtype[np.float64]]

# A straight line to a goal is not taken at once if the nearest goal is so much nearer than that: a
# factor, beyond a length that nobody minds.
_DETOUR = 1.3
_NEAR = 0.5
# Straight lines are tried to so many goals.
_MOST_LINES = 16

_FIELDS = {
    "start": "one finite number per coordinate is needed",
    "goal": "one finite number per coordinate is needed in every row",
    "search.resolution": "it must be positive",
    "search.attempts": "at least 1 is needed",
    "search.num_states": "at least 2 are needed",
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
        group: Whose joints move.
        limits: Their position limits.
        oracle: What is free.
        task: Start, goals and how to search.
        deadline: When to give up; also asked whether anybody still wants the answer.
        watch: Told how long the stage "shortcut" takes.

    Raises:
        ProblemInvalid: A number in the task makes no sense.
        UnknownName: There is no such planner, or it has no such parameter.
        NoPathFound: The planner ended without an exact solution.
        DeadlineExceeded: The time ran out before there was any.
        Canceled: Somebody asked for the end.
    """
    _require_sense(group, task)
    options = task.options
    check_planner(options.planner, options.parameters)
    watched = WatchedOracle(oracle, group, limits, deadline)
    space = _space(group, limits, task)
    rows = _admissible_goals(space, watched, task)
    query = Query(
        space,
        watched,
        task.start,
        task.goals[rows],
        options.planner,
        options.parameters,
        deadline,
        watch or Stopwatch(deadline.clock),
    )
    fine = fine_checker(query, task.resolution)
    closeness = Closeness(task.resolution, options.num_states, fine)
    tally = _Tally(direct=_straight_line(query, closeness))
    tally.best = tally.direct
    if tally.best is None or _is_detour(tally.best, query):
        _attempt_all(query, closeness, task, tally)
    best = tally.best
    if best is None:
        raise _no_path(query, tally)
    report = SearchReport(
        planner=options.planner,
        attempts=options.attempts,
        solved=tally.num_solved,
        num_states_checked=watched.num_states,
        num_motions_checked=tally.num_motions + fine.num_motions,
        raw_length=best.raw_length,
        length=best.length,
        num_waypoints=len(best.waypoints),
        resolution=fine.resolution,
        padding=task.padding,
        direct=best is tally.direct,
    )
    return SearchResult(JointPath(group, best.waypoints), int(rows[best.goal_row]), report)


def _space(group: JointGroup, limits: JointLimits, task: SearchTask) -> SearchSpace:
    anchors = np.concatenate([task.start[None], task.goals])
    if task.residual is None:
        return SearchSpace(group, limits, anchors)
    return ProjectedSpace(group, limits, anchors, task.residual)


def _is_detour(direct: SoundPath, query: Query) -> bool:
    """Whether a way around to a nearer goal may well be shorter than a line to this one."""
    nearest = float(query.space.manifold.distance(query.goals[0], query.start))
    return direct.length > _DETOUR * nearest + _NEAR


@dataclass
class _Tally:
    """What the attempts came to so far."""

    direct: SoundPath | None
    best: SoundPath | None = None
    last: Attempt | None = None
    num_attempts: int = 0
    num_solved: int = 0
    num_motions: int = 0


def _attempt_all(query: Query, closeness: Closeness, task: SearchTask, tally: _Tally) -> None:
    """Make every attempt, or as many as there is time for, and keep the shortest path."""
    attempts = task.options.attempts
    for seeds in np.random.SeedSequence(task.seed).spawn(attempts):
        tally.num_attempts += 1
        try:
            trial = sound_attempt(query, closeness, seeds)
        except DeadlineExceeded as error:
            if tally.best is not None:
                return
            raise DeadlineExceeded(
                error.detail, error.evidence | _evidence(query, tally)
            ) from error
        tally.last = trial.last
        tally.num_motions += trial.num_motions
        if trial.path is not None:
            tally.num_solved += 1
            if tally.best is None or trial.path.length < tally.best.length:
                tally.best = trial.path


def _require_sense(group: JointGroup, task: SearchTask) -> None:
    """Refuse numbers that cannot be meant.

    Raises:
        ProblemInvalid: And which.
    """
    nq = group.num_positions
    num_states = task.options.num_states
    faults = {
        "start": task.start.shape != (nq,) or not np.isfinite(task.start).all(),
        "goal": task.goals.shape[1:] != (nq,) or not np.isfinite(task.goals).all(),
        "search.resolution": not (np.isfinite(task.resolution) and task.resolution > 0),
        "search.attempts": task.options.attempts < 1,
        "search.num_states": num_states is not None and num_states < 2,
        "seed": task.seed < 0,
    }
    for field, is_fault in faults.items():
        if is_fault:
            raise ProblemInvalid(f"{field} makes no sense: {_FIELDS[field]}", {"field": field})


def _admissible_goals(
    space: SearchSpace, oracle: WatchedOracle, task: SearchTask
) -> np.ndarray[Any, np.dtype[np.intp]]:
    """Return the rows of the goals that can be searched for.

    Raises:
        NoPathFound: There is none, or the start is inadmissible itself.
    """
    evidence = {"planner": task.options.planner, "padding": task.padding}
    if not (space.contains(task.start) and oracle.is_free(task.start)):
        message = "the start is outside the limits, or nearer to something than is demanded"
        raise NoPathFound(message, evidence | {"reason": "start"})
    inside = [row for row, q in enumerate(task.goals) if space.contains(q)]
    rows = np.array(inside, dtype=np.intp)
    rows = rows[oracle.are_free(task.goals[rows])] if len(rows) else rows
    if not len(rows):
        message = "every goal is outside the limits, or nearer to something than is demanded"
        raise NoPathFound(message, evidence | {"reason": "goals", "num_goals": len(task.goals)})
    return rows


def _straight_line(query: Query, closeness: Closeness) -> SoundPath | None:
    """Return the first free geodesic to one of the nearest goals."""
    for row, goal in enumerate(query.goals[:_MOST_LINES]):
        if closeness.fine.is_free(query.start, goal):
            waypoints = np.stack([query.start, goal])
            path = delivered(waypoints, waypoints, row, closeness)
            if path is not None:
                return path
    return None


def _no_path(query: Query, tally: _Tally) -> NoPathFound:
    blocked = tally.last is not None and len(tally.last.waypoints) > 0
    why = "what it found collides on a closer look" if blocked else "it ended without a solution"
    message = (
        f"{query.planner} found no path in {tally.num_attempts} attempts: {why}; "
        "more attempts, more samples or another planner may find one"
    )
    return NoPathFound(message, _evidence(query, tally))


def _evidence(query: Query, tally: _Tally) -> dict[str, Any]:
    evidence: dict[str, Any] = {
        "planner": query.planner,
        "attempts": tally.num_attempts,
        "num_goals": len(query.goals),
        "num_states_checked": query.oracle.num_states,
    }
    if tally.last is not None:
        evidence |= {"status": tally.last.status, **tally.last.growth}
    return evidence
