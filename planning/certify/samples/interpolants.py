"""Interpolants: the motions that receivers make of samples, checked against the proven properties.

A receiver of positions alone interpolates linearly, one of velocities too by cubic Hermite
polynomials, one of accelerations too by quintic ones. Each interpolant differs from the proven
motion, and is proven by itself: its ends, limits and constraints by the checks of every
certificate, on its own polynomials. Its clearance follows from that of the motion if their
deviation, times the lever arms of all joints, is less than the motion's reserve; else it is proven
like that of any other motion.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from planning.certify.certifier import (
    additional_checks,
    motion_checks,
    polyline_checks,
    skipped_checks,
    without_smoothness_limits,
)
from planning.certify.clearance.clearance_check import check_clearance
from planning.certify.clearance.clearance_result import MARGIN_TOLERANCE
from planning.certify.clearance.lever_arms import lever_arms_of
from planning.certify.intervals.hermite_errors import HermiteErrors
from planning.certify.request import CertifyRequest
from planning.certify.samples.deviation import Deviations
from planning.domain.arrays import Array
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.curves.interpolation import polyline_through, trajectory_through
from planning.domain.curves.interpolation_proof import Interpolation, InterpolationProof
from planning.domain.curves.sampling import SampledTrajectory
from planning.domain.report.certificate import Check
from planning.domain.request.deadline import Deadline
from planning.domain.request.options import CertifyOptions
from planning.domain.robot.steering import steering_of
from planning.errors import DeadlineExceeded
from planning.world.drake_model import DrakeModel

KINDS: tuple[Interpolation, ...] = ("linear", "cubic", "quintic")


def prove_interpolants(
    model: DrakeModel,
    request: CertifyRequest,
    samples: SampledTrajectory,
    clearance: float,
    deadline: Deadline,
    errors: HermiteErrors | None = None,
) -> tuple[InterpolationProof, ...]:
    """Return a proof or refusal for each kind of interpolation of the samples.

    Args:
        model: The scene.
        request: The motion, and its proven properties.
        samples: Samples of that motion.
        clearance: Proven lower bound on the distance of any two bodies along the motion [m]; minus
            infinity if unknown.
        deadline: Time limit; interpolants not proven by then are returned as not proven.
        errors: Bounds on interpolation errors of the motion, if known.

    Raises:
        Canceled: The caller canceled.
        ModelInvalid: The scene has a shape or joint of a kind that cannot be certified.
    """
    checker = _InterpolantChecker(model, request, samples, clearance, deadline, errors)
    return tuple(checker.check(kind) for kind in KINDS)


_NO_TIME = "the time limit was reached before the proof was complete"


@dataclass(frozen=True)
class _InterpolantChecker:
    """Proof of all interpolants of one set of samples."""

    model: DrakeModel
    request: CertifyRequest
    samples: SampledTrajectory
    clearance: float
    deadline: Deadline
    errors: HermiteErrors | None

    @cached_property
    def allowed_approach(self) -> float:
        """Allowed approach of two shapes beyond that along the motion [m]."""
        return self.clearance - self.request.margins.largest + MARGIN_TOLERANCE

    @cached_property
    def lever_arms(self) -> Array:
        return lever_arms_of(self.model, self.request)

    @cached_property
    def deviations(self) -> Deviations:
        return Deviations(self.request.trajectory, self.samples.times)

    @cached_property
    def has_other_constraints(self) -> bool:
        """Whether the request has constraints other than joint limits and clearance."""
        request = self.request
        others = (request.constraints, request.lines, request.tool_limits, request.speed_zones)
        return any(others) or request.effort or bool(steering_of(request.group))

    def check(self, kind: Interpolation) -> InterpolationProof:
        is_straight = kind == "linear"
        if not (is_straight or self.request.trajectory.manifold.is_flat):
            reason = "samples of a floating joint do not determine its rotation between them"
            return InterpolationProof(kind, False, np.inf, None, reason=reason)  # noqa: FBT003
        try:
            return self._prove(kind)
        except DeadlineExceeded:
            return InterpolationProof(kind, False, np.inf, None, reason=_NO_TIME)  # noqa: FBT003

    def _prove(self, kind: Interpolation) -> InterpolationProof:
        self.deadline.check("certify")
        is_straight = kind == "linear"
        interpolant = interpolate_samples(self.samples, kind)
        request = replace(self.request, trajectory=interpolant, options=CertifyOptions())
        deviations = self.deviations.of(interpolant)
        checks = self._checks(
            without_smoothness_limits(request) if is_straight else request, deviations, kind
        )
        failed = tuple(check for check in checks if not check.passed)
        proven = not failed
        unchecked = skipped_checks(self.request) if is_straight else ()
        period = self._period(kind, proven=proven)
        deviation = float(deviations.max())
        return InterpolationProof(kind, proven, deviation, period, failed, unchecked)

    def _checks(
        self, request: CertifyRequest, deviations: Array, kind: Interpolation
    ) -> list[Check]:
        trajectory_checks = polyline_checks(request) if kind == "linear" else motion_checks(request)
        checks = [*trajectory_checks, *additional_checks(self.model, request, self.deadline)]
        # Zero deviation times an infinite lever arm is zero.
        approaches = np.multiply(
            deviations, self.lever_arms, out=np.zeros_like(deviations), where=deviations > 0
        )
        if not float(approaches.sum(axis=1).max()) <= self.allowed_approach:
            checks.append(check_clearance(self.model, request, self.deadline).check)
        return checks

    def _period(self, kind: Interpolation, *, proven: bool) -> float | None:
        longest_gap, max_period = self.samples.longest_gap, 0.0
        if self.errors is not None and not self.has_other_constraints:
            max_period = self.errors.max_sample_period(kind, self.lever_arms, self.allowed_approach)
        if proven:
            return max(longest_gap, max_period)
        # Where these samples fail, no longer period can be proven.
        return max_period if 0 < max_period < longest_gap else None


def interpolate_samples(samples: SampledTrajectory, kind: Interpolation) -> TimedTrajectory:
    """Return the interpolated motion of samples; only linear with floating joints."""
    joints, times, positions = samples.joints, samples.times, samples.positions
    match kind:
        case "linear":
            return polyline_through(joints, times, positions)
        case "cubic":
            return trajectory_through(joints, times, positions, samples.velocities)
        case "quintic":
            rates = samples.velocities, samples.accelerations
            return trajectory_through(joints, times, positions, *rates)
        case "cubic_spline":
            return trajectory_through(joints, times, positions)
