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
SLACK = 1e-6
# Largest number of instants, and smallest width (as a share of a piece), of a proof.
_MOST_INSTANTS, _NARROWEST = 60_000, 2.0**-40
# Resolution of the largest value, relative to the bound or absolute, and the number of additional
# instants for it.
_RESOLUTION, _LEAST = 0.02, 1e-4
_TIGHTENING = 2_000


@runtime_checkable
class ChordQuantity(Protocol):
    """A function of a point that changes by no more than the point moves (Lipschitz constant 1)."""

    def points(self, pieces: Any, local: Array, deadline: Deadline) -> Array:
        """Return the point at instants in pieces, shape (n, 3)."""
        ...

    def values(self, points: Array) -> Array:
        """Return the function at points, shape (n,)."""
        ...

    def on_chords(self, begin: Array, end: Array) -> Array:
        """Return upper bounds on the function between two points each, shape (n,)."""
        ...


@dataclass(frozen=True)
class _Intervals:
    """Parts of pieces: the piece, the beginning as a fraction of it, and the point at both ends."""

    pieces: Any
    low: Array
    begin: Array
    end: Array

    def __getitem__(self, rows: Any) -> "_Intervals":
        return _Intervals(self.pieces[rows], self.low[rows], self.begin[rows], self.end[rows])


class ChordProof:
    """One proof: the largest value of a quantity, compared with a bound."""

    def __init__(
        self,
        quantity: ChordQuantity,
        bends: tuple[Array, Array],
        request: CertifyRequest,
        deadline: Deadline,
    ) -> None:
        """Prepare a proof.

        Args:
            quantity: The function to bound.
            bends: Bounds on the point's acceleration and on the rounding error of its position, on
                every piece, each shape (n,).
            request: The request with the trajectory.
            deadline: Time limit.
        """
        self._quantity, self._deadline = quantity, deadline
        self._bends, self._errors = bends
        self._breaks = request.trajectory.breaks
        self._widths = np.diff(self._breaks)
        self._seen, self._time, self._count, self._settled = -np.inf, 0.0, 0, -np.inf

    def run(self, bound: float) -> BoundResult:
        """Prove, or fail to prove, that the quantity is at most a bound on the whole trajectory.

        Raises:
            DeadlineExceeded: Time ran out.
            Canceled: The caller canceled.
        """
        pieces = np.arange(len(self._widths))
        ends = [self._points(pieces, share * self._widths) for share in (0.0, 1.0)]
        intervals, width = _Intervals(pieces, 0.0 * self._widths, *ends), 1.0
        fine = max(_RESOLUTION * abs(bound), _LEAST)
        last = np.inf
        while len(intervals.pieces):
            self._look(intervals, width)
            uppers = self._uppers(intervals, width)
            if self._seen > bound + SLACK:
                return self._finding(max(self._settled, float(uppers.max())), passed=False)
            is_open = uppers > bound + SLACK
            if not is_open.any():
                last = min(last, self._count + _TIGHTENING)
            if self._count < last:
                is_open |= uppers > self._seen + fine
            if is_open.any() and (self._count > _MOST_INSTANTS or width < _NARROWEST):
                passed = not (uppers > bound + SLACK).any()
                return self._finding(max(self._settled, float(uppers.max())), passed=passed)
            self._settled = max(self._settled, float(uppers[~is_open].max(initial=-np.inf)))
            width /= 2
            intervals = self._halved(intervals[is_open], width)
        return self._finding(self._settled, passed=True)

    def _points(self, pieces: Any, local: Array) -> Array:
        self._count += len(local)
        return self._quantity.points(pieces, local, self._deadline)

    def _look(self, intervals: _Intervals, width: float) -> None:
        for points, beyond in ((intervals.begin, 0.0), (intervals.end, width)):
            values = self._quantity.values(points)
            row = int(np.argmax(values))
            if values[row] > self._seen:
                piece = int(intervals.pieces[row])
                share = float(intervals.low[row]) + beyond
                self._seen = float(values[row])
                self._time = float(self._breaks[piece] + share * self._widths[piece])

    def _uppers(self, intervals: _Intervals, width: float) -> Array:
        steps = width * self._widths[intervals.pieces]
        strays = steps**2 / 8 * self._bends[intervals.pieces] + self._errors[intervals.pieces]
        return self._quantity.on_chords(intervals.begin, intervals.end) + strays

    def _halved(self, intervals: _Intervals, width: float) -> _Intervals:
        pieces, low = intervals.pieces, intervals.low
        middle = self._points(pieces, (low + width) * self._widths[pieces])
        return _Intervals(
            np.repeat(pieces, 2),
            np.stack([low, low + width], axis=1).ravel(),
            np.stack([intervals.begin, middle], axis=1).reshape(-1, 3),
            np.stack([middle, intervals.end], axis=1).reshape(-1, 3),
        )

    def _finding(self, top: float, *, passed: bool) -> BoundResult:
        return BoundResult(self._seen, max(top, self._seen), passed, "", self._time)
