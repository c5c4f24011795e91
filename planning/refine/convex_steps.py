"""ConvexSteps: the refiner by sequential convex programming, for curves and for car paths.

Sequential convex programming in a trust region, with distances under an exact penalty (Schulman et
al., "Motion planning with sequential convex optimization and convex collision checking", IJRR 33:9,
2014): see `model/curve_model` and `descents/`, for cars `cars/`. Every curve that is better than
those before it is audited densely; where it violates a margin between the instants at which
distances are kept, those instants are added.
"""

from dataclasses import dataclass, replace

from planning.domain.curves.curve import JointSpline
from planning.domain.report.stage_reports import RefineReport
from planning.domain.request.deadline import Deadline
from planning.domain.robot.steering import steering_of
from planning.refine.cars.drive_refiner import refine_drive
from planning.refine.curves.chart import FlatChart, make_chart
from planning.refine.descents.multi_start import solve_multi_start
from planning.refine.model.penalty_qp import solver_name
from planning.refine.motion.convex_program import ConvexProgram
from planning.refine.motion.motion_refiner import STATIC_LOAD_REASON, refine_motion
from planning.refine.refine_method import Refined
from planning.refine.refine_problem import RefineProblem
from planning.refine.request import RefineRequest
from planning.world.world import World


@dataclass(frozen=True)
class ConvexSteps:
    """Refiner by convex steps.

    It minimizes the duration and the clearance objective's cost by a curve that the retimer times,
    and any other objective by a motion with its own time.
    """

    def unsupported_reason(self, request: RefineRequest) -> str:
        """Return why a path cannot be refined, or ""."""
        chart, num_cars = make_chart(request.path), len(steering_of(request.path.group))
        if num_cars > 1 or (num_cars and not isinstance(chart, FlatChart)):
            return "groups with several cars, or with a car and a floating joint, are not refined"
        return ""

    def refine(
        self, world: World, request: RefineRequest, deadline: Deadline, report: RefineReport
    ) -> tuple[Refined, RefineReport]:
        """Return a curve or a motion that should cost less, if there is one; and the report."""
        if steering_of(request.path.group):
            return refine_drive(world, request, deadline, report)
        objective = request.options.objective
        if objective is not None and not objective.is_duration_alone:
            report = replace(report, solver=solver_name())
            return refine_motion(world, request, deadline, report, ConvexProgram)
        return _refine_curve(world, request, deadline, report)


def _refine_curve(
    world: World, request: RefineRequest, deadline: Deadline, report: RefineReport
) -> tuple[JointSpline | None, RefineReport]:
    """Return a curve near a path of joints without steering."""
    problem = RefineProblem.of(world, request, deadline)
    report = replace(report, solver=solver_name(), lower_bound=problem.lower_bound)
    if not problem.is_static_load_feasible:
        return None, replace(report, reason=STATIC_LOAD_REASON)
    result = solve_multi_start(world, problem)
    best = result.best
    report = replace(
        report, rounds=result.num_steps, duration_before=problem.duration_of(result.first_guess)
    )
    if best is not None and result.num_steps == 0 and len(problem.waypoints) == 2:
        return None, replace(report, reason="the straight path is already optimal")
    if best is None:
        return None, replace(report, reason=result.reason)
    curve = result.problem.curve_of(best)
    length = result.problem.samples_of(best.points).length
    return curve, replace(report, improved=True, length_after=length, duration_after=best.duration)
