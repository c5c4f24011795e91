"""Clearance on the whole interval: the kernel's bounds first, then Drake's distances."""

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

# Segments that Drake is asked about where the kernel could not decide: a second or so.
_SECOND_LOOK = 2_000


def quick_clearance(
    model: DrakeModel, request: CertifyRequest, deadline: Deadline
) -> ClearanceResult:
    """Prove clearance by the kernel alone, if it has the scene; else by Drake alone.

    Raises:
        DeadlineExceeded: Time ran out; nothing is proven.
        Canceled: The end was asked for.
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
    first: Proof = quick_clearance,
) -> ClearanceResult:
    """Prove, or fail to prove, that every pair of bodies keeps its margin throughout.

    What the first proof neither proves nor refutes (the kernel's bounds do not decide on segments
    as short as any) Drake is asked about before the motion is refused.

    Raises:
        DeadlineExceeded: Time ran out; nothing is proven.
        Canceled: The end was asked for.
        ModelInvalid: A shape or joint of a kind that cannot be certified.
    """
    found = first(model, request, deadline)
    if found.is_decided:
        return found
    second = DrakeProof(model, request, deadline, _SECOND_LOOK).run()
    looks = found.intervals + second.intervals, found.queries + second.queries
    chosen = second if second.check.passed else found
    return replace(chosen, intervals=looks[0], queries=looks[1])
