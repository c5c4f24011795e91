"""SpeedProfile: the path parameter over time, s(t), as polynomials of degree at most three."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.value import Value

# Steps of Newton's method, or bisections: as many as halve an interval to its rounding.
_MAX_STEPS = 60
# Relative change of a time that ends the search for it.
_ROUNDING = 4e-16
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
        """Return the time at which each phase reaches a parameter: s(t) increases.

        By Newton's method, and by bisection where that leaves the interval of the solution.
        """
        s, v, a, j = self.s[phases], self.v[phases], self.a[phases], self.j[phases]
        low, high = np.zeros(len(phases)), self.h[phases]
        t = high * (parameters - s) / (self.s[phases + 1] - s)
        for _ in range(_MAX_STEPS):
            excess = s + t * (v + t * (a / 2 + t * j / 6)) - parameters
            low, high = np.where(excess < 0, t, low), np.where(excess < 0, high, t)
            with np.errstate(divide="ignore", invalid="ignore"):
                newton = t - excess / (v + t * (a + t * j / 2))
            following = np.where((newton >= low) & (newton <= high), newton, (low + high) / 2)
            if (np.abs(following - t) <= _ROUNDING * following).all():
                return following
            t = following
        return t
