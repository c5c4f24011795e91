"""Proofs of a motion beside those of other executions, whatever the timing of each.

Executions are paused, slowed and driven backwards one by one, so a motion may be anywhere on its
path while another one is anywhere on its own, also where it has been already.
"""

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from planning import Deadline, World, certify_beside
from planning.domain.report.beside_report import BesideCheck, BesideOutcome
from planning.errors import NotCertified, ProblemInvalid
from service.executions.proofs.tasks import PROVE_BESIDE, BesideProof, BesideWork, GroupMotion
from service.executions.proofs.together_proof import largest_margin
from service.jobs.context import TaskContext
from service.scenes.world_cache import borrow_world

# Name of the check in evidence.
BESIDE = "beside"
# A motion is proven beside another one in a tenth of a second, or it is a hard case [s].
_ALLOWED = 10.0


@dataclass(frozen=True)
class InTheWay:
    """A motion that another one is not proven beside.

    Attributes:
        execution: Whose motion it is.
        group: That it moves.
        check: Where both meet, or might.
    """

    execution: str
    group: str
    check: BesideCheck


@PROVE_BESIDE.runs
def prove_beside(work: BesideWork, context: TaskContext) -> BesideProof:
    """Hold a motion against every place on the paths of others.

    Raises:
        NotCertified: It is not proven; evidence has `execution`, `pair`, `time`, `other_time`.
        DeadlineExceeded: Time ran out before the verdict.
    """
    deadline = Deadline.after(_ALLOWED, time.monotonic, context.is_canceled)
    with borrow_world(work) as world:
        found = first_in_the_way(world, work.motion, work.others, deadline)
    if found is not None:
        raise _refusal(found)
    return BesideProof(num_others=len(work.others))


def first_in_the_way(
    world: World, motion: GroupMotion, others: Sequence[GroupMotion], deadline: Deadline
) -> InTheWay | None:
    """Return the first of other motions that a motion is not proven beside; None for none."""
    own = (motion.group, motion.trajectory.to_domain())
    for other in others:
        beside = (other.group, other.trajectory.to_domain())
        margin = largest_margin(world, [*motion.margins, *other.margins])
        try:
            report = certify_beside(world, own, [beside], deadline=deadline, margin=margin)
        except ProblemInvalid as fault:  # one robot stands on the other: both move its bodies
            shared = [str(body) for body in fault.evidence.get("bodies", [])]
            if not shared:
                raise
            check = BesideCheck(other.group, BesideOutcome.UNDECIDED, (shared[0], shared[0]))
            return InTheWay(other.execution, other.group, check)
        if report.failed is not None:
            return InTheWay(other.execution, other.group, report.failed)
    return None


def _refusal(found: InTheWay) -> NotCertified:
    check = found.check
    distance = check.distance if np.isfinite(check.distance) else None
    near = "" if distance is None else f", {distance:.4g} m where {check.margin:.4g} is the margin"
    message = (
        f"{' and '.join(check.pair)} may meet{near}: the motion at {check.time:.3f} s, and that of "
        f"execution {found.execution}, which moves {found.group} at any time of its own, at "
        f"{check.other_time:.3f} s; wait for its end, plan again, or carry out "
        "both as one (`plans`)"
    )
    value = {"value": distance, "bound": check.margin}
    evidence = {
        "check": BESIDE,
        "pair": list(check.pair),
        "time": check.time,
        **value,
        "execution": found.execution,
        "other_time": check.other_time,
        "checks": [{"name": BESIDE, **value, "where": ""}],
    }
    return NotCertified(message, evidence)
