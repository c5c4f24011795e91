"""What receivers make of a motion's samples, held to what the motion was proven to keep.

A receiver of positions alone goes straight from sample to sample, one of velocities too follows the
polynomial of degree 3 that meets them, one of accelerations too that of degree 5. Each is another
motion than the one that was proven, and is proven by itself: its ends, limits and constraints by
the checks of every certificate, on its own polynomials. Its clearance follows from that of the
motion if their deviation, times the levers of all joints, is less than the motion has to spare;
else it is proven like any other.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

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

type Array = np.ndarray[Any, np.dtype[np.float64]]

KINDS: tuple[Interpolation, ...] = ("linear", "cubic", "quintic")


def prove_interpolants(
    model: DrakeModel,
    request: CertifyRequest,
    samples: SampledTrajectory,
    clearance: float,
    deadline: Deadline,
    errors: HermiteErrors | None = None,
) -> tuple[InterpolationProof, ...]:
    """Return a verdict on each of what receivers may make of samples.

    Args:
        model: The scene.
        request: The motion, and what it was proven to keep.
        samples: Of that motion.
        clearance: What the distance of no two bodies is below along the motion, as was proven
            [m]; minus infinity if that is not known.
        deadline: When to stop; what is not proven by then is told as not proven.
        errors: What interpolation misses of the motion, if that is bounded.

    Raises:
        Canceled: The caller canceled.
        ModelInvalid: The scene has a shape or joint of a kind that cannot be certified.
    """
    judge = _Judge(model, request, samples, clearance, deadline, errors)
    return tuple(judge.verdict(kind) for kind in KINDS)


_NO_TIME = "there was no time left to prove it"


@dataclass(frozen=True)
class _Judge:
    model: DrakeModel
    request: CertifyRequest
    samples: SampledTrajectory
    clearance: float
    deadline: Deadline
    errors: HermiteErrors | None

    @cached_property
    def way(self) -> float:
        """How much nearer two shapes may come than along the motion [m]."""
        return self.clearance - self.request.margins.largest + MARGIN_SLACK

    @cached_property
    def levers(self) -> Array:
        return levers_of(self.model, self.request)

    @cached_property
    def deviations(self) -> Deviations:
        return Deviations(self.request.trajectory, self.samples.times)

    @cached_property
    def has_more(self) -> bool:
        """Whether the motion was held to more than limits of joints and clearance."""
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
        # Where nothing is apart an infinite lever moves nothing.
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
        # Where these samples fail, what is said of longer periods cannot be so.
        return longest if 0 < longest < seen else None


def interpolated(samples: SampledTrajectory, kind: Interpolation) -> TimedTrajectory:
    """Return the motion that samples stand for; only straight lines if joints float."""
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
