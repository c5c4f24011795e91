"""Knots: sampling instants of a motion, and the ramps that replace jumps of its acceleration.

Between two pieces with different accelerations lies a ramp (acceleration linear in time), from a
little before the jump to a little after it. Pieces too short for samples of their own are skipped
together, with a sample in the middle of them whose acceleration is chosen (`sampling`). If the ramp
reaches beyond them by half of their duration or more, that acceleration is a mean of those before,
within and after them, and hence within their limits; at an end of the motion that is so if it
reaches as far as their duration.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array, Indices
from planning.domain.curves.curve import TimedTrajectory, derivative

# Smallest half duration of the ramp that replaces a jump of acceleration [s].
_RAMP = 5e-5
# Smallest significant jump, and largest rounding error of an acceleration, over their limits.
_JUMP, _ROUNDED = 1e-6, 2e-7
# The largest second derivative of the polynomial of degree 5 on [0, 1] that goes from 0 to 1.
_STEEPEST = 10 / np.sqrt(3)
# At an end of the motion, a shorter piece is part of its neighbour [s].
_DUST = 3e-8
# Pieces of fewer half ramps than this are skipped; of a longer one ramps take at most a share.
_NARROW, _SHARE = 4.0, 0.25


@dataclass(frozen=True)
class Knots:
    """Sampling instants with their pieces and ramps.

    Attributes:
        times: Instants [s], shape (n,).
        pieces: Index of the motion's piece that each instant belongs to, shape (n,).
        ramps: Indices of the instants at which a ramp to the next instant begins.
        bent: Indices of the instants whose acceleration is chosen instead of the motion's.
    """

    times: Array
    pieces: Indices
    ramps: Indices
    bent: Indices

    @classmethod
    def of(cls, curve: TimedTrajectory, periods: Array, limits: Array) -> "Knots":
        """Choose the sampling instants of a curve.

        Args:
            curve: The motion.
            periods: Longest time between samples on each piece [s], shape (n,).
            limits: On the acceleration of every coordinate, infinite for none, shape (nv,).
        """
        ramp, none = _ramp(curve, limits), np.zeros(0, dtype=np.intp)
        long = np.flatnonzero(curve.widths >= _NARROW * ramp)
        if len(long) == 0:
            ends = np.array([0, curve.num_pieces - 1])
            return cls(curve.breaks[[0, -1]], ends, none, none)
        spans = _Spans.of(curve, limits, long, ramp)
        times, pieces, ramps = _even(spans, periods[long])
        bent, gone_over = none, spans.skips[spans.jumps]
        if gone_over.any():
            times, pieces, ramps, bent = _with_middles(curve, spans, (times, pieces, ramps))
        return cls(times, pieces, ramps, bent)


@dataclass(frozen=True)
class _Spans:
    """Sampled spans of the long pieces, and the ramps and skipped pieces around them.

    Attributes:
        long: Indices of the long pieces, shape (n,).
        begins: Beginning of sampling on each [s].
        ends: End of sampling on each [s].
        jumps: Whether there is a ramp: before the first, between all, after the last; (n + 1,).
        skips: Whether pieces are skipped there.
        duration: Of the motion [s].
        num_pieces: Of the motion.
    """

    long: Indices
    begins: Array
    ends: Array
    jumps: np.ndarray[Any, np.dtype[np.bool_]]
    skips: np.ndarray[Any, np.dtype[np.bool_]]
    duration: float
    num_pieces: int

    @classmethod
    def of(cls, curve: TimedTrajectory, limits: Array, long: Indices, ramp: float) -> "_Spans":
        breaks, widths = curve.breaks, curve.widths[long]
        skips = np.diff(long, prepend=-1, append=curve.num_pieces) > 1
        jumps = skips.copy()
        jumps[1:-1] |= _jumps(curve, limits, long)
        # Duration of the skipped pieces, and how far beyond them a ramp reaches [s].
        begins, ends = breaks[long], breaks[long + 1]
        over = np.concatenate([[begins[0]], begins[1:] - ends[:-1], [breaks[-1] - ends[-1]]])
        wanted = np.maximum(over / 2, 2 * ramp - over / 2)
        wanted[[0, -1]] = np.maximum(over[[0, -1]], ramp)
        room = np.minimum(np.append(np.inf, widths), np.append(widths, np.inf)) * _SHARE
        reach = np.where(skips, np.clip(wanted, ramp, np.maximum(room, ramp)), ramp) * jumps
        begins, ends = begins + reach[:-1], ends - reach[1:]
        if over[0] <= _DUST:
            begins[0], jumps[0] = 0.0, False
        if over[-1] <= _DUST:
            ends[-1], jumps[-1] = breaks[-1], False
        return cls(long, begins, ends, jumps, skips, float(breaks[-1]), curve.num_pieces)


def _even(spans: _Spans, periods: Array) -> tuple[Array, Indices, Indices]:
    """Return evenly spaced instants on each span and at both ends, their pieces, and the ramps."""
    begins, ends, jumps = spans.begins, spans.ends, spans.jumps
    counts = np.maximum(1, np.ceil((ends - begins) / periods - 1e-9)).astype(np.intp)
    has_end = np.append(jumps[1:-1], True)
    number = counts + has_end
    owner = np.repeat(np.arange(len(begins)), number)
    step = np.arange(len(owner)) - (np.cumsum(number) - number)[owner]
    times = begins[owner] + step * ((ends - begins) / counts)[owner]
    lasts = np.cumsum(number) - 1
    times[lasts[has_end]] = ends[has_end]
    pieces, ramps = spans.long[owner], lasts[:-1][jumps[1:-1]]
    if jumps[0]:
        times, pieces = np.insert(times, 0, 0.0), np.insert(pieces, 0, 0)
        ramps = np.insert(ramps + 1, 0, 0)
    if jumps[-1]:
        ramps = np.append(ramps, len(times) - 1)
        times = np.append(times, spans.duration)
        pieces = np.append(pieces, spans.num_pieces - 1)
    return times, pieces, ramps


def _with_middles(
    curve: TimedTrajectory, spans: _Spans, knots: tuple[Array, Indices, Indices]
) -> tuple[Array, Indices, Indices, Indices]:
    """Return the knots with a sample amid skipped pieces, and the indices of these samples.

    At the ends of the motion these are its first and its last sample.
    """
    times, pieces, ramps = knots
    gone_over = spans.skips[spans.jumps]
    inner = gone_over.copy()
    inner[: int(spans.jumps[0])] = False
    inner[len(inner) - int(spans.jumps[-1]) :] = False
    at = ramps[inner]
    middles = (times[at] + times[at + 1]) / 2
    owners = np.searchsorted(curve.breaks, middles, side="right") - 1
    times, pieces = np.insert(times, at + 1, middles), np.insert(pieces, at + 1, owners)
    ramps = ramps + np.cumsum(inner) - inner
    bent = [*(ramps[inner] + 1)]
    if spans.jumps[0]:
        bent.insert(0, 0)
    if spans.jumps[-1]:
        bent.append(len(times) - 1)
    ramps = np.sort(np.concatenate([ramps, ramps[inner] + 1]))
    return times, pieces, ramps, np.array(bent, dtype=np.intp)


def _ramp(curve: TimedTrajectory, limits: Array) -> float:
    """Return half of a ramp's duration, large enough that rounded positions do not bend it [s]."""
    if not curve.manifold.is_flat:
        return 0.0
    ulp = np.spacing(np.abs(curve.bases).max(axis=0))
    least = np.sqrt(_STEEPEST * ulp / (_ROUNDED * limits))
    return max(_RAMP, float(least.max()) / 2)


def _jumps(curve: TimedTrajectory, limits: Array, long: Indices) -> Any:
    """Return where accelerations jump between two long pieces in a row."""
    if not curve.manifold.is_flat:
        return np.zeros(len(long) - 1, dtype=bool)
    bend = derivative(curve.coefficients, 2)
    before = evaluated(bend[long[:-1]], curve.widths[long[:-1]])
    return (np.abs(bend[long[1:], 0] - before) > _JUMP * limits).any(axis=1)


def evaluated(coefficients: Float64[np.ndarray, "m k nv"], x: Float64[np.ndarray, " m"]) -> Array:
    """Return the value of one polynomial per row, lowest power first, shape (m, nv)."""
    total = coefficients[:, -1].copy()
    for k in range(coefficients.shape[1] - 2, -1, -1):
        total = total * x[:, None] + coefficients[:, k]
    return total
