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
    motion_checks,
    place_checks,
    special_checks,
    unchecked_of,
    without_bends,
)
from planning.certify.clearance.clearance_check import check_clearance
from planning.certify.clearance.clearance_result import MARGIN_SLACK
from planning.certify.clearance.levers import levers_of
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
    judge = _Judge(model, request, samples, clearance, deadline, errors)
    return tuple(judge.verdict(kind) for kind in KINDS)


_NO_TIME = "there was no time left to prove it"


@dataclass(frozen=True)
class _Judge:
    """Proof of all interpolants of one set of samples."""

    model: DrakeModel
    request: CertifyRequest
    samples: SampledTrajectory
    clearance: float
    deadline: Deadline
    errors: HermiteErrors | None

    @cached_property
    def way(self) -> float:
        """Allowed approach of two shapes beyond that along the motion [m]."""
        return self.clearance - self.request.margins.largest + MARGIN_SLACK

    @cached_property
    def levers(self) -> Array:
        return levers_of(self.model, self.request)

    @cached_property
    def deviations(self) -> Deviations:
        return Deviations(self.request.trajectory, self.samples.times)

    @cached_property
    def has_more(self) -> bool:
        """Whether the request has constraints other than joint limits and clearance."""
        request = self.request
        more = (request.constraints, request.lines, request.tool_limits, request.speed_zones)
        return any(more) or request.effort or bool(steering_of(request.group))

    def verdict(self, kind: Interpolation) -> InterpolationProof:
        is_straight = kind == "linear"
        if not (is_straight or self.request.trajectory.manifold.is_flat):
            reason = "samples do not say how joints that float turn between them"
            return InterpolationProof(kind, False, np.inf, None, reason=reason)  # noqa: FBT003
        try:
            return self._held_to_all(kind)
        except DeadlineExceeded:
            return InterpolationProof(kind, False, np.inf, None, reason=_NO_TIME)  # noqa: FBT003

    def _held_to_all(self, kind: Interpolation) -> InterpolationProof:
        self.deadline.check("certify")
        is_straight = kind == "linear"
        made = interpolated(self.samples, kind)
        asked = replace(self.request, trajectory=made, options=CertifyOptions())
        apart = self.deviations.of(made)
        checks = self._checks(without_bends(asked) if is_straight else asked, apart, kind)
        failed = tuple(check for check in checks if not check.passed)
        proven = not failed
        unchecked = unchecked_of(self.request) if is_straight else ()
        period = self._period(kind, proven=proven)
        deviation = float(apart.max())
        return InterpolationProof(kind, proven, deviation, period, failed, unchecked)

    def _checks(self, asked: CertifyRequest, apart: Array, kind: Interpolation) -> list[Check]:
        own = place_checks(asked) if kind == "linear" else motion_checks(asked)
        found = [*own, *special_checks(self.model, asked, self.deadline)]
        # Zero deviation times an infinite lever is zero.
        nearer = np.multiply(apart, self.levers, out=np.zeros_like(apart), where=apart > 0)
        if not float(nearer.sum(axis=1).max()) <= self.way:
            found.append(check_clearance(self.model, asked, self.deadline).check)
        return found

    def _period(self, kind: Interpolation, *, proven: bool) -> float | None:
        seen, longest = self.samples.longest_gap, 0.0
        if self.errors is not None and not self.has_more:
            longest = self.errors.longest(kind, self.levers, self.way)
        if proven:
            return max(seen, longest)
        # Where these samples fail, no longer period can be proven.
        return longest if 0 < longest < seen else None


def interpolated(samples: SampledTrajectory, kind: Interpolation) -> TimedTrajectory:
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
