"""TimingSpline: the profile with given durations of phases between given parameters of a path.

It is the cubic spline s(t) through the parameters at those times, at rest and without acceleration
at both ends. Speeds, accelerations and jerks follow from a linear system (de Boor, "A practical
guide to splines", chapter IV), and their derivatives by the durations from the same system.
"""

from dataclasses import dataclass

import numpy as np

from planning.domain.arrays import Array
from planning.retime.profile import SpeedProfile


@dataclass(frozen=True)
class TimingSpline:
    """A cubic spline s(t) of n phases.

    Attributes:
        h: Durations [s], shape (n,).
        s: Path parameters between phases, shape (n + 1,); the second and the last but one are
            determined by the rests at the ends.
        v: ds/dt there [1/s], shape (n + 1,).
        a: d2s/dt2 there [1/s^2], shape (n + 1,).
        j: d3s/dt3 on the phases [1/s^3], shape (n,).
        matrix: Matrix of the linear system, for a at inner parameters and the two determined s.
    """

    h: Array
    s: Array
    v: Array
    a: Array
    j: Array
    matrix: Array

    @classmethod
    def through(cls, h: Array, parameters: Array) -> "TimingSpline":
        """Build from durations [s] of at least four phases, and path parameters."""
        n = len(h)
        matrix, right_side = np.zeros((n + 1, n + 1)), np.zeros(n + 1)
        i = np.arange(n - 1)
        matrix[i, i] = (h[:-1] + h[1:]) / 3
        matrix[i[1:], i[:-1]] = matrix[i[:-1], i[1:]] = h[1:-1] / 6
        known = np.array(parameters)
        known[[1, -2]] = 0.0
        right_side[:-2] = np.diff(np.diff(known) / h)
        for column, node in ((n - 1, 1), (n, n - 1)):
            unit = np.zeros(n + 1)
            unit[node] = 1.0
            matrix[:-2, column] = -np.diff(np.diff(unit) / h)
        # Zero speed at both ends.
        matrix[-2, [0, -2]], right_side[-2] = (-h[0] / 6, 1 / h[0]), parameters[0] / h[0]
        matrix[-1, [-3, -1]], right_side[-1] = (h[-1] / 6, -1 / h[-1]), -parameters[-1] / h[-1]
        solution = np.linalg.solve(matrix, right_side)
        s, a = np.array(parameters), np.concatenate([[0.0], solution[:-2], [0.0]])
        s[[1, -2]] = solution[-2:]
        v = np.append(np.diff(s) / h - h * (2 * a[:-1] + a[1:]) / 6, 0.0)
        v[0] = 0.0
        return cls(h, s, v, a, np.diff(a) / h, matrix)

    @property
    def is_increasing(self) -> bool:
        """Whether s increases over every phase, and ds/dt is positive at all inner parameters."""
        return bool((self.v[1:-1] > 0).all() and (np.diff(self.s) > 0).all())

    @property
    def profile(self) -> SpeedProfile:
        """The spline as a speed profile."""
        return SpeedProfile(self.s, self.v[:-1], self.a[:-1], self.j, self.h)

    def derivatives(self) -> Array:
        """Return the derivatives of v, a, j at both ends of phases by log h, shape (2, n, 3, n)."""
        h, a, steps, n = self.h, self.a, np.diff(self.s), len(self.h)
        i, k = np.arange(n - 1), np.arange(n)
        by = np.zeros((n + 1, n))
        by[i, i + 1] = a[1:-1] / 3 + a[2:] / 6 + steps[1:] / h[1:] ** 2
        by[i, i] = a[:-2] / 6 + a[1:-1] / 3 - steps[:-1] / h[:-1] ** 2
        by[-2, 0] = -steps[0] / h[0] ** 2 - a[1] / 6
        by[-1, -1] = -steps[-1] / h[-1] ** 2 + a[-2] / 6
        solution = -np.linalg.solve(self.matrix, by)
        da, ds, dv = (np.zeros((n + 1, n)) for _ in range(3))
        da[1:-1], ds[[1, -2]] = solution[:-2], solution[-2:]
        column_durations = h[:, None]
        dv[:-1] = (
            np.diff(ds, axis=0) / column_durations - column_durations * (2 * da[:-1] + da[1:]) / 6
        )
        dv[k, k] -= steps / h**2 + (2 * a[:-1] + a[1:]) / 6
        dv[0] = 0.0
        dj = np.diff(da, axis=0) / column_durations
        dj[k, k] -= self.j / h
        ends = [np.stack([dv[e : n + e], da[e : n + e], dj], axis=1) for e in range(2)]
        return np.stack(ends) * h
