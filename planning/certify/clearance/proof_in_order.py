"""Proof in order of time: the clearance proof that tells the first instant that is not proven.

The kernel bounds the earlier half of a segment first, so all that comes before the segment at which
it stops is proven. Without the kernel, and where its bounds are undecided, Drake's proof decides.
"""

from dataclasses import dataclass
from functools import partial

import numpy as np

from planning.certify.clearance.clearance_check import check_clearance
from planning.certify.clearance.first_unproven import FirstUnproven
from planning.certify.clearance.native_clearance import prover
from planning.certify.request import CertifyRequest
from planning.domain.request.deadline import Deadline
from planning.world.drake_model import DrakeModel
from planning.world.kernel.kernel_scene import KernelScene, kernel_scene_of

# Resolution of the first instant that is not proven [s].
_RESOLUTION = 1e-3


@dataclass(frozen=True)
class OrderedProof:
    """Result of a proof in order of time.

    Attributes:
        proven: Whether all pairs keep their margins at all times.
        until: They are proven to keep them until then [s].
        bodies: The pair that is not proven then; two empty strings if all are.
        distance: Its signed distance then [m]; infinite if it was not measured.
    """

    proven: bool
    until: float
    bodies: tuple[str, str] = ("", "")
    distance: float = np.inf


def prove_in_order(model: DrakeModel, request: CertifyRequest, deadline: Deadline) -> OrderedProof:
    """Prove clearance, or return until when it is proven, to a millisecond.

    The verdict is that of `check_clearance`.

    Raises:
        DeadlineExceeded: Time ran out before the verdict.
        Canceled: The caller canceled.
        ModelInvalid: A shape or joint of a kind that cannot be certified.
    """
    scene = kernel_scene_of(model)
    if scene is not None:
        result = _native_proof(scene, model, request, deadline)
        if result is not None:
            return result
    if check_clearance(model, request, deadline).check.passed:
        return OrderedProof(proven=True, until=request.trajectory.duration)
    until, pair = FirstUnproven(model, request, deadline).found()
    if pair is None:
        return OrderedProof(proven=False, until=until)
    return OrderedProof(proven=False, until=until, bodies=pair.bodies, distance=pair.distance)


def _native_proof(
    scene: KernelScene, model: DrakeModel, request: CertifyRequest, deadline: Deadline
) -> OrderedProof | None:
    """Return the kernel's result, or None if it is undecided."""
    margins = scene.pair_margins(request.margins)
    proof = prover(scene, model, request, margins).prove_in_order(
        partial(deadline.check, "certify"), _RESOLUTION
    )
    match proof.outcome.name:
        case "PROVEN":
            return OrderedProof(proven=True, until=proof.until)
        case "UNPROVEN":
            return None
        case _:
            bodies = scene.names(proof.pair)
            return OrderedProof(
                proven=False, until=proof.until, bodies=bodies, distance=proof.distance
            )
