"""plan(): the stages in order. Read this first.

    problem, world -- resolve ----------> ResolvedProblem   every check of input, every default
                      find_goals -------> PlanContext       start, goal configurations, tool paths
    round k --------- find_path --------> SearchResult      roadmap, regions, OMPL
                      refine_and_retime > named motions     best first; straight moves joined
                      first_certified --> Certificate       the first proven, else another round

The stages do not know each other. What a stage cannot do better it leaves alone: several candidate
motions are timed, the quickest one that the certifier proves is delivered, and if none is proven
the search runs again, with more distance and a finer resolution. Straight moves of a tool belong
to the goals: a search ends where they begin.
"""

from collections.abc import Callable
from dataclasses import replace

from planning.certify.failure import not_certified
from planning.domain.report.certificate import Certificate
from planning.domain.report.motion_plan import MotionPlan, Progress, StageReports, ignore_progress
from planning.domain.request.attempt_pool import AttemptPool
from planning.domain.request.deadline import Deadline
from planning.domain.request.problem import PlanningProblem
from planning.domain.request.stopwatch import Stopwatch
from planning.errors import NotCertified
from planning.pipeline.certification import Refusals, first_certified
from planning.pipeline.certified_motion import CertifiedMotion, certify_motion
from planning.pipeline.context import PlanContext, StageProgress
from planning.pipeline.goals import find_goals, resolve, with_roadmap
from planning.pipeline.search import find_path
from planning.pipeline.segments import NOT_REFINED, empty_search_report, tool_frame
from planning.pipeline.timed_motions import refine_and_retime, retime_lines, with_explanation
from planning.roadmaps.roadmap_cache import RoadmapStore
from planning.world.world import World

# Rounds of the search, each with half the resolution of the one before.
_MAX_ROUNDS = 4


def plan(
    problem: PlanningProblem,
    world: World,
    *,
    deadline: Deadline,
    on_progress: Callable[[Progress], None] = ignore_progress,
    roadmaps: RoadmapStore | None = None,
    pool: AttemptPool | None = None,
) -> MotionPlan:
    """Plan a certified motion.

    The same problem in the same scene gives the same bytes, as long as the deadline cuts nothing;
    what it cuts is in `MotionPlan.cut_short`. Work that a plan can do without (refinement, the
    explanation of the duration) is cut before the plan is lost.

    Args:
        problem: Group, start, goal, options, seed.
        world: The scene, loaded.
        deadline: When to give up, if the problem's allowed time, which begins now, does not end
            before; also says whether the plan was canceled.
        on_progress: Receives the progress of every stage.
        roadmaps: Where a roadmap is looked for, and left if it had to be built, if the problem
            wants one; what is found there changes no byte.
        pool: Makes several attempts of the search at once; that changes no byte either.

    Raises:
        InputError: The problem names what does not exist, or its numbers do not fit.
        PlanningFailure: There is no motion to give; code, stage and evidence say why, and `timings`
            how long the stages took.
    """
    progress = StageProgress(on_progress)
    watch = Stopwatch(deadline.clock, progress.begin)
    with watch.timing_failures():
        context = find_goals(resolve(problem, world, deadline, progress, watch, pool))
        context = with_roadmap(context, roadmaps)
        certified = _follow_lines(context) if context.lines else _search(context)
        return _motion_plan(context, certified)


def _follow_lines(context: PlanContext) -> CertifiedMotion:
    """Time and certify lines; there is nothing to search."""
    motion = retime_lines(context)
    context.report_progress(Progress("certify", 0.8, "certifying the lines"))
    certificate, report = certify_motion(context, motion)
    if not certificate.proven:
        raise not_certified(certificate, ["the lines themselves"])
    motion = with_explanation(context, motion)
    return CertifiedMotion(
        goal_row=0,
        motion=motion,
        search=empty_search_report(motion.path),
        refine=NOT_REFINED,
        certificate=certificate,
        certify=report,
    )


def _search(context: PlanContext) -> CertifiedMotion:
    """Search, refine, retime and certify, in rounds, until a motion is proven."""
    refusals = Refusals()
    for round_ in range(_MAX_ROUNDS):
        if round_ and context.proof_deadline.is_over:
            break
        search_result = find_path(context, round_)
        motions = refine_and_retime(context, search_result, round_)
        try:
            (motion, refine), certificate, report = first_certified(
                motions,
                lambda timed: certify_motion(context, timed[0]),
                refusals,
                _has_only_failed_stops,
            )
        except NotCertified:
            if refusals.last is not None and _has_only_failed_stops(refusals.last):
                raise
            continue
        refused = tuple(refusals.reasons)
        return CertifiedMotion(
            goal_row=search_result.goal_row,
            motion=with_explanation(context, motion),
            search=search_result.report,
            refine=refine,
            certificate=certificate,
            certify=replace(report, candidates=len(refused) + 1, refused=refused),
            graph=search_result.graph,
        )
    with context.watch.stage("certify"):
        context.deadline.check("certify")
    raise refusals.failure


def _has_only_failed_stops(certificate: Certificate) -> bool:
    """Return whether stops alone fail, which lower scales shorten and other paths do not."""
    return {check.name for check in certificate.failed} == {"stop"}


def _motion_plan(context: PlanContext, certified: CertifiedMotion) -> MotionPlan:
    motion, goals = certified.motion, context.goals
    return MotionPlan(
        group=context.group,
        start=context.start,
        start_clipped=context.start_clipped,
        goal_configuration=motion.goal_configuration,
        goal_index=goals.target_indices[certified.goal_row],
        path=motion.path,
        trajectory=motion.trajectory,
        certificate=certified.certificate,
        stages=StageReports(
            goals, certified.search, certified.refine, motion.report, certified.certify
        ),
        timings=context.watch.seconds,
        cut_short=context.watch.cut_short,
        graph=certified.graph,
        parts=motion.summary(context.world, tool_frame(context.group, context.problem.goal)),
    )
