"""BlockedDelays: the relative delays of two motions at which their robots may come too near."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64

from planning.domain.arrays import Array

# Blocked intervals nearer than this are one [s].
_TOLERANCE = 1e-12


@dataclass(frozen=True)
class Encounter:
    """A place in the coordination diagram of two motions at which their robots may be too near.

    Attributes:
        first: Configuration of the first motion's group.
        second: Configuration of the second's.
        times: Instant of each motion, by its own time [s].
    """

    first: Array
    second: Array
    times: tuple[float, float]


class BlockedDelays:
    """Union of closed intervals of relative delays, each with an encounter that blocks it."""

    def __init__(self) -> None:
        """Begin with no interval."""
        self._intervals: list[tuple[float, float, Encounter]] = []
        self._low: Array = np.zeros(0)
        self._high: Array = np.zeros(0)

    def add(self, low: float, high: float, encounter: Encounter) -> None:
        """Add an interval; its ends may be infinite. `merge` makes it count."""
        self._intervals.append((low, high, encounter))

    def merge(self) -> None:
        """Compute the union of all intervals that were added."""
        ends = sorted((low, high) for low, high, _ in self._intervals)
        merged: list[list[float]] = []
        for low, high in ends:
            if merged and low <= merged[-1][1] + _TOLERANCE:
                merged[-1][1] = max(merged[-1][1], high)
            else:
                merged.append([low, high])
        self._low, self._high = np.array(merged, dtype=np.float64).reshape(-1, 2).T

    def are_covered(
        self, low: Float64[np.ndarray, " n"], high: Float64[np.ndarray, " n"]
    ) -> Bool[np.ndarray, " n"]:
        """Return which intervals the union contains."""
        if not len(self._low):
            return np.zeros(len(low), dtype=bool)
        at = np.searchsorted(self._low, low + _TOLERANCE, side="right") - 1
        return (at >= 0) & (self._high[np.maximum(at, 0)] >= high - _TOLERANCE)

    @property
    def free(self) -> list[tuple[float, float]]:
        """The closed intervals between the blocked ones, in order; their ends may be infinite."""
        ends = [-np.inf, *np.stack([self._low, self._high], axis=1).ravel().tolist(), np.inf]
        pairs = zip(ends[::2], ends[1::2], strict=True)
        return [(low, high) for low, high in pairs if low < np.inf and high > -np.inf]

    @property
    def has_any(self) -> bool:
        """Whether any delay is blocked."""
        return bool(self._intervals)

    def encounter_at(self, delay: float) -> Encounter:
        """Return an encounter that blocks the delays next to a free one, where it is nearest."""
        return min(
            self._intervals,
            key=lambda entry: (_gap(entry[0], entry[1], delay), entry[0] - entry[1]),
        )[2]

    def encounter_after_any(self, *, second_waits: bool) -> Encounter | None:
        """Return an encounter that however long a delay does not avoid; None if there is none."""
        end = np.inf if second_waits else -np.inf
        return next((met for low, high, met in self._intervals if end in {low, high}), None)


def _gap(low: float, high: float, delay: float) -> float:
    """Return how far a delay is from the nearer end of an interval; 0 within it."""
    return 0.0 if low < delay < high else min(abs(low - delay), abs(high - delay))
