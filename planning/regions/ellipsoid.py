"""GrowthEllipsoid: the metric of IRIS-ZO, inscribed in the region that grows."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64
from pydrake.geometry.optimization import HPolyhedron  # pyright: ignore[reportMissingModuleSource]

from planning.domain.arrays import Array


@dataclass(frozen=True)
class GrowthEllipsoid:
    """Ellipsoid: the set of all points center + shape u with |u| <= 1.

    Attributes:
        center: Centre [rad or m], shape (n,).
        shape: Linear map of the unit ball [rad or m], shape (n, n).
    """

    center: Array
    shape: Array

    @classmethod
    def ball(cls, center: Float64[np.ndarray, " n"], radius: float = 0.01) -> "GrowthEllipsoid":
        """Return the ball of a centre and a radius [rad or m]."""
        return cls(center, radius * np.eye(len(center)))

    @classmethod
    def inscribed(
        cls, normals: Float64[np.ndarray, "m n"], offsets: Float64[np.ndarray, " m"]
    ) -> "GrowthEllipsoid":
        """Return the inscribed ellipsoid of maximum volume (John's) of a bounded polytope."""
        ellipsoid = HPolyhedron(normals, offsets).MaximumVolumeInscribedEllipsoid()
        return cls(np.array(ellipsoid.center()), np.linalg.inv(ellipsoid.A()))

    @property
    def log_volume(self) -> float:
        """Logarithm of the volume, up to an additive constant."""
        return float(np.linalg.slogdet(self.shape)[1])

    def distances(self, qs: Float64[np.ndarray, "k n"]) -> Float64[np.ndarray, " k"]:
        """Return the scale factor at which the ellipsoid's surface reaches each row."""
        return np.asarray(np.linalg.norm(np.linalg.solve(self.shape, (qs - self.center).T), axis=0))

    def normals(self, qs: Sequence[Any] | Array) -> Array:
        """Return the unit normals of the scaled ellipsoids that pass through each row."""
        inner = np.linalg.solve(self.shape, (np.asarray(qs) - self.center).T)
        outward = np.linalg.solve(self.shape.T, inner).T
        return outward / np.linalg.norm(outward, axis=1, keepdims=True)
