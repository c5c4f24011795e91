"""Motions of several plans in one scene, and all of them as one."""

from collections.abc import Sequence

from planning.domain.curves.combined import combined
from planning.errors import ProblemInvalid
from service.jobs.service import JobService
from service.plans.models.trajectory import Polynomial
from service.plans.plan_job import read_plan
from service.plans.resource import motion_of, work_of
from service.scenes.store.records import SceneRecord
from service.scenes.validation import find_group, joined_group
from service.trajectories.tasks import PlannedMotion


async def planned_motions(
    jobs: JobService, record: SceneRecord, plans: Sequence[str]
) -> list[PlannedMotion]:
    """Return the motions of plans of one scene, whose groups have no joint in common.

    Raises:
        UnknownResource: There is no such plan.
        NotFinished: A plan has no motion.
        ProblemInvalid: A plan is of another scene, or two of them move one joint.
        UnknownName: The scene has no such group any more.
    """
    motions: list[PlannedMotion] = []
    for i, plan in enumerate(plans):
        job = await read_plan(jobs, plan)
        motion, request = motion_of(job), work_of(job).request
        if request.scene != record.id:
            message = f"plans.{i}: plan {plan} is of scene {request.scene}, not of {record.id}"
            raise ProblemInvalid(message, {"field": f"plans.{i}", "scene": request.scene})
        group = find_group(record, request.group).name
        motions.append(PlannedMotion(group=group, trajectory=motion.polynomial))
    joined_group(record, [motion.group for motion in motions], "plans")
    return motions


def combined_motion(
    record: SceneRecord, motions: Sequence[PlannedMotion], delays: Sequence[float]
) -> PlannedMotion:
    """Return motions as one motion of the group that spans theirs, each begun after its delay [s].

    Nothing is proven of it.

    Raises:
        ProblemInvalid: Two of the motions move one joint.
    """
    group = joined_group(record, [motion.group for motion in motions], "plans")
    trajectory = combined([motion.trajectory.to_domain() for motion in motions], delays)
    return PlannedMotion(group=group.name, trajectory=Polynomial.from_domain(trajectory))
