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
_MIN_HALF_RAMP = 5e-5
# Smallest significant jump, and largest rounding error of an acceleration, over their limits.
_MIN_RELATIVE_JUMP, _RELATIVE_ROUNDING = 1e-6, 2e-7
# The largest second derivative of the polynomial of degree 5 on [0, 1] that goes from 0 to 1.
_MAX_QUINTIC_SECOND_DERIVATIVE = 10 / np.sqrt(3)
# At an end of the motion, a shorter piece is part of its neighbour [s].
_MAX_MERGED_PIECE = 3e-8
# Pieces of fewer half ramps than this are skipped; of a longer one ramps take at most a share.
_MIN_SAMPLED_WIDTH, _MAX_RAMP_FRACTION = 4.0, 0.25


@dataclass(frozen=True)
class Knots:
    """Sampling instants with their pieces and ramps.

    Attributes:
        times: Instants [s], shape (n,).
        pieces: Index of the motion's piece that each instant belongs to, shape (n,).
        ramps: Indices of the instants at which a ramp to the next instant begins.
        adjusted: Indices of the instants whose acceleration is chosen instead of the motion's.
    """

    times: Array
    pieces: Indices
    ramps: Indices
    adjusted: Indices

    @classmethod
    def of(cls, curve: TimedTrajectory, periods: Array, limits: Array) -> "Knots":
        """Choose the sampling instants of a curve.

        Args:
            curve: The motion.
            periods: Longest time between samples on each piece [s], shape (n,).
            limits: On the acceleration of every coordinate, infinite for none, shape (nv,).
        """
        ramp, none = _half_ramp(curve, limits), np.zeros(0, dtype=np.intp)
        long_pieces = np.flatnonzero(curve.widths >= _MIN_SAMPLED_WIDTH * ramp)
        if len(long_pieces) == 0:
            ends = np.array([0, curve.num_pieces - 1])
            return cls(curve.breaks[[0, -1]], ends, none, none)
        spans = _SampledSpans.of(curve, limits, long_pieces, ramp)
        times, pieces, ramps = _evenly_spaced(spans, periods[long_pieces])
        adjusted, is_skipped = none, spans.has_skipped[spans.has_ramp]
        if is_skipped.any():
            times, pieces, ramps, adjusted = _with_middle_samples(
                curve, spans, (times, pieces, ramps)
            )
        return cls(times, pieces, ramps, adjusted)


@dataclass(frozen=True)
class _SampledSpans:
    """Sampled spans of the long pieces, and the ramps and skipped pieces around them.

    Attributes:
        pieces: Indices of the long pieces, shape (n,).
        begins: Beginning of sampling on each [s].
        ends: End of sampling on each [s].
        has_ramp: Whether there is a ramp: before the first, between all, after the last; (n + 1,).
        has_skipped: Whether pieces are skipped there.
        duration: Of the motion [s].
        num_pieces: Of the motion.
    """

    pieces: Indices
    begins: Array
    ends: Array
    has_ramp: np.ndarray[Any, np.dtype[np.bool_]]
    has_skipped: np.ndarray[Any, np.dtype[np.bool_]]
    duration: float
    num_pieces: int

    @classmethod
    def of(
        cls, curve: TimedTrajectory, limits: Array, long_pieces: Indices, ramp: float
    ) -> "_SampledSpans":
        breaks, widths = curve.breaks, curve.widths[long_pieces]
        has_skipped = np.diff(long_pieces, prepend=-1, append=curve.num_pieces) > 1
        has_ramp = has_skipped.copy()
        has_ramp[1:-1] |= _has_jump(curve, limits, long_pieces)
        # Duration of the skipped pieces, and how far beyond them a ramp reaches [s].
        begins, ends = breaks[long_pieces], breaks[long_pieces + 1]
        skipped_durations = np.concatenate([
            [begins[0]],
            begins[1:] - ends[:-1],
            [breaks[-1] - ends[-1]],
        ])
        wanted_reach = np.maximum(skipped_durations / 2, 2 * ramp - skipped_durations / 2)
        wanted_reach[[0, -1]] = np.maximum(skipped_durations[[0, -1]], ramp)
        max_reach = (
            np.minimum(np.append(np.inf, widths), np.append(widths, np.inf)) * _MAX_RAMP_FRACTION
        )
        reach = (
            np.where(has_skipped, np.clip(wanted_reach, ramp, np.maximum(max_reach, ramp)), ramp)
            * has_ramp
        )
        begins, ends = begins + reach[:-1], ends - reach[1:]
        if skipped_durations[0] <= _MAX_MERGED_PIECE:
            begins[0], has_ramp[0] = 0.0, False
        if skipped_durations[-1] <= _MAX_MERGED_PIECE:
            ends[-1], has_ramp[-1] = breaks[-1], False
        return cls(
            long_pieces, begins, ends, has_ramp, has_skipped, float(breaks[-1]), curve.num_pieces
        )


def _evenly_spaced(spans: _SampledSpans, periods: Array) -> tuple[Array, Indices, Indices]:
    """Return evenly spaced instants on each span and at both ends, their pieces, and the ramps."""
    begins, ends, has_ramp = spans.begins, spans.ends, spans.has_ramp
    counts = np.maximum(1, np.ceil((ends - begins) / periods - 1e-9)).astype(np.intp)
    has_end = np.append(has_ramp[1:-1], True)
    number = counts + has_end
    owner = np.repeat(np.arange(len(begins)), number)
    step = np.arange(len(owner)) - (np.cumsum(number) - number)[owner]
    times = begins[owner] + step * ((ends - begins) / counts)[owner]
    lasts = np.cumsum(number) - 1
    times[lasts[has_end]] = ends[has_end]
    pieces, ramps = spans.pieces[owner], lasts[:-1][has_ramp[1:-1]]
    if has_ramp[0]:
        times, pieces = np.insert(times, 0, 0.0), np.insert(pieces, 0, 0)
        ramps = np.insert(ramps + 1, 0, 0)
    if has_ramp[-1]:
        ramps = np.append(ramps, len(times) - 1)
        times = np.append(times, spans.duration)
        pieces = np.append(pieces, spans.num_pieces - 1)
    return times, pieces, ramps


def _with_middle_samples(
    curve: TimedTrajectory, spans: _SampledSpans, knots: tuple[Array, Indices, Indices]
) -> tuple[Array, Indices, Indices, Indices]:
    """Return the knots with a sample amid skipped pieces, and the indices of these samples.

    At the ends of the motion these are its first and its last sample.
    """
    times, pieces, ramps = knots
    is_skipped = spans.has_skipped[spans.has_ramp]
    inner = is_skipped.copy()
    inner[: int(spans.has_ramp[0])] = False
    inner[len(inner) - int(spans.has_ramp[-1]) :] = False
    at = ramps[inner]
    middles = (times[at] + times[at + 1]) / 2
    owners = np.searchsorted(curve.breaks, middles, side="right") - 1
    times, pieces = np.insert(times, at + 1, middles), np.insert(pieces, at + 1, owners)
    ramps = ramps + np.cumsum(inner) - inner
    adjusted = [*(ramps[inner] + 1)]
    if spans.has_ramp[0]:
        adjusted.insert(0, 0)
    if spans.has_ramp[-1]:
        adjusted.append(len(times) - 1)
    ramps = np.sort(np.concatenate([ramps, ramps[inner] + 1]))
    return times, pieces, ramps, np.array(adjusted, dtype=np.intp)


def _half_ramp(curve: TimedTrajectory, limits: Array) -> float:
    """Return half of a ramp's duration, large enough that rounded positions do not bend it [s]."""
    if not curve.manifold.is_flat:
        return 0.0
    ulp = np.spacing(np.abs(curve.bases).max(axis=0))
    min_duration = np.sqrt(_MAX_QUINTIC_SECOND_DERIVATIVE * ulp / (_RELATIVE_ROUNDING * limits))
    return max(_MIN_HALF_RAMP, float(min_duration.max()) / 2)


def _has_jump(curve: TimedTrajectory, limits: Array, long_pieces: Indices) -> Any:
    """Return where accelerations jump between two long pieces in a row."""
    if not curve.manifold.is_flat:
        return np.zeros(len(long_pieces) - 1, dtype=bool)
    second_derivative = derivative(curve.coefficients, 2)
    before = evaluate_polynomials(
        second_derivative[long_pieces[:-1]], curve.widths[long_pieces[:-1]]
    )
    return (
        np.abs(second_derivative[long_pieces[1:], 0] - before) > _MIN_RELATIVE_JUMP * limits
    ).any(axis=1)


def evaluate_polynomials(
    coefficients: Float64[np.ndarray, "m k nv"], x: Float64[np.ndarray, " m"]
) -> Array:
    """Return the value of one polynomial per row, lowest power first, shape (m, nv)."""
    total = coefficients[:, -1].copy()
    for k in range(coefficients.shape[1] - 2, -1, -1):
        total = total * x[:, None] + coefficients[:, k]
    return total
