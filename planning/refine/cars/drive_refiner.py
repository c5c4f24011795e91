"""refine_drive(): trajectory optimization of a car's path: quicker arcs and lines, or a reason."""

from dataclasses import replace

from planning.domain.curves.curve import JointSpline
from planning.domain.report.stage_reports import RefineReport
from planning.domain.request.deadline import Deadline
from planning.refine.cars.drive_solver import DriveSolver
from planning.refine.model.penalty_qp import solver_name
from planning.refine.refine_problem import request_lower_bound
from planning.refine.request import RefineRequest
from planning.world.world import World


def refine_drive(
    world: World, request: RefineRequest, deadline: Deadline, report: RefineReport
) -> tuple[JointSpline | None, RefineReport]:
    """Return arcs and lines from the path's start to its goal that should take less time.

    Limits of frames and torques are not considered here; the caller's retiming includes them.

    Args:
        world: The scene, loaded.
        request: Path of a group with one car, limits, margins and constraints.
        deadline: End of the refinement.
        report: Report to be completed.
    """
    result = DriveSolver.of(world, request, deadline).run()
    report = replace(
        report,
        solver=solver_name(),
        rounds=result.num_steps,
        lower_bound=request_lower_bound(request),
        duration_before=result.duration_before,
    )
    if result.path is None:
        return None, replace(report, reason=result.reason)
    return result.path.spline, replace(
        report, improved=True, length_after=result.path.length, duration_after=result.duration_after
    )
