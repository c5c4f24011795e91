"""plan(): the stages in order. Read this first.

    problem, world -- resolve ----------> ResolvedProblem   every check of input, every default
                      find_goals -------> PlanContext       start, goal configurations, tool paths
    round k --------- find_path --------> SearchResult      roadmap, regions, OMPL
                      refine_and_retime > named motions     best first; straight moves joined
                      first_certified --> Certificate       the first proven, else another round

The stages do not import each other. Several candidate motions are timed, and the quickest one that
the certifier proves is returned. If none is proven, the search runs again with another seed and a
finer resolution. Linear moves of a tool (approach, retreat) belong to the goals stage: the search
ends where the approach begins.
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
from planning.pipeline.plan_inputs import find_goals, resolve, with_roadmap
from planning.pipeline.search import find_path
from planning.pipeline.segments import NOT_REFINED, empty_search_report, tool_frame
from planning.pipeline.timing.timed_motions import refine_and_retime, retime_lines, with_explanation
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

    The same problem in the same scene gives the same bytes, unless the deadline cuts a stage short;
    such stages are in `MotionPlan.cut_short`. Optional work (refinement, the explanation of the
    duration) is cut short before the plan fails.

    Args:
        problem: Group, start, goal, options, seed.
        world: Loaded scene.
        deadline: Time limit, and whether the plan was canceled. The problem's allowed planning time
            begins now and may end earlier.
        on_progress: Callback for the progress of every stage.
        roadmaps: Cache of roadmaps, used if the problem requests a roadmap; None for no cache. It
            does not change the result.
        pool: Pool of processes for concurrent search attempts; None for none. It does not change
            the result.

    Raises:
        InputError: The problem has an unknown name or invalid numbers.
        PlanningFailure: No certified motion was found; code, stage and evidence give the reason,
            `timings` the times of the stages.
    """
    progress = StageProgress(on_progress)
    watch = Stopwatch(deadline.clock, progress.begin)
    with watch.timing_failures():
        context = find_goals(resolve(problem, world, deadline, progress, watch, pool))
        context = with_roadmap(context, roadmaps)
        certified = _follow_lines(context) if context.lines else _search(context)
        return _motion_plan(context, certified)


def _follow_lines(context: PlanContext) -> CertifiedMotion:
    """Retime and certify the linear moves of a line goal, which needs no search."""
    motion = retime_lines(context)
    context.report_progress(Progress("certify", 0.8, "certifying the lines"))
    certificate, report = certify_motion(context, motion)
    if not certificate.proven:
        refused = ["the motion along the straight lines"]
        raise not_certified(certificate, refused, motion.trajectory)
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
                lambda timed: timed[0].trajectory,
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
    """Return whether only stops fail, which other paths do not shorten, but lower scales do."""
    return {check.name for check in certificate.failed} == {"stop"}


def _motion_plan(context: PlanContext, certified: CertifiedMotion) -> MotionPlan:
    motion, goals = certified.motion, context.goals
    parts = motion.summary(context.world, tool_frame(context.group, context.problem.goal))
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
        parts=parts,
    )
