"""DrakeRefiner: the refiner by Drake's `KinematicTrajectoryOptimization`."""

from dataclasses import dataclass, replace

from planning.domain.report.stage_reports import RefineReport
from planning.domain.request.deadline import Deadline
from planning.domain.robot.steering import steering_of
from planning.refine.drake.program import SOLVER_NAME, DrakeProgram
from planning.refine.motion.motion_program import MotionProgram, MotionTask
from planning.refine.motion.motion_refiner import refine_motion
from planning.refine.refine_method import Refined
from planning.refine.request import RefineRequest
from planning.world.world import World


@dataclass(frozen=True)
class DrakeRefiner:
    """Refiner by Drake's kinematic trajectory optimization. It minimizes any objective."""

    def unsupported_reason(self, request: RefineRequest) -> str:
        """Return why a path cannot be refined, or ""."""
        if steering_of(request.path.group):
            return "method drake: its splines do not keep the steering of a car"
        return ""

    def refine(
        self, world: World, request: RefineRequest, deadline: Deadline, report: RefineReport
    ) -> tuple[Refined, RefineReport]:
        """Return a motion in time, or the curve of the convex steps, or None; and the report."""

        def make_program(task: MotionTask) -> MotionProgram:
            return DrakeProgram(task, world.drake.plant, request.options.terms)

        report = replace(report, solver=SOLVER_NAME)
        return refine_motion(world, request, deadline, report, make_program)
