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
_MIN_PHASE_SHARE = 1e-12


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

    def split_at(self, parameters: Float64[np.ndarray, " m"]) -> "SpeedProfile":
        """Return the same profile with additional phase boundaries at increasing path parameters.

        Parameters reached within a moment of another boundary get none of their own.
        """
        phases = np.searchsorted(self.s, parameters, side="right") - 1
        inside = (parameters > self.s[0]) & (parameters < self.s[-1])
        inside &= parameters != self.s[np.clip(phases, 0, len(self.h) - 1)]
        parameters, phases = parameters[inside], phases[inside]
        if not len(parameters):
            return self
        times = self._times(phases, parameters)
        min_phase = _MIN_PHASE_SHARE * self.duration
        inside = (times > min_phase) & (times < self.h[phases] - min_phase)
        inside[1:] &= (np.diff(times) > min_phase) | (np.diff(phases) > 0)
        parameters, phases, times = parameters[inside], phases[inside], times[inside]
        # Boundaries in order: the beginning of each phase, then the parameters inside it.
        phase_indices = np.concatenate([np.arange(len(self.h)), phases])
        begin_times = np.concatenate([np.zeros(len(self.h)), times])
        s = np.concatenate([self.s[:-1], parameters])
        order = np.lexsort((begin_times, phase_indices))
        phase_indices, begin_times, s = phase_indices[order], begin_times[order], s[order]
        is_last = np.append(phase_indices[1:] != phase_indices[:-1], True)
        end = np.where(is_last, self.h[phase_indices], np.append(begin_times[1:], 0.0))
        v = self.v[phase_indices] + begin_times * (
            self.a[phase_indices] + self.j[phase_indices] * begin_times / 2
        )
        a = self.a[phase_indices] + self.j[phase_indices] * begin_times
        return SpeedProfile(
            np.append(s, self.s[-1]), v, a, self.j[phase_indices], end - begin_times
        )

    def _times(self, phases: Any, parameters: Array) -> Array:
        """Return the time at which each phase reaches a parameter, by bisection: s(t) increases."""
        s, v, a, j = self.s[phases], self.v[phases], self.a[phases], self.j[phases]
        low, high = np.zeros(len(phases)), self.h[phases]
        for _ in range(_BISECTIONS):
            t = (low + high) / 2
            is_before = s + t * (v + t * (a / 2 + t * j / 6)) < parameters
            low, high = np.where(is_before, t, low), np.where(is_before, high, t)
        return (low + high) / 2
