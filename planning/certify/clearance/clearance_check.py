"""Clearance check: proof on the whole interval, by the kernel's bounds, then Drake's distances."""

from collections.abc import Callable
from dataclasses import replace

from planning.certify.clearance.clearance_result import ClearanceResult
from planning.certify.clearance.drake_clearance import DrakeProof
from planning.certify.clearance.native_clearance import native_clearance
from planning.certify.request import CertifyRequest
from planning.domain.request.deadline import Deadline
from planning.world.drake_model import DrakeModel
from planning.world.kernel.kernel_scene import kernel_scene_of

type Proof = Callable[[DrakeModel, CertifyRequest, Deadline], ClearanceResult]

# Largest number of segments for Drake's proof where the kernel's is undecided: about one second.
_MAX_DRAKE_SEGMENTS = 2_000


def quick_clearance(
    model: DrakeModel, request: CertifyRequest, deadline: Deadline
) -> ClearanceResult:
    """Prove clearance by the kernel alone, if it supports the scene; else by Drake alone.

    Raises:
        DeadlineExceeded: Time ran out; nothing is proven.
        Canceled: The caller canceled.
        ModelInvalid: A shape or joint of a kind that cannot be certified.
    """
    scene = kernel_scene_of(model)
    if scene is not None:
        return native_clearance(scene, model, request, deadline)
    return DrakeProof(model, request, deadline).run()


def check_clearance(
    model: DrakeModel,
    request: CertifyRequest,
    deadline: Deadline,
    first_proof: Proof = quick_clearance,
) -> ClearanceResult:
    """Prove, or fail to prove, that every pair of bodies keeps its margin at all times.

    If the first proof is undecided (the kernel's bounds do not suffice even on the shortest
    segments), the proof is repeated with Drake's distances before the motion is refused.

    Raises:
        DeadlineExceeded: Time ran out; nothing is proven.
        Canceled: The caller canceled.
        ModelInvalid: A shape or joint of a kind that cannot be certified.
    """
    result = first_proof(model, request, deadline)
    if result.is_decided:
        return result
    second = DrakeProof(model, request, deadline, _MAX_DRAKE_SEGMENTS).run()
    counts = result.num_segments + second.num_segments, result.num_queries + second.num_queries
    chosen = second if second.check.passed else result
    return replace(chosen, num_segments=counts[0], num_queries=counts[1])
