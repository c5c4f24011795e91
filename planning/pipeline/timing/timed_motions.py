"""Timed motions along one path and its linear moves, or along lines alone, best first."""

from collections.abc import Iterator, Sequence
from contextlib import nullcontext
from dataclasses import replace

from planning.domain.arrays import Array
from planning.domain.goals.linear_moves import LinearMove
from planning.domain.report.motion_plan import Progress
from planning.domain.report.stage_reports import RefineReport
from planning.errors import RetimingFailed
from planning.pipeline.candidate_motions import candidates
from planning.pipeline.context import PlanContext
from planning.pipeline.motion import Motion
from planning.pipeline.segments import (
    MotionSegment,
    PartKind,
    approach_moves,
    free_segment,
    line_moves,
    retime_moves,
    without_duration,
)
from planning.pipeline.timing.candidate_timing import CandidateMotion
from planning.refine.motion.motion_objectives import MotionObjectives
from planning.search.request import SearchResult

# Relative difference up to which durations count as equal.
_DURATION_TOLERANCE = 1e-6


def refine_and_retime(
    context: PlanContext, search_result: SearchResult, round_: int
) -> Iterator[tuple[str, tuple[Motion, RefineReport]]]:
    """Yield motions along a path and the linear moves after it: names, motions, reports.

    The better of the refined and the rounded curve comes first; the last one rests at every corner.

    Raises:
        RetimingFailed: After all other motions, the last one cannot be timed either.
        DeadlineExceeded: Time ran out.
        Canceled: Cancellation was requested.
    """
    moves = (
        approach_moves(context.goals.moves[search_result.goal_row]) if context.goals.moves else []
    )
    with context.watch.stage("retime") if moves else nullcontext():
        move_segments = _retime_moves(context, moves, search_result.path.waypoints[-1])
    context.report_progress(Progress("refine", 0.5, "refining and timing"))
    all_candidates = candidates(
        context.world,
        search_result.path,
        without_duration(context.problem) if move_segments else context.problem,
        context.margins,
        context.deadline,
        context.watch,
        path_limits=context.path_limits,
        longest=_time_left(context, move_segments),
    )
    for candidate in all_candidates:
        with context.watch.stage("retime"):
            motion = _with_duration(
                context, (free_segment(search_result.path, candidate), *move_segments)
            )
        context.report_progress(Progress("certify", 0.8, f"certifying the {candidate.name}"))
        report = _with_delivered_objectives(context, candidate, motion.segments[0])
        yield f"round {round_ + 1}, {candidate.name}", (motion, report)


def retime_lines(context: PlanContext) -> Motion:
    """Return the motion along the linear moves of a line goal."""
    context.report_progress(Progress("retime", 0.5, "timing the lines"))
    with context.watch.stage("retime"):
        segments = _retime_moves(context, line_moves(context.lines), context.start)
        return _with_duration(context, segments)


def with_explanation(context: PlanContext, motion: Motion) -> Motion:
    """Return a motion with the explanation of its duration, if requested and time is left."""
    if not context.problem.retime.explain:
        return motion
    limits = context.world.limits(context.world.group(context.problem.group))
    objective = context.problem.refine.objective
    with context.watch.stage("explain"):
        return motion.with_explanation(
            limits,
            context.problem.retime,
            context.path_limits,
            context.refine_deadline,
            may_be_slower=objective is not None and not objective.is_duration_alone,
        )


def _retime_moves(
    context: PlanContext, moves: Sequence[tuple[PartKind, LinearMove]], begin: Array
) -> tuple[MotionSegment, ...]:
    """Return linear moves as segments, timed under all limits of the problem."""
    return retime_moves(
        context.world,
        context.group,
        moves,
        context.problem,
        begin,
        context.path_limits,
        context.proof_deadline,
    )


def _time_left(context: PlanContext, moves: tuple[MotionSegment, ...]) -> float | None:
    """Return what a requested duration leaves for the free motion [s]; None without a request."""
    duration = context.problem.retime.duration
    if duration is None:
        return None
    left = duration - sum(segment.trajectory.duration for segment in moves)
    return left if left > 0 else None


def _with_delivered_objectives(
    context: PlanContext, candidate: CandidateMotion, free: MotionSegment
) -> RefineReport:
    """Return the report of a candidate that was slowed with its linear moves, if it was.

    Raises:
        RetimingFailed: It takes longer then than the objective permits.
    """
    report, problem = candidate.refine, context.problem
    duration = free.trajectory.duration
    if report.after is None or duration == candidate.trajectory.duration:
        return report
    objective = problem.refine.objective
    longest = objective and objective.max_duration
    if longest is not None and duration > longest * (1 + _DURATION_TOLERANCE):
        message = (
            f"a duration of {problem.retime.duration:.4g} s for the whole motion makes its free "
            f"part take {duration:.4g} s, longer than refine.objective.max_duration of "
            f"{longest:.4g} s"
        )
        evidence = {"duration": problem.retime.duration, "max_duration": longest}
        raise RetimingFailed(message, evidence)
    measured = MotionObjectives.of(
        context.world, context.group, free.trajectory, objective, problem.retime.payload
    )
    return replace(report, after=measured.values())


def _with_duration(context: PlanContext, segments: tuple[MotionSegment, ...]) -> Motion:
    """Return the motion of some segments, slowed to the duration that the problem requests."""
    return Motion(segments).with_duration(context.problem.retime, context.path_limits)
