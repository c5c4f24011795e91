"""Analytic worlds in the plane whose free sets are known."""

from collections.abc import Callable

import numpy as np
import pytest


class Plane:
    """Points of a square from -1 to 1, free where a function of a batch says so."""

    lower, upper = np.array([-1.0, -1.0]), np.array([1.0, 1.0])

    def __init__(self, are_free: Callable[[np.ndarray], np.ndarray]) -> None:
        self.are_free = are_free

    def are_motions_free(self, origins, displacements, resolution):
        count = int(np.ceil(np.abs(displacements).max(initial=0.1) / resolution))
        fractions = np.linspace(0, 1, count + 1)[:, None, None]
        samples = origins + fractions * displacements
        return self.are_free(samples.reshape(-1, 2)).reshape(count + 1, -1).all(axis=0)

    def grid(self, count=200):
        axis = np.linspace(-1, 1, count)
        return np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)


def in_triangle(qs):
    """The corner below the line x + 2 y = 0.4."""
    return qs[:, 0] + 2 * qs[:, 1] < 0.4


def off_disc(qs):
    return np.hypot(qs[:, 0], qs[:, 1]) > 0.4


def off_wall(qs):
    """A wall across x = 0 with a gap above y = 0.6."""
    return ~((np.abs(qs[:, 0]) < 0.1) & (qs[:, 1] < 0.6))


@pytest.fixture(params=[in_triangle, off_disc, off_wall], ids=lambda f: f.__name__)
def plane(request):
    return Plane(request.param)
