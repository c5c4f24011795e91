"""SpeedProfile: the path parameter over time, s(t), as polynomials of degree at most three."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.value import Value

_BISECTIONS = 60
# Shortest phase relative to the whole duration.
_BRIEF = 1e-12


@dataclass(frozen=True, eq=False)
class SpeedProfile(Value):
    """Speed profile: s(t) = s[i] + v[i] t + a[i] t^2 / 2 + j[i] t^3 / 6 on [0, h[i]] in phase i.

    Attributes:
        s: Path parameter at the start of each phase and at the end of the last, shape (n + 1,).
        v: ds/dt at the start of each phase [1/s], shape (n,).
        a: d2s/dt2 at the start of each phase [1/s^2], shape (n,).
        j: d3s/dt3 on each phase [1/s^3], shape (n,).
        h: Durations [s], positive, shape (n,).
    """

    s: Float64[np.ndarray, " n_plus_1"]
    v: Float64[np.ndarray, " n"]
    a: Float64[np.ndarray, " n"]
    j: Float64[np.ndarray, " n"]
    h: Float64[np.ndarray, " n"]

    @classmethod
    def joined(cls, parts: Sequence["SpeedProfile"]) -> "SpeedProfile":
        """Build the profile that runs through the parts one after another."""
        return cls(
            np.concatenate([*(part.s[:-1] for part in parts), parts[-1].s[-1:]]),
            np.concatenate([part.v for part in parts]),
            np.concatenate([part.a for part in parts]),
            np.concatenate([part.j for part in parts]),
            np.concatenate([part.h for part in parts]),
        )

    @property
    def duration(self) -> float:
        """Duration of the whole profile [s]."""
        return float(self.h.sum())

    def split_at(self, places: Float64[np.ndarray, " m"]) -> "SpeedProfile":
        """Return the same profile with additional phase boundaries at increasing path parameters.

        Parameters reached within a moment of another boundary get none of their own.
        """
        phases = np.searchsorted(self.s, places, side="right") - 1
        inside = (places > self.s[0]) & (places < self.s[-1])
        inside &= places != self.s[np.clip(phases, 0, len(self.h) - 1)]
        places, phases = places[inside], phases[inside]
        if not len(places):
            return self
        times = self._times(phases, places)
        brief = _BRIEF * self.duration
        inside = (times > brief) & (times < self.h[phases] - brief)
        inside[1:] &= (np.diff(times) > brief) | (np.diff(phases) > 0)
        places, phases, times = places[inside], phases[inside], times[inside]
        # Boundaries in order: the beginning of each phase, then the parameters inside it.
        owner = np.concatenate([np.arange(len(self.h)), phases])
        begin = np.concatenate([np.zeros(len(self.h)), times])
        s = np.concatenate([self.s[:-1], places])
        order = np.lexsort((begin, owner))
        owner, begin, s = owner[order], begin[order], s[order]
        is_last = np.append(owner[1:] != owner[:-1], True)
        end = np.where(is_last, self.h[owner], np.append(begin[1:], 0.0))
        v = self.v[owner] + begin * (self.a[owner] + self.j[owner] * begin / 2)
        a = self.a[owner] + self.j[owner] * begin
        return SpeedProfile(np.append(s, self.s[-1]), v, a, self.j[owner], end - begin)

    def _times(self, phases: Any, places: Array) -> Array:
        """Return the time at which each phase reaches a parameter, by bisection: s(t) increases."""
        s, v, a, j = self.s[phases], self.v[phases], self.a[phases], self.j[phases]
        low, high = np.zeros(len(phases)), self.h[phases]
        for _ in range(_BISECTIONS):
            t = (low + high) / 2
            is_before = s + t * (v + t * (a / 2 + t * j / 6)) < places
            low, high = np.where(is_before, t, low), np.where(is_before, high, t)
        return (low + high) / 2
