"""Convex pieces: a polytope cut into small ones, each known by its corners and their faces.

Two corners that share two faces may be the ends of an edge. A plane cuts those of the edges whose
ends lie on both sides of it, and the corners of each part are the old ones on its side and the new
ones: a ball that contains them contains the part. Pairs that share two faces and are no edge give
points inside the new face, of which only the outermost are kept.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Bool, Float64

type Array = np.ndarray[Any, np.dtype[np.float64]]

# How far a corner may lie from the plane of a face that it belongs to, over the polytope's size.
_ON = 1e-6
# Three points that span less lie on a line [m^2].
_FLAT = 1e-14


@dataclass(frozen=True)
class Piece:
    """A convex polytope.

    Attributes:
        corners: All of them, maybe with points between, shape (n, 3).
        faces: Which faces each lies on, shape (n, f).
    """

    corners: Float64[np.ndarray, "n 3"]
    faces: Bool[np.ndarray, "n f"]

    @classmethod
    def of(
        cls, vertices: Float64[np.ndarray, "n 3"], planes: Float64[np.ndarray, "f 4"]
    ) -> "Piece":
        """Return the polytope of these corners, with faces n . x <= d as rows (n, d)."""
        near = _ON * float(np.ptp(vertices, axis=0).max())
        return cls(vertices, np.abs(vertices @ planes[:, :3].T - planes[:, 3]) <= near)

    @property
    def low(self) -> Array:
        """The least coordinates."""
        return self.corners.min(axis=0)

    @property
    def high(self) -> Array:
        """The greatest coordinates."""
        return self.corners.max(axis=0)

    def cut(self, axis: int, offset: float) -> tuple["Piece", "Piece"]:
        """Return the parts on both sides of the plane where a coordinate is `offset`."""
        heights = self.corners[:, axis] - offset
        below, above = np.flatnonzero(heights < 0), np.flatnonzero(heights > 0)
        shared = self.faces[below].astype(np.float32) @ self.faces[above].T.astype(np.float32)
        i, j = np.nonzero(shared >= 2)
        i, j = below[i], above[j]
        share = (heights[i] / (heights[i] - heights[j]))[:, None]
        fresh = self.corners[i] + share * (self.corners[j] - self.corners[i])
        fresh[:, axis] = offset
        rim = _outermost(np.delete(fresh, axis, axis=1))
        fresh, faces = fresh[rim], (self.faces[i] & self.faces[j])[rim]
        return self._part(heights <= 0, heights == 0, fresh, faces), self._part(
            heights >= 0, heights == 0, fresh, faces
        )

    def _part(self, kept: Any, on: Any, fresh: Array, faces: Any) -> "Piece":
        corners = np.concatenate([self.corners[kept], fresh])
        belongs = np.concatenate([self.faces[kept], faces])
        lid = np.append(on[kept], np.ones(len(fresh), dtype=bool))
        belongs = np.column_stack([belongs[:, belongs.sum(axis=0) >= 2], lid])
        return Piece(corners, belongs)


def _outermost(points: Float64[np.ndarray, "n 2"]) -> list[int]:
    """Return the corners of a planar convex hull, by Andrew's monotone chain."""
    order = np.lexsort((points[:, 1], points[:, 0])).tolist()
    if len(order) < 4:
        return order
    rows = points.tolist()
    chains: list[int] = []
    for run in (order, order[::-1]):
        chain: list[int] = []
        for k in run:
            while len(chain) > 1 and _turns_back(rows[chain[-2]], rows[chain[-1]], rows[k]):
                chain.pop()
            chain.append(k)
        chains += chain[:-1]
    return sorted(set(chains))


def _turns_back(a: list[float], b: list[float], c: list[float]) -> bool:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) <= _FLAT
