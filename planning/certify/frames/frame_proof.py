"""FrameProof: bounds on a frame's speed and acceleration along a trajectory, by branch and bound.

On an interval of width h the velocity is within h^2 / 8 max |p'''| of the chord between its end
values, and no point of a chord is longer than both its ends; likewise the acceleration with
max |p''''|, and the origin with max |p''|. `origin_bounds` computes the maxima. Intervals on
which the bound is undecided are halved. The rounding error of the samples is added.
"""

from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np

from planning.certify.frames.frame_derivative_bounds import origin_bounds
from planning.certify.frames.frame_states import FrameMotion, FrameStates
from planning.certify.joints.limit_checks import MAX_UTILIZATION
from planning.certify.request import CertifyRequest
from planning.domain.arrays import Array
from planning.domain.report.certificate import Check
from planning.domain.request.deadline import Deadline
from planning.world.drake_model import DrakeModel

# Largest gap between a bound and the samples, relative to them, or relative to the limit.
_RELATIVE_GAP, _MIN_UTILIZATION = 1e-3, 0.01
_MAX_INTERVALS = 40_000
_MIN_WIDTH = 2.0**-40


@dataclass(frozen=True)
class FrameIntervals:
    """Intervals within pieces, with samples of the frame's motion at both ends.

    Attributes:
        pieces: Index of the piece, shape (n,).
        begin_fractions: Beginning of each interval, as a fraction of its piece.
        begin: Motion of the frame at the beginning.
        end: Motion of the frame at the end.
        deviations: Largest deviations of position, velocity and acceleration from the chords
            between the samples, shape (3, n).
    """

    pieces: Any
    begin_fractions: Array
    begin: FrameMotion
    end: FrameMotion
    deviations: Array


@runtime_checkable
class FrameQuantity(Protocol):
    """A quantity of the frame's motion with a limit, and the name of its check."""

    @property
    def name(self) -> str:
        """Name of the check."""
        ...

    @property
    def limit(self) -> float:
        """The limit, in `unit`."""
        ...

    @property
    def unit(self) -> str:
        """Unit of the limit."""
        ...

    def evaluate(self, intervals: FrameIntervals) -> tuple[Array, Array]:
        """Return upper bounds, shape (n,), and the values at both ends, shape (2, n)."""
        ...


class FrameProof:
    """Proofs of several quantities of one frame, which share the samples of its motion."""

    def __init__(
        self,
        model: DrakeModel,
        request: CertifyRequest,
        frame: str,
        quantities: list[FrameQuantity],
    ) -> None:
        """Bound the derivatives of the frame's origin on every piece.

        Raises:
            ModelInvalid: A joint of a kind that cannot be certified.
        """
        self._states = FrameStates(model, request, frame)
        bounds = origin_bounds(model, request, frame)
        self._bounds, self._errors = bounds.derivatives[:, 1:].T, bounds.errors.T
        self._breaks = request.trajectory.breaks
        self._widths = np.diff(self._breaks)
        self._quantities, self._frame = quantities, frame
        count = len(quantities)
        self._utilizations, self._decided_bounds = np.zeros(count), np.zeros(count)
        self._times = np.zeros(count)

    def run(self, deadline: Deadline) -> list[Check]:
        """Return a check for every quantity; values are guaranteed bounds.

        Raises:
            DeadlineExceeded: Time ran out.
            Canceled: The caller canceled.
        """
        with np.errstate(over="ignore", invalid="ignore"):
            self._bisect(deadline)
        return [self._check(i, quantity) for i, quantity in enumerate(self._quantities)]

    def _bisect(self, deadline: Deadline) -> None:
        pieces = np.arange(len(self._widths))
        max_intervals = max(_MAX_INTERVALS, 4 * len(pieces))
        ends = [self._states.at(pieces, at, deadline) for at in (0 * self._widths, self._widths)]
        intervals = self._intervals(pieces, 0.0 * self._widths, 1.0, *ends)
        width, num_evaluated = 1.0, 0
        while len(intervals.pieces):
            is_last = num_evaluated > max_intervals or width < _MIN_WIDTH
            intervals = self._undecided(intervals, width, is_last=is_last)
            num_evaluated += len(intervals.pieces)
            width /= 2
            intervals = self._halved(intervals, width, deadline)

    def _undecided(
        self, intervals: FrameIntervals, width: float, *, is_last: bool
    ) -> FrameIntervals:
        """Update the results; return the intervals that must be halved."""
        is_undecided = np.zeros(len(intervals.pieces), dtype=bool)
        for i, quantity in enumerate(self._quantities):
            upper, utilizations = (
                _nan_as_infinity(part) / quantity.limit for part in quantity.evaluate(intervals)
            )
            end, worst = divmod(int(np.argmax(utilizations)), len(upper))
            if utilizations[end, worst] > self._utilizations[i]:
                self._utilizations[i] = utilizations[end, worst]
                self._times[i] = self._time(intervals, worst, end * width)
            is_open = upper > self._threshold(i)
            is_open &= not is_last
            self._decided_bounds[i] = max(
                self._decided_bounds[i], float(upper[~is_open].max(initial=0.0))
            )
            is_undecided |= is_open
        return FrameIntervals(
            intervals.pieces[is_undecided],
            intervals.begin_fractions[is_undecided],
            intervals.begin[is_undecided],
            intervals.end[is_undecided],
            intervals.deviations[:, is_undecided],
        )

    def _threshold(self, i: int) -> float:
        """Return the bound below which an interval is decided; infinite for a failed limit."""
        if self._utilizations[i] > MAX_UTILIZATION:
            return np.inf
        return min(
            max(self._utilizations[i] * (1 + _RELATIVE_GAP), _MIN_UTILIZATION), MAX_UTILIZATION
        )

    def _halved(
        self, intervals: FrameIntervals, width: float, deadline: Deadline
    ) -> FrameIntervals:
        if not len(intervals.pieces):
            return intervals
        begin_fractions, pieces = intervals.begin_fractions, intervals.pieces
        middle = self._states.at(pieces, (begin_fractions + width) * self._widths[pieces], deadline)
        return self._intervals(
            np.repeat(pieces, 2),
            np.stack([begin_fractions, begin_fractions + width], axis=1).ravel(),
            width,
            intervals.begin.interleaved(middle),
            middle.interleaved(intervals.end),
        )

    def _intervals(
        self,
        pieces: Any,
        begin_fractions: Array,
        width: float,
        begin: FrameMotion,
        end: FrameMotion,
    ) -> FrameIntervals:
        steps = width * self._widths[pieces]
        deviations = steps**2 / 8 * self._bounds[:, pieces] + self._errors[:, pieces]
        return FrameIntervals(pieces, begin_fractions, begin, end, deviations)

    def _time(self, intervals: FrameIntervals, row: int, offset: float) -> float:
        piece = int(intervals.pieces[row])
        return float(
            self._breaks[piece] + (intervals.begin_fractions[row] + offset) * self._widths[piece]
        )

    def _check(self, i: int, quantity: FrameQuantity) -> Check:
        utilization = max(float(self._utilizations[i]), float(self._decided_bounds[i]))
        if self._utilizations[i] > MAX_UTILIZATION:
            utilization = float(self._utilizations[i])
        return Check(
            name=quantity.name,
            value=utilization * quantity.limit,
            bound=quantity.limit,
            unit=quantity.unit,
            resolution=0.0,
            passed=utilization <= MAX_UTILIZATION,
            where=self._frame,
            time=float(self._times[i]),
        )


def _nan_as_infinity(values: Array) -> Array:
    """Return the values with NaN, the result of overflow, replaced by infinity."""
    return np.where(np.isnan(values), np.inf, values)
