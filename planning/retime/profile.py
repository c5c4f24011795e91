"""SpeedProfile: how fast a path is followed, s(t) as polynomials of degree at most three."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.value import Value

type Array = np.ndarray[Any, np.dtype[np.float64]]


@dataclass(frozen=True, eq=False)
class SpeedProfile(Value):
    """Phase i: s(t) = s[i] + v[i] t + a[i] t^2 / 2 + j[i] t^3 / 6 for 0 <= t <= h[i].

    Attributes:
        s: Path parameter at the start of each phase and at the end of the last, shape (n + 1,).
        v: ds/dt at the start of each phase [1/s], shape (n,).
        a: Its derivative [1/s^2], shape (n,).
        j: And the next [1/s^3], shape (n,).
        h: Durations [s], positive, shape (n,).
    """

    s: Float64[np.ndarray, " n_plus_1"]
    v: Float64[np.ndarray, " n"]
    a: Float64[np.ndarray, " n"]
    j: Float64[np.ndarray, " n"]
    h: Float64[np.ndarray, " n"]

    @property
    def duration(self) -> float:
        """The whole time [s]."""
        return float(self.h.sum())

    def split_at(self, breaks: Float64[np.ndarray, " m"]) -> "SpeedProfile":
        """Return the same profile with a phase boundary at each of some parameters."""
        rows: list[tuple[float, float, float, float, float]] = []
        for i in range(len(self.h)):
            inside = breaks[(breaks > self.s[i]) & (breaks < self.s[i + 1])]
            times = [0.0, *(_time_at(self, i, float(x)) for x in inside), float(self.h[i])]
            places = [float(self.s[i]), *map(float, inside)]
            for t0, t1, place in zip(times[:-1], times[1:], places, strict=True):
                if t1 > t0:
                    v = self.v[i] + self.a[i] * t0 + self.j[i] * t0**2 / 2
                    a = self.a[i] + self.j[i] * t0
                    rows.append((place, float(v), float(a), float(self.j[i]), t1 - t0))
        s, v, a, j, h = np.array(rows).T
        return SpeedProfile(np.append(s, self.s[-1]), v, a, j, h)


def _time_at(profile: SpeedProfile, i: int, s: float) -> float:
    """Return when phase i reaches s, by bisection: s(t) increases."""
    v, a, j = profile.v[i], profile.a[i], profile.j[i]
    low, high = 0.0, float(profile.h[i])
    for _ in range(80):
        t = (low + high) / 2
        if profile.s[i] + t * (v + t * (a / 2 + t * j / 6)) < s:
            low = t
        else:
            high = t
    return (low + high) / 2
