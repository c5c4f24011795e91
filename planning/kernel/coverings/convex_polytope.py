"""ConvexPolytope: polytopes by their corners (V-representation), cut by planes.

Exactly three faces meet at every corner: where more do, as at the tip of a pyramid, the corner is
there several times. So two corners that share two faces are the ends of an edge. A plane cuts the
edges whose ends lie on both sides of it, and the remaining part has the corners on its side and the
new ones. The side of a corner is decided once for all of its edges.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np
from jaxtyping import Float64, Int64

_MAX_NUM_FACES = 1 << 20


@dataclass(frozen=True)
class ConvexPolytope:
    """Convex polytope, possibly empty.

    Attributes:
        corners: A ball that contains them contains the polytope [m], shape (n, 3).
        faces: Indices of the faces that meet at each corner, below 2^20, in ascending order, shape
            (n, 3).
    """

    corners: Float64[np.ndarray, "n 3"]
    faces: Int64[np.ndarray, "n 3"]

    @classmethod
    def box(
        cls, low: Float64[np.ndarray, " 3"], high: Float64[np.ndarray, " 3"]
    ) -> "ConvexPolytope":
        """Return the box between two corners; its faces are numbers 0 to 5."""
        sides = np.array(list(product((0, 1), repeat=3)), dtype=np.int64)
        return cls(np.where(sides, high, low), 2 * np.arange(3) + sides)

    @cached_property
    def edges(self) -> Int64[np.ndarray, "e 2"]:
        """Corners at the ends of every edge."""
        a, b, c = self.faces.T
        keys = np.concatenate([
            a * _MAX_NUM_FACES + b,
            a * _MAX_NUM_FACES + c,
            b * _MAX_NUM_FACES + c,
        ])
        return (np.argsort(keys, kind="stable") % max(len(a), 1)).reshape(-1, 2)

    def clipped(
        self, normal: Float64[np.ndarray, " 3"], offset: float, face: int
    ) -> "ConvexPolytope":
        """Return the part where normal . x <= offset.

        Args:
            normal: Normal of the cutting plane.
            offset: Of the cutting plane along the normal.
            face: Number of the face that the cut adds, larger than all others.
        """
        heights = self.corners @ normal - offset
        is_below = heights <= 0
        if is_below.all():
            return self
        ends = self.edges[is_below[self.edges[:, 0]] != is_below[self.edges[:, 1]]]
        begin, end = ends.T
        fractions = heights[begin] / (heights[begin] - heights[end])
        new_corners = self.corners[begin] + fractions[:, None] * (
            self.corners[end] - self.corners[begin]
        )
        is_shared = (self.faces[begin][:, :, None] == self.faces[end][:, None, :]).any(axis=2)
        shared = self.faces[begin][is_shared].reshape(-1, 2)
        faces = np.column_stack([shared, np.full(len(ends), face)])
        return ConvexPolytope(
            np.concatenate([self.corners[is_below], new_corners]),
            np.concatenate([self.faces[is_below], faces]),
        )
