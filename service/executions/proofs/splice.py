"""A motion that is carried out, left for another one without a rest."""

import time
from dataclasses import replace

from planning import Deadline, TimedTrajectory, splice_motion
from planning.errors import PlanningFailure
from service.executions.proofs.demands import kept_by
from service.executions.proofs.tasks import SPLICE, Spliced, SpliceWork
from service.jobs.context import TaskContext
from service.plans.models.trajectory import Polynomial
from service.scenes.world_cache import borrow_world

# A robot waits where the motion is left [s].
_ALLOWED = 5.0


@SPLICE.runs
def splice(work: SpliceWork, context: TaskContext) -> Spliced:
    """Return the motion up to where it is left and on from there, if that is proven.

    Raises:
        InputError: What the motion keeps names something that is not in this scene any more.
    """
    running = work.running.to_domain()
    group, demands = kept_by(work.planned, work.own)
    demands["options"] = replace(demands["options"], method="ruckig", duration=None)
    deadline = Deadline.after(_ALLOWED, time.monotonic, context.is_canceled)
    try:
        with borrow_world(work) as world:
            found = splice_motion(
                world,
                group,
                running,
                work.time,
                work.onto.to_domain(),
                deadline=deadline,
                **demands,
            )
    except PlanningFailure:
        return Spliced(trajectory=None)
    whole = TimedTrajectory.joined([running.until(work.time), found.trajectory])
    return Spliced(trajectory=Polynomial.from_domain(whole))
