"""The proof of a plan's motion in another revision of its scene than it was planned in."""

import time

from planning import Deadline, certify_trajectory
from planning.domain.report.certificate import Certificate
from planning.errors import NotCertified
from service.executions.tasks import PROVE, Proof, ProofWork
from service.jobs.context import TaskContext
from service.scenes.world_cache import borrow_world

# A motion is proven in milliseconds, or it is a hard case [s].
_ALLOWED = 10.0


@PROVE.runs
def certify_again(work: ProofWork, context: TaskContext) -> Proof:
    """Hold the motion against the scene with all that its plan was asked for.

    Raises:
        NotCertified: It is not proven; evidence has `check`, `pair`, `time` and all failed checks.
        DeadlineExceeded: Time ran out before the verdict.
        InputError: What the plan names is not in this scene any more.
    """
    # A motion backwards keeps what the one forwards was asked to keep.
    problem = (work.origin or work.request).to_domain()
    with borrow_world(work) as world:
        certificate, _ = certify_trajectory(
            world,
            problem.group,
            work.trajectory.to_domain(),
            deadline=Deadline.after(_ALLOWED, time.monotonic, context.is_canceled),
            options=problem.retime,
            margin=problem.margin,
            constraints=problem.constraints,
        )
    if not certificate.proven:
        raise _refusal(certificate)
    return Proof(min_clearance=certificate.min_clearance)


def _refusal(certificate: Certificate) -> NotCertified:
    worst = certificate.failed[0]
    pair = list(certificate.pair) if worst.name == "clearance" else []
    named = f" ({' and '.join(pair)})" if pair else f" ({worst.where})" if worst.where else ""
    message = (
        f"the motion does not hold in the latest revision of the scene: {worst.name} is "
        f"{worst.value:.4g} {worst.unit} where {worst.bound:.4g} is the bound{named}, at "
        f"{worst.time:.3f} s; plan again"
    )
    evidence = {
        "check": worst.name,
        "pair": pair,
        "time": worst.time,
        "value": worst.value,
        "bound": worst.bound,
        "checks": [
            {"name": check.name, "value": check.value, "bound": check.bound, "where": check.where}
            for check in certificate.failed
        ],
    }
    return NotCertified(message, evidence)
