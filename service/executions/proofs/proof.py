"""Proofs of motions before they are carried out: of plans in another revision, of one's own."""

import time
from collections.abc import Sequence
from typing import Any

import numpy as np

from planning import Deadline, TimedTrajectory, certify_trajectory
from planning.domain.report.certificate import Certificate, Check
from planning.errors import NotCertified, ProblemInvalid
from service.executions.proofs.tasks import PROVE, PROVE_MOTION, Proof, ProofWork, ProvenMotion
from service.jobs.context import TaskContext
from service.plans.models.trajectory import Polynomial
from service.scenes.tasks import RequestWork
from service.scenes.world_cache import borrow_world
from service.trajectories.demands import deadline_of, demands_of, options_of
from service.trajectories.models import CertifyMotionRequest

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
    trajectory = work.trajectory.to_domain()
    with borrow_world(work) as world:
        certificate, _ = certify_trajectory(
            world,
            problem.group,
            trajectory,
            deadline=Deadline.after(_ALLOWED, time.monotonic, context.is_canceled),
            options=problem.retime,
            margin=problem.margin,
            constraints=problem.constraints,
        )
    if not certificate.proven:
        raise refusal(certificate, trajectory)
    return Proof(min_clearance=certificate.min_clearance)


@PROVE_MOTION.runs
def prove_motion(work: RequestWork[CertifyMotionRequest], context: TaskContext) -> ProvenMotion:
    """Hold a motion of the client against the scene, and return it if it is proven.

    Raises:
        NotCertified: It is not proven; evidence as of `certify_again`.
        DeadlineExceeded: Time ran out before the verdict.
        InputError: It does not fit the scene, or is made of straight lines, which have corners.
    """
    request = work.request
    with borrow_world(work) as world:
        trajectory, kind = request.trajectory.to_domain(
            world.group(request.group), "trajectory.trajectory"
        )
        if kind == "linear":
            message = "trajectory.trajectory.interpolation: no robot follows straight lines, which "
            message += "have corners; `/v1/trajectories/retime` times a path"
            field = "trajectory.trajectory.interpolation"
            raise ProblemInvalid(message, {"field": field})
        certificate, _ = certify_trajectory(
            world,
            request.group,
            trajectory,
            deadline=deadline_of(request, context),
            start=request.start,
            goal=request.goal,
            **demands_of(request, options_of(request, limit_jerk=request.limit_jerk)),
        )
    if not certificate.proven:
        raise refusal(certificate, trajectory)
    polynomial = Polynomial.from_domain(trajectory)
    return ProvenMotion(
        trajectory=polynomial,
        start=trajectory.start.tolist(),
        min_clearance=certificate.min_clearance,
    )


def refusal(
    certificate: Certificate, trajectory: TimedTrajectory, failed: Sequence[Check] = ()
) -> NotCertified:
    """Return the failure of a motion that is not proven.

    Args:
        certificate: Of the motion.
        trajectory: The motion: where each check fails.
        failed: The failed checks that count; none for all of them.
    """
    failed = failed or certificate.failed
    worst = failed[0]
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
        "checks": _checks(failed, trajectory),
    }
    return NotCertified(message, evidence)


def _checks(failed: Sequence[Check], trajectory: TimedTrajectory) -> list[dict[str, Any]]:
    names = ("name", "value", "bound", "unit", "where", "time")
    places = trajectory.positions(np.array([check.time for check in failed])).tolist()
    return [
        {**{name: getattr(check, name) for name in names}, "positions": q}
        for check, q in zip(failed, places, strict=True)
    ]
