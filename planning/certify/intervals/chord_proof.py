"""Chord proof: bounds on a function of a moving point, by chords between instants.

Between two instants h apart a point whose acceleration is at most b stays within b h^2 / 8 of the
chord between its positions at both. A function that changes by no more than the point moves is
hence at most its largest value on the chord, plus that. Intervals on which this does not settle the
bound are halved. The bound is of second order: a motion with a small reserve is proven on intervals
whose length is proportional to the square root of the reserve.
"""

from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np

from planning.certify.intervals.branch_and_bound import BoundResult
from planning.certify.request import CertifyRequest
from planning.domain.arrays import Array
from planning.domain.request.deadline import Deadline

# Tolerance above a bound: a start that lies on it would be refused for rounding.
BOUND_TOLERANCE = 1e-6
# Largest number of instants, and smallest width (as a share of a piece), of a proof.
_MAX_INSTANTS, _MIN_WIDTH = 60_000, 2.0**-40
# Resolution of the largest value, relative to the bound or absolute, and the number of additional
# instants for it.
_RELATIVE_RESOLUTION, _ABSOLUTE_RESOLUTION = 0.02, 1e-4
_REFINEMENT_INSTANTS = 2_000


@runtime_checkable
class ChordQuantity(Protocol):
    """A function of a point that changes by no more than the point moves (Lipschitz constant 1)."""

    def points(self, pieces: Any, local: Array, deadline: Deadline) -> Array:
        """Return the point at instants in pieces, shape (n, 3)."""
        ...

    def values(self, points: Array) -> Array:
        """Return the function at points, shape (n,)."""
        ...

    def chord_bounds(self, begin: Array, end: Array) -> Array:
        """Return upper bounds on the function between two points each, shape (n,)."""
        ...


@dataclass(frozen=True)
class _Intervals:
    """Parts of pieces: the piece, the beginning as a fraction of it, and the point at both ends."""

    pieces: Any
    begin_fractions: Array
    begin: Array
    end: Array

    def __getitem__(self, rows: Any) -> "_Intervals":
        return _Intervals(
            self.pieces[rows], self.begin_fractions[rows], self.begin[rows], self.end[rows]
        )


class ChordProof:
    """One proof: the largest value of a quantity, compared with a bound."""

    def __init__(
        self,
        quantity: ChordQuantity,
        point_bounds: tuple[Array, Array],
        request: CertifyRequest,
        deadline: Deadline,
    ) -> None:
        """Prepare a proof.

        Args:
            quantity: The function to bound.
            point_bounds: Bounds on the point's acceleration and on the rounding error of its
                position, on every piece, each shape (n,).
            request: The request with the trajectory.
            deadline: Time limit.
        """
        self._quantity, self._deadline = quantity, deadline
        self._accelerations, self._errors = point_bounds
        self._breaks = request.trajectory.breaks
        self._widths = np.diff(self._breaks)
        self._largest = self._decided_bound = -np.inf
        self._time, self._num_instants = 0.0, 0

    def run(self, bound: float) -> BoundResult:
        """Prove, or fail to prove, that the quantity is at most a bound on the whole trajectory.

        Raises:
            DeadlineExceeded: Time ran out.
            Canceled: The caller canceled.
        """
        pieces = np.arange(len(self._widths))
        ends = [self._points(pieces, fraction * self._widths) for fraction in (0.0, 1.0)]
        intervals, width = _Intervals(pieces, 0.0 * self._widths, *ends), 1.0
        resolution = max(_RELATIVE_RESOLUTION * abs(bound), _ABSOLUTE_RESOLUTION)
        max_instants = np.inf
        while len(intervals.pieces):
            self._update_largest(intervals, width)
            upper_bounds = self._upper_bounds(intervals, width)
            if self._largest > bound + BOUND_TOLERANCE:
                return self._result(
                    max(self._decided_bound, float(upper_bounds.max())), passed=False
                )
            is_open = upper_bounds > bound + BOUND_TOLERANCE
            if not is_open.any():
                max_instants = min(max_instants, self._num_instants + _REFINEMENT_INSTANTS)
            if self._num_instants < max_instants:
                is_open |= upper_bounds > self._largest + resolution
            if is_open.any() and (self._num_instants > _MAX_INSTANTS or width < _MIN_WIDTH):
                passed = not (upper_bounds > bound + BOUND_TOLERANCE).any()
                return self._result(
                    max(self._decided_bound, float(upper_bounds.max())), passed=passed
                )
            self._decided_bound = max(
                self._decided_bound, float(upper_bounds[~is_open].max(initial=-np.inf))
            )
            width /= 2
            intervals = self._halved(intervals[is_open], width)
        return self._result(self._decided_bound, passed=True)

    def _points(self, pieces: Any, local: Array) -> Array:
        self._num_instants += len(local)
        return self._quantity.points(pieces, local, self._deadline)

    def _update_largest(self, intervals: _Intervals, width: float) -> None:
        for points, offset in ((intervals.begin, 0.0), (intervals.end, width)):
            values = self._quantity.values(points)
            row = int(np.argmax(values))
            if values[row] > self._largest:
                piece = int(intervals.pieces[row])
                fraction = float(intervals.begin_fractions[row]) + offset
                self._largest = float(values[row])
                self._time = float(self._breaks[piece] + fraction * self._widths[piece])

    def _upper_bounds(self, intervals: _Intervals, width: float) -> Array:
        steps = width * self._widths[intervals.pieces]
        deviations = (
            steps**2 / 8 * self._accelerations[intervals.pieces] + self._errors[intervals.pieces]
        )
        return self._quantity.chord_bounds(intervals.begin, intervals.end) + deviations

    def _halved(self, intervals: _Intervals, width: float) -> _Intervals:
        pieces, begin_fractions = intervals.pieces, intervals.begin_fractions
        middle = self._points(pieces, (begin_fractions + width) * self._widths[pieces])
        return _Intervals(
            np.repeat(pieces, 2),
            np.stack([begin_fractions, begin_fractions + width], axis=1).ravel(),
            np.stack([intervals.begin, middle], axis=1).reshape(-1, 3),
            np.stack([middle, intervals.end], axis=1).reshape(-1, 3),
        )

    def _result(self, upper_bound: float, *, passed: bool) -> BoundResult:
        return BoundResult(self._largest, max(upper_bound, self._largest), passed, "", self._time)
