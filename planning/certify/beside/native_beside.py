"""Proof for two motions by the native kernel; the method is explained in `beside_check`."""

from functools import partial
from typing import Any

import numpy as np

from planning.certify.beside.beside_request import BesideRequest, BesideResult
from planning.certify.clearance.clearance_result import MARGIN_TOLERANCE
from planning.certify.intervals.jumps import unwrap_turns
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.request.deadline import Deadline
from planning.domain.robot.joints import JointGroup
from planning.kernel.native import native
from planning.world.drake_model import DrakeModel
from planning.world.kernel.kernel_scene import KernelScene


def native_beside(
    scene: KernelScene, model: DrakeModel, request: BesideRequest, deadline: Deadline
) -> BesideResult:
    """Prove, or fail to prove, that two motions keep their margins at any times of both.

    Raises:
        DeadlineExceeded: Time ran out; nothing is proven.
        Canceled: The caller canceled.
    """
    module: Any = native()
    margins = scene.pair_margins(request.margins)
    motions = [
        _arguments(model, group, trajectory)
        for group, trajectory in zip(request.groups, request.trajectories, strict=True)
    ]
    prover = module.BesideProver(
        scene.native, *motions, np.array(request.state), margins, MARGIN_TOLERANCE
    )
    proof = prover.prove(partial(deadline.check, "certify"))
    worst = proof.worst
    has_pair = worst.pair >= 0
    return BesideResult(
        outcome=proof.outcome.name,
        bodies=scene.names(worst.pair) if has_pair else ("", ""),
        distance=worst.distance,
        margin=float(margins[worst.pair]) if has_pair else 0.0,
        times=worst.times,
        num_segments=proof.segments,
    )


def _arguments(
    model: DrakeModel, group: JointGroup, trajectory: TimedTrajectory
) -> tuple[Any, ...]:
    """Return a group's positions and velocities in the plant, and its motion, for the kernel."""
    curve = unwrap_turns(trajectory)
    return (
        model.position_indices(group).astype(np.int64),
        model.velocity_indices(group).astype(np.int64),
        curve.breaks,
        curve.bases,
        curve.coefficients,
    )
