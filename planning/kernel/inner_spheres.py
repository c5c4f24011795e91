"""Inner spheres: few balls inside a convex shape that fill most of it."""

from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.kernel.solid import Solid

type Array = np.ndarray[Any, np.dtype[np.float64]]

_MOST = 14
# A ball that fills less of the shape's grid, or is smaller, is not worth a test [m].
_LEAST_GAIN = 0.01
_LEAST_RADIUS = 0.001
_DUST = 1e-9


def inner_spheres(solid: Solid) -> Float64[np.ndarray, "n 4"]:
    """Return balls as rows (x, y, z, r), the one that fills most first; each lies inside."""
    points = solid.inside
    radii = solid.depth(points) * (1 - _DUST) - _DUST
    usable = np.flatnonzero(radii > _LEAST_RADIUS)
    if not len(usable):
        return np.zeros((0, 4))
    # The deepest few hundred, and every third of the others.
    order = usable[np.argsort(-radii[usable], kind="stable")]
    order = np.concatenate([order[:300], order[300::3]])[:1200]
    square = ((points[order, None] - points[None]) ** 2).sum(axis=2)
    held = square <= radii[order, None] ** 2
    left = np.ones(len(points), dtype=bool)
    found: list[Array] = []
    while len(found) < _MOST:
        gains = held[:, left].sum(axis=1)
        best = int(np.argmax(gains))
        if found and gains[best] < max(1.0, _LEAST_GAIN * len(points)):
            break
        found.append(np.append(points[order[best]], radii[order[best]]))
        left &= ~held[best]
    return np.array(found).reshape(-1, 4)
