"""A second opinion on two shapes: two points of theirs, at a distance that is plain.

The point of least length of the difference A - B is looked for by Wolfe's algorithm (Mathematical
Programming 11, 1976) with nothing but support functions. The two points that it is made of belong
to the shapes, so that their distance is never less than the true one; what separates bounds it
from below.
"""

import numpy as np

from planning.domain.arrays import Array
from tests.adversary.draws.shapes import support
from tests.adversary.judge.distances import Solid

_ROUNDS = 300


def bracket(a: Solid, b: Solid, i: int) -> tuple[float, float]:
    """Return a lower and an upper bound on the distance of two shapes at an instant [m].

    Both are zero for shapes that overlap.
    """
    point = a.poses[i, :3, 3] - b.poses[i, :3, 3]
    corral = [_extreme(a, b, i, -point if point.any() else np.array([1.0, 0.0, 0.0]))]
    lower, v = 0.0, corral[0]
    for _ in range(_ROUNDS):
        length = float(np.linalg.norm(v))
        if length < 1e-13 * (a.radius + b.radius):
            return 0.0, 0.0
        reached = _extreme(a, b, i, -v)
        lower = max(lower, float(v @ reached) / length)
        if length - lower < 1e-12 * (a.radius + b.radius) or _has(corral, reached):
            break
        corral, v = _least([*corral, reached])
        if len(corral) == 4:
            return 0.0, 0.0
    return lower, float(np.linalg.norm(v))


def _extreme(a: Solid, b: Solid, i: int, n: Array) -> Array:
    """Return the point of A - B that is farthest along n."""
    tips = []
    for solid, along in ((a, n), (b, -n)):
        turn = solid.poses[i, :3, :3]
        tips.append(solid.poses[i, :3, 3] + turn @ support(solid.shape, along @ turn))
    return tips[0] - tips[1]


def _has(corral: list[Array], point: Array) -> bool:
    return any(np.array_equal(known, point) for known in corral)


def _least(corral: list[Array]) -> tuple[list[Array], Array]:
    """Return the points of a simplex that its point of least length is made of, and that point."""
    best: tuple[list[Array], Array] | None = None
    count = len(corral)
    for mask in range(1, 1 << count):
        chosen = [corral[k] for k in range(count) if mask >> k & 1]
        weights = _affine(chosen)
        if weights is None or (weights < 0).any():
            continue
        v = weights @ np.array(chosen)
        if best is None or v @ v < best[1] @ best[1]:
            best = chosen, v
    if best is None:
        return [corral[-1]], corral[-1]
    return best


def _affine(points: list[Array]) -> Array | None:
    """Return the weights of the point of least length in the plane through some points."""
    first, rest = points[0], np.array(points[1:])
    if len(points) == 1:
        return np.ones(1)
    edges = rest - first
    found, _, rank, _ = np.linalg.lstsq(edges.T, -first, rcond=1e-14)
    return np.concatenate([[1 - found.sum()], found]) if rank == len(edges) else None
