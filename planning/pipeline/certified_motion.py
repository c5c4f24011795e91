"""CertifiedMotion: a motion with its proof and the reports of the stages that made it."""

from dataclasses import dataclass, replace

from planning.certify.certifier import certify
from planning.domain.goals.goal import LineGoal
from planning.domain.planner.planner_graph import PlannerGraph
from planning.domain.report.certificate import Certificate
from planning.domain.report.search_report import SearchReport
from planning.domain.report.stage_reports import CertifyReport, RefineReport
from planning.pipeline.certification import certify_request
from planning.pipeline.context import PlanContext
from planning.pipeline.motion import Motion
from planning.pipeline.segments import end_configurations


@dataclass(frozen=True, kw_only=True)
class CertifiedMotion:
    """A motion that is certified, and the reports of all stages.

    Attributes:
        goal_row: Row of the goal configuration that it reaches.
        motion: All its segments.
        search: Report of the search.
        refine: Report of the refinement.
        certificate: The proof.
        certify: Report of the certification.
        graph: The planner's, if the problem wants it.
    """

    goal_row: int
    motion: Motion
    search: SearchReport
    refine: RefineReport
    certificate: Certificate
    certify: CertifyReport
    graph: PlannerGraph | None = None


def certify_motion(context: PlanContext, motion: Motion) -> tuple[Certificate, CertifyReport]:
    """Return the certificate of a motion, proven or not, and what the proof took."""
    problem, timing = context.problem, context.problem.retime
    goal = problem.goal
    tolerances = (
        (goal.max_position_deviation, goal.max_rotation_deviation)
        if isinstance(goal, LineGoal)
        else ()
    )
    request = replace(
        certify_request(context.world, context.group, motion.trajectory, timing, context.margins),
        start=context.start,
        goals=end_configurations(context.goals),
        limits=context.limits.scaled(timing.velocity_scale, timing.acceleration_scale),
        constraints=problem.constraints,
        lines=motion.line_sections(*tolerances),
        options=problem.certify,
    )
    with context.watch.stage("certify"):
        return certify(context.world.drake, request, context.proof_deadline)
