"""Clearance proof by the native kernel, on the whole interval.

Branch and bound as in `drake_clearance`, with two differences. The kernel bounds every distance
from both sides itself, so that no other distance query is needed. And where the direct bound on the
approach of two shapes is too coarse, it bounds the width of a slab between them to second order,
which allows much longer segments (motion_bounds.hpp). The proof shares with the collision checks of
the search only the definitions of a shape, a pose and the distance of two convex shapes.
"""

from functools import partial
from typing import Any

import numpy as np

from planning.certify.clearance.clearance_result import (
    MARGIN_TOLERANCE,
    ClearanceResult,
    WitnessPoint,
)
from planning.certify.intervals.jumps import unwrap_turns
from planning.certify.request import CertifyRequest
from planning.domain.report.certificate import Check
from planning.domain.request.deadline import Deadline
from planning.kernel.native import native
from planning.world.drake_model import DrakeModel
from planning.world.kernel.kernel_scene import KernelScene

# Outcomes that come with the closest approach of all pairs.
_MEASURED = ("PROVEN", "TOO_NEAR")


def native_clearance(
    scene: KernelScene, model: DrakeModel, request: CertifyRequest, deadline: Deadline
) -> ClearanceResult:
    """Prove, or fail to prove, that every pair of bodies keeps its margin at all times.

    Raises:
        DeadlineExceeded: Time ran out; nothing is proven.
        Canceled: The caller canceled.
    """
    margins = scene.pair_margins(request.margins)
    proof = prover(scene, model, request, margins).prove(partial(deadline.check, "certify"))
    return ClearanceResult(
        check=_check(scene, proof, margins),
        nearest=_witness(scene, proof.nearest),
        reported=_witness(scene, _worst(proof)),
        num_segments=proof.segments,
        num_queries=proof.looks,
        is_decided=proof.outcome.name != "UNPROVEN",
    )


def prover(scene: KernelScene, model: DrakeModel, request: CertifyRequest, margins: Any) -> Any:
    """Return the kernel's Prover for a request."""
    module: Any = native()
    group, curve = request.group, unwrap_turns(request.trajectory)
    return module.Prover(
        scene.native,
        model.position_indices(group).astype(np.int64),
        model.velocity_indices(group).astype(np.int64),
        request.state,
        (curve.breaks, curve.bases, curve.coefficients),
        margins,
        MARGIN_TOLERANCE,
    )


def _check(scene: KernelScene, proof: Any, margins: Any) -> Check:
    """Return the check of the pair with the smallest reserve, or of the unproven pair."""
    worst, passed = _worst(proof), proof.outcome.name == "PROVEN"
    pair = worst.pair
    if proof.outcome.name in _MEASURED:
        resolution = max(0.0, proof.nearest.distance - proof.floor) if pair >= 0 and passed else 0.0
    else:
        resolution = proof.uncertainty
    return Check(
        name="clearance",
        value=worst.distance,
        bound=float(margins[pair]) if pair >= 0 else 0.0,
        unit="m",
        resolution=resolution,
        passed=passed,
        where="-".join(scene.names(pair)) if pair >= 0 else "",
        time=worst.time,
    )


def _witness(scene: KernelScene, record: Any) -> WitnessPoint:
    if record.pair < 0:
        return WitnessPoint()
    return WitnessPoint(
        scene.pair(record.pair), scene.names(record.pair), record.distance, record.time
    )


def _worst(proof: Any) -> Any:
    """Return the record of the worst pair: the closest approach, or the proof itself."""
    return proof.tightest if proof.outcome.name in _MEASURED else proof
