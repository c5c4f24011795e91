"""The motion that a request asks for: of a plan, of several as one, of the client, of a gripper."""

from service.executions.motions.asked_motion import AskedMotion, OwnMotion, PlannedMotion
from service.executions.motions.gripper_move import GripperMove
from service.executions.motions.plans_together import PlansTogether
from service.executions.requests import ExecutionRequest
from service.jobs.service import JobService
from service.plans.plan_job import read_plan
from service.plans.resource import motion_of, work_of


async def asked_motion(request: ExecutionRequest, jobs: JobService) -> AskedMotion:
    """Return the motion that a request asks for.

    Raises:
        UnknownResource: There is no such plan.
        NotFinished: A plan has no trajectory.
    """
    if request.trajectory is not None:
        return OwnMotion(request, request.trajectory)
    if request.gripper is not None:
        return GripperMove(request, request.gripper)
    if request.plans is not None:
        motions = [await _planned(plan, jobs) for plan in request.plans]
        return PlansTogether(motions, request.delays)
    return await _planned(request.plan or "", jobs)


async def _planned(plan: str, jobs: JobService) -> PlannedMotion:
    job = await read_plan(jobs, plan)
    return PlannedMotion(work_of(job), motion_of(job))
