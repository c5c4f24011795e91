"""Clearance on the whole interval, proven by the native code.

The same bisection as `clearance`, with two differences. Every distance is computed there from both
sides, so that no other distance is needed. And where the direct bound on how much nearer two shapes
can come is too coarse, it bounds to second order how a slab between them narrows, which takes much
longer segments (motion_bounds.hpp). What it shares with the collision checks of the search is what
a shape, a pose and a distance of two convex shapes are, and no more.
"""

from functools import partial
from typing import Any

import numpy as np

from planning.certify.clearance.clearance_result import MARGIN_SLACK, ClearanceResult, WitnessPoint
from planning.certify.intervals.jumps import in_one_turn
from planning.certify.request import CertifyRequest
from planning.domain.report.certificate import Check
from planning.domain.request.deadline import Deadline
from planning.kernel.native import native
from planning.world.drake_model import DrakeModel
from planning.world.kernel.kernel_scene import KernelScene

# The kernel's numbers for outcomes (prover.hpp).
_PROVEN, _TOO_NEAR, _UNPROVEN = 0, 1, 2


def native_clearance(
    scene: KernelScene, model: DrakeModel, request: CertifyRequest, deadline: Deadline
) -> ClearanceResult:
    """Prove, or fail to prove, that every pair of bodies keeps its margin throughout.

    Raises:
        DeadlineExceeded: Time ran out; nothing is proven.
        Canceled: The end was asked for.
    """
    margins = scene.demands(request.margins)
    proof = prover(scene, model, request, margins).prove(partial(deadline.check, "certify"))
    return ClearanceResult(
        check=_check(scene, proof, margins),
        nearest=_spot(scene, proof.nearest),
        checked=_spot(scene, _worst(proof)),
        intervals=proof.segments,
        queries=proof.looks,
        is_decided=proof.outcome != _UNPROVEN,
    )


def prover(scene: KernelScene, model: DrakeModel, request: CertifyRequest, margins: Any) -> Any:
    """Return the kernel's Prover of a request."""
    module: Any = native()
    group, curve = request.group, in_one_turn(request.trajectory)
    return module.Prover(
        scene.native,
        model.position_indices(group).astype(np.int64),
        model.velocity_indices(group).astype(np.int64),
        request.state,
        (curve.breaks, curve.bases, curve.coefficients),
        margins,
        MARGIN_SLACK,
    )


def _check(scene: KernelScene, proof: Any, margins: Any) -> Check:
    """Return the verdict: of the pair with the least to spare, or of the one that cannot be."""
    worst, passed = _worst(proof), proof.outcome == _PROVEN
    pair = worst.pair
    if proof.outcome in {_PROVEN, _TOO_NEAR}:
        gap = max(0.0, proof.nearest.distance - proof.floor) if pair >= 0 and passed else 0.0
    else:
        gap = proof.uncertainty
    return Check(
        name="clearance",
        value=worst.distance,
        bound=float(margins[pair]) if pair >= 0 else 0.0,
        unit="m",
        resolution=gap,
        passed=passed,
        where="-".join(scene.names(pair)) if pair >= 0 else "",
        time=worst.time,
    )


def _spot(scene: KernelScene, seen: Any) -> WitnessPoint:
    if seen.pair < 0:
        return WitnessPoint()
    return WitnessPoint(scene.pair(seen.pair), scene.names(seen.pair), seen.distance, seen.time)


def _worst(proof: Any) -> Any:
    """Return the sighting, or the proof itself, that has the pair to tell of."""
    return proof.tightest if proof.outcome in {_PROVEN, _TOO_NEAR} else proof
