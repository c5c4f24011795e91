"""From goals to a proven motion: search, refine, retime and certify, until one is proven."""

from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import dataclass, replace

import numpy as np

from planning.certify.certifier import certify
from planning.certify.failure import failed_checks, not_certified
from planning.domain.goals.goal import LineGoal
from planning.domain.goals.line import LinearMove
from planning.domain.planner.planner_graph import PlannerGraph
from planning.domain.report.certificate import Certificate
from planning.domain.report.motion_plan import Progress
from planning.domain.report.search_report import SearchReport
from planning.domain.report.stage_reports import CertifyReport, RefineReport
from planning.domain.request.deadline import Deadline
from planning.errors import Canceled, DeadlineExceeded, NoPathFound
from planning.pipeline.candidates import candidates, deadlines
from planning.pipeline.certification import certify_request
from planning.pipeline.constrained_search import search_constrained
from planning.pipeline.context import SEARCHING, PlanContext
from planning.pipeline.motion import Motion
from planning.pipeline.region_guide import make_guide
from planning.pipeline.segments import (
    NOT_REFINED,
    MotionSegment,
    PartKind,
    approach_segments,
    empty_search_report,
    ends_of,
    free_segment,
    named_lines,
    timed_legs,
    without_duration,
)
from planning.search.roadmap.query_roadmap import report_of
from planning.search.solver import SearchResult, SearchTask, search
from planning.world.collision.obstacle_distance import obstacle_distances
from planning.world.collision.search_padding import endpoint_padding
from planning.world.world import Array

# How often the search is asked again, each time with half the resolution, before we give up.
_MAX_ROUNDS = 4
# In so many of them a roadmap has its say; if that is never proven, another way has to be found.
_ROADMAP_ROUNDS = 3
# Share of the time for a search that keeps more distance than is demanded.
_PADDED_SHARE = 0.6
# What a canceled plan may still search for when its best path so far could not be proven [s].
_BRIEF = 0.4


@dataclass(frozen=True)
class CertifiedCandidate:
    """A motion that is certified, and what was done for it.

    Attributes:
        goal_row: Which goal configuration it reaches.
        motion: All its parts.
        search: What the search did.
        refine: What refinement did.
        certificate: The proof.
        certify: What the proof took.
        graph: The planner's, if it was asked for.
    """

    goal_row: int
    motion: Motion
    search: SearchReport
    refine: RefineReport
    certificate: Certificate
    certify: CertifyReport
    graph: PlannerGraph | None = None


def certify_lines(task: PlanContext) -> CertifiedCandidate:
    """Time and certify lines; there is nothing to search."""
    task.report(Progress("retime", 0.5, "timing the lines"))
    with task.watch.stage("retime"):
        motion = _lasting(task, _timed(task, named_lines(task.lines), task.start))
    task.report(Progress("certify", 0.8, "certifying the lines"))
    with task.watch.stage("certify"):
        certificate, report = _certify(task, motion)
    if not certificate.proven:
        raise not_certified(certificate, ["the lines themselves"])
    motion = _explained(task, motion)
    return CertifiedCandidate(
        0, motion, empty_search_report(motion.path), NOT_REFINED, certificate, report
    )


def certify_search(task: PlanContext) -> CertifiedCandidate:
    """Search, refine, retime and certify until a motion is proven."""
    refused: list[str] = []
    failed: Certificate | None = None
    for round_ in range(_MAX_ROUNDS):
        if round_ and _is_over(task):
            break
        task.report(Progress("search", SEARCHING, f"searching, round {round_ + 1}"))
        with task.watch.stage("search"):
            found = _search(task, 0) if round_ == 0 else _search_again(task, round_)
        legs = approach_segments(task.goals.legs[found.goal_row]) if task.goals.legs else []
        with task.watch.stage("retime") if legs else nullcontext():
            tail = _timed(task, legs, found.path.waypoints[-1])
        task.report(Progress("refine", 0.5, "refining and timing"))
        problem = without_duration(task.problem) if tail else task.problem
        for candidate in candidates(
            task.world,
            found.path,
            problem,
            task.margins,
            task.deadline,
            task.watch,
            path_limits=task.path_limits,
        ):
            with task.watch.stage("retime"):
                motion = _lasting(task, (free_segment(found.path, candidate), *tail))
            task.report(Progress("certify", 0.8, f"certifying the {candidate.name}"))
            with task.watch.stage("certify"):
                certificate, report = _certify(task, motion)
            if certificate.proven:
                seen = replace(report, candidates=len(refused) + 1, refused=tuple(refused))
                return CertifiedCandidate(
                    found.goal_row,
                    _explained(task, motion),
                    found.report,
                    candidate.refine,
                    certificate,
                    seen,
                    found.graph,
                )
            failed = certificate
            refused.append(f"round {round_ + 1}, {candidate.name}: {failed_checks(certificate)}")
            _require_hope(certificate, refused)
    with task.watch.stage("certify"):
        task.deadline.check("certify")
    raise not_certified(failed, refused)


def _timed(
    task: PlanContext, legs: Sequence[tuple[PartKind, LinearMove]], begin: Array
) -> tuple[MotionSegment, ...]:
    """Return legs as parts, timed under all that limits the motion."""
    deadline = deadlines(task.problem, task.deadline)[1]
    world, group, problem = task.world, task.group, task.problem
    return timed_legs(world, group, legs, problem, begin, task.path_limits, deadline)


def _lasting(task: PlanContext, parts: tuple[MotionSegment, ...]) -> Motion:
    """Return the motion that parts make, as long as was asked for."""
    return Motion(parts).lasting(task.problem.retime, task.path_limits)


def _explained(task: PlanContext, motion: Motion) -> Motion:
    """Return a proven motion that says why it takes as long as it does, if asked and in time."""
    if not task.problem.retime.explain:
        return motion
    hasty = deadlines(task.problem, task.deadline)[0]
    limits = task.world.limits(task.world.group(task.problem.group))
    with task.watch.stage("explain"):
        return motion.explained(limits, task.problem.retime, task.path_limits, hasty)


def _require_hope(certificate: Certificate, refused: list[str]) -> None:
    """Go on only if another path may help; how soon a motion stops is for lower scales to change.

    Raises:
        NotCertified: It would not.
    """
    if {check.name for check in certificate.failed} == {"stop"}:
        raise not_certified(certificate, refused)


def _is_over(task: PlanContext) -> bool:
    """Whether there is no time for another round; who wants the best so far gets a short one."""
    return deadlines(task.problem, task.deadline)[1].is_over


def _search_again(task: PlanContext, round_: int) -> SearchResult:
    """Search with a finer eye; once and briefly, if a cancel wants the best there was so far."""
    wants_best = task.problem.search.on_cancel == "best"
    if not (wants_best and task.deadline.is_canceled()):
        try:
            return _search(task, round_)
        except Canceled:
            if not wants_best:
                raise
    once = replace(task.problem.search, attempts=1)
    brief = task.deadline.uncancelable.within(_BRIEF)
    hurried = replace(task, problem=replace(task.problem, search=once), deadline=brief)
    found = _search(hurried, round_)
    return replace(found, report=replace(found.report, was_canceled=True))


def _search(task: PlanContext, round_: int) -> SearchResult:
    """Search with some distance to spare; without, if there is no path that way."""
    padding = endpoint_padding(
        task.world, task.group, task.start, task.goals.entries, task.problem.margin
    )
    if padding * (round_ + 1) > 0:
        try:
            return _search_padded(task, round_, padding, task.deadline.share(_PADDED_SHARE))
        except (NoPathFound, DeadlineExceeded):
            task.deadline.check("search")
    return _search_padded(task, round_, 0.0, task.deadline)


def _search_padded(
    task: PlanContext, round_: int, padding: float, deadline: Deadline
) -> SearchResult:
    margins = task.world.margins(task.problem.margin, padding)
    oracle = task.world.collision_oracle(task.group, margins)
    entries = task.goals.entries
    rows = np.flatnonzero(oracle.are_free(entries))
    guide = make_guide(task, round_)
    request = SearchTask(
        start=task.start,
        goals=entries[rows],
        options=task.problem.search if guide is None else guide.options,
        resolution=task.problem.search.resolution / 2**round_,
        padding=padding,
        seed=task.problem.seed + round_,
        clearances=obstacle_distances(task.world, task.group),
        on_best=task.tell_best,
        guide=guide,
        pool=task.pool,
        roadmap=task.roadmap if round_ < _ROADMAP_ROUNDS else None,
    )
    if task.rules is None:
        found = search(task.group, task.limits, oracle, request, deadline, watch=task.watch)
    else:
        found = search_constrained(task.rules, task.limits, oracle, request, deadline, task.watch)
    if task.roadmap is not None and request.roadmap is None:
        refused = report_of(task.roadmap, "not_proven")
        found = replace(found, report=replace(found.report, roadmap=refused))
    report = found.report if guide is None else guide.told(found.report)
    goal_row = int(rows[found.goal_row])
    return replace(found, path=found.path.continuous, goal_row=goal_row, report=report)


def _certify(task: PlanContext, motion: Motion) -> tuple[Certificate, CertifyReport]:
    goal, timing = task.problem.goal, task.problem.retime
    allowed = (goal.max_shift, goal.max_turn) if isinstance(goal, LineGoal) else ()
    request = replace(
        certify_request(task.world, task.group, motion.trajectory, timing, task.margins),
        start=task.start,
        goals=ends_of(task.goals),
        limits=task.limits.scaled(timing.velocity_scale, timing.acceleration_scale),
        constraints=task.problem.constraints,
        lines=motion.sections(*allowed),
        options=task.problem.certify,
    )
    return certify(task.world.drake, request, deadlines(task.problem, task.deadline)[1])
