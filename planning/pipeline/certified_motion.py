"""CertifiedMotion: a motion with its certificate and the reports of all stages."""

from dataclasses import dataclass

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
    """Certified motion with the reports of all stages.

    Attributes:
        goal_row: Row of the goal configuration that it reaches.
        motion: All segments of the motion.
        search: Report of the search.
        refine: Report of the refinement.
        certificate: Certificate of the motion.
        certify: Report of the certification.
        graph: Graph of the planner; None if the problem does not request it.
    """

    goal_row: int
    motion: Motion
    search: SearchReport
    refine: RefineReport
    certificate: Certificate
    certify: CertifyReport
    graph: PlannerGraph | None = None


def certify_motion(context: PlanContext, motion: Motion) -> tuple[Certificate, CertifyReport]:
    """Return the certificate of a motion, proven or not, and the certifier's report."""
    problem, timing = context.problem, context.problem.retime
    goal = problem.goal
    tolerances = (
        (goal.max_position_deviation, goal.max_rotation_deviation)
        if isinstance(goal, LineGoal)
        else ()
    )
    request = certify_request(
        context.world,
        context.group,
        motion.trajectory,
        timing,
        context.margins,
        start=context.start,
        goals=end_configurations(context.goals),
        limits=context.limits.scaled(timing.velocity_scale, timing.acceleration_scale),
        constraints=problem.constraints,
        lines=motion.line_sections(*tolerances),
        options=problem.certify,
        terms=problem.refine.terms,
    )
    with context.watch.stage("certify"):
        return certify(context.world.drake, request, context.proof_deadline)
