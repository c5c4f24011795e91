"""FrameProof: bounds on a frame's speed and acceleration along a trajectory, by branch and bound.

On an interval of width h the velocity is within h^2 / 8 max |p'''| of the chord between its end
values, and no point of a chord is longer than both its ends; likewise the acceleration with
max |p''''|, and the origin with max |p''|. `derivative_bounds` computes the maxima. Intervals on
which the bound is undecided are halved. The rounding error of the samples (`origin_errors`) is
added.
"""

from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np

from planning.certify.frames.frame_chain import derivative_bounds, origin_errors
from planning.certify.frames.frame_states import FrameMotion, FrameStates
from planning.certify.joints.limit_checks import MAX_UTILISATION
from planning.certify.request import CertifyRequest
from planning.domain.arrays import Array
from planning.domain.report.certificate import Check
from planning.domain.request.deadline import Deadline
from planning.world.drake_model import DrakeModel

# Largest gap between a bound and the samples, relative to them, or relative to the limit.
_GAP, _LEAST = 1e-3, 0.01
_MOST_PLACES = 40_000
_NARROWEST = 2.0**-40


@dataclass(frozen=True)
class Spans:
    """Intervals within pieces, with samples of the frame's motion at both ends.

    Attributes:
        pieces: Index of the piece, shape (n,).
        low: Beginning of each interval, as a fraction of its piece.
        begin: Motion of the frame at the beginning.
        end: Motion of the frame at the end.
        strays: Largest deviations of position, velocity and acceleration from the chords between
            the samples, shape (3, n).
    """

    pieces: Any
    low: Array
    begin: FrameMotion
    end: FrameMotion
    strays: Array


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

    def look(self, spans: Spans) -> tuple[Array, Array]:
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
        self._bounds = derivative_bounds(model, request, frame)[:, 1:].T
        self._errors = origin_errors(model, request, frame).T
        self._breaks = request.trajectory.breaks
        self._widths = np.diff(self._breaks)
        self._quantities, self._frame = quantities, frame
        count = len(quantities)
        self._seen, self._dropped = np.zeros(count), np.zeros(count)
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
        most = max(_MOST_PLACES, 4 * len(pieces))
        ends = [self._states.at(pieces, at, deadline) for at in (0 * self._widths, self._widths)]
        spans, width, looked = self._spans(pieces, 0.0 * self._widths, 1.0, *ends), 1.0, 0
        while len(spans.pieces):
            is_last = looked > most or width < _NARROWEST
            spans = self._undecided(spans, width, is_last=is_last)
            looked += len(spans.pieces)
            width /= 2
            spans = self._halved(spans, width, deadline)

    def _undecided(self, spans: Spans, width: float, *, is_last: bool) -> Spans:
        """Update the results; return the intervals that must be halved."""
        keep = np.zeros(len(spans.pieces), dtype=bool)
        for i, quantity in enumerate(self._quantities):
            upper, seen = (_known(part) / quantity.limit for part in quantity.look(spans))
            end, worst = divmod(int(np.argmax(seen)), len(upper))
            if seen[end, worst] > self._seen[i]:
                self._seen[i] = seen[end, worst]
                self._times[i] = self._time(spans, worst, end * width)
            open_ = upper > self._enough(i)
            open_ &= not is_last
            self._dropped[i] = max(self._dropped[i], float(upper[~open_].max(initial=0.0)))
            keep |= open_
        return Spans(
            spans.pieces[keep],
            spans.low[keep],
            spans.begin[keep],
            spans.end[keep],
            spans.strays[:, keep],
        )

    def _enough(self, i: int) -> float:
        """Return the bound below which an interval is decided; infinite for a failed limit."""
        if self._seen[i] > MAX_UTILISATION:
            return np.inf
        return min(max(self._seen[i] * (1 + _GAP), _LEAST), MAX_UTILISATION)

    def _halved(self, spans: Spans, width: float, deadline: Deadline) -> Spans:
        if not len(spans.pieces):
            return spans
        low, pieces = spans.low, spans.pieces
        middle = self._states.at(pieces, (low + width) * self._widths[pieces], deadline)
        return self._spans(
            np.repeat(pieces, 2),
            np.stack([low, low + width], axis=1).ravel(),
            width,
            spans.begin.interleaved(middle),
            middle.interleaved(spans.end),
        )

    def _spans(
        self, pieces: Any, low: Array, width: float, begin: FrameMotion, end: FrameMotion
    ) -> Spans:
        steps = width * self._widths[pieces]
        strays = steps**2 / 8 * self._bounds[:, pieces] + self._errors[:, pieces]
        return Spans(pieces, low, begin, end, strays)

    def _time(self, spans: Spans, row: int, beyond: float) -> float:
        piece = int(spans.pieces[row])
        return float(self._breaks[piece] + (spans.low[row] + beyond) * self._widths[piece])

    def _check(self, i: int, quantity: FrameQuantity) -> Check:
        share = max(float(self._seen[i]), float(self._dropped[i]))
        if self._seen[i] > MAX_UTILISATION:
            share = float(self._seen[i])
        return Check(
            name=quantity.name,
            value=share * quantity.limit,
            bound=quantity.limit,
            unit=quantity.unit,
            resolution=0.0,
            passed=share <= MAX_UTILISATION,
            where=self._frame,
            time=float(self._times[i]),
        )


def _known(values: Array) -> Array:
    """Return the values with NaN, the result of overflow, replaced by infinity."""
    return np.where(np.isnan(values), np.inf, values)
