"""The motions of grippers, in a worker."""

import time

from planning import Deadline, gripper_motion
from service.executions.proofs.tasks import PROVE_GRIPPER, GripperWork, ProvenMotion
from service.jobs.context import TaskContext
from service.plans.models.trajectory import Polynomial
from service.scenes.world_cache import borrow_world

# It is made and proven in milliseconds, or it is a hard case [s].
_ALLOWED = 10.0


@PROVE_GRIPPER.runs
def prove_gripper(work: GripperWork, context: TaskContext) -> ProvenMotion:
    """Return the motion of a gripper from where it is, proven.

    Raises:
        GraspMissed: Its fingers do not reach the object.
        NotCertified: The motion is not proven.
        DeadlineExceeded: Time ran out.
        InputError: It is no gripper, or the object cannot be held or let go of.
    """
    with borrow_world(work) as world:
        found = gripper_motion(
            world,
            work.group,
            work.request.to_domain(work.tool_frame),
            deadline=Deadline.after(_ALLOWED, time.monotonic, context.is_canceled),
        )
    return ProvenMotion(
        trajectory=Polynomial.from_domain(found.trajectory),
        start=found.trajectory.start.tolist(),
        min_clearance=found.certificate.min_clearance,
    )
