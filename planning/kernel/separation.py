"""The distance of two convex shapes between two bounds, after Gilbert, Johnson and Keerthi.

The distance of A and B is that of the origin from the set of all a - b. Every step takes the point
v of a simplex in that set that is nearest to the origin: |v| is an upper bound on the distance. The
point w of the set that lies farthest along -v gives the slab v . w / |v|, a lower bound, and joins
the simplex. (Gilbert, Johnson, Keerthi, "A fast procedure for computing the distance between
complex objects in three-dimensional space", 1988; van den Bergen 1999 for the two bounds.) Both
bounds hold at every step, so an early end or a degenerate simplex costs sharpness, never truth.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations
from math import sqrt
from typing import Any

import numpy as np
from jaxtyping import Float64

type Array = np.ndarray[Any, np.dtype[np.float64]]

_MAX_STEPS = 60
_TOLERANCE = 1e-10
# How near the bounds must be where the lower one cannot become large enough any more [m].
CLOSE = 1e-5


@dataclass(frozen=True)
class Separation:
    """Two bounds on a distance.

    Attributes:
        lower: Largest slab that was found [m]; negative if none separates.
        upper: Smallest distance of points of both shapes that was found [m]; 0 if they overlap.
        direction: Unit vector of that slab, from B to A.
        corners: Of the simplex that has the point of `upper`, shape (1 to 4, 3) [m].
    """

    lower: float
    upper: float
    direction: Float64[np.ndarray, "3"]
    corners: Float64[np.ndarray, "k 3"]


def separation(
    support: Callable[[Array], Array],
    guess: Float64[np.ndarray, "3"],
    enough: float,
    close: float = CLOSE,
) -> Separation:
    """Bound the distance of the origin from a convex set.

    Args:
        support: Returns the point of the set that lies farthest along a vector.
        guess: A vector to begin with, for example from B's middle to A's.
        enough: A lower bound as large as this ends the search [m].
        close: Bounds as near to each other end it where the upper one is not `enough` [m].
    """
    corners = np.zeros((0, 3))
    v = guess if _length(guess) > _TOLERANCE else np.array([1.0, 0.0, 0.0])
    simplex = np.zeros((0, 3))
    lower, upper, direction = -np.inf, np.inf, v / _length(v)
    for _ in range(_MAX_STEPS):
        n = v / _length(v)
        w = support(-n)
        slab = float(n @ w)
        if slab > lower:
            lower, direction = slab, n
        if lower >= enough or upper - lower <= max(_TOLERANCE, 0.0 if upper > enough else close):
            break
        v, simplex = _nearest(np.vstack([simplex, w]))
        length = _length(v)
        if length >= upper:
            break
        upper, corners = length, simplex
        if upper <= _TOLERANCE:
            return Separation(lower, 0.0, direction, corners)
    return Separation(lower, upper, direction, corners)


def nearest_point(
    farthest_of_a: Callable[[Array], Array],
    farthest_of_b: Callable[[Array], Array],
    guess: Float64[np.ndarray, "3"],
) -> Float64[np.ndarray, "2 3"]:
    """Return the nearest points of two convex sets [m]; of sets that overlap, a common one twice.

    The nearest point of the set of all a - b is a mixture of corners of the last simplex; so are
    the points of A and B that make it, of the a and the b of those corners.

    Args:
        farthest_of_a: Returns the point of A that lies farthest along a vector.
        farthest_of_b: The same of B.
        guess: A vector to begin with, from B's middle to A's.
    """
    met: list[tuple[Array, Array]] = []

    def support(n: Array) -> Array:
        met.append((farthest_of_a(n), farthest_of_b(-n)))
        return met[-1][0] - met[-1][1]

    corners = separation(support, guess, np.inf).corners
    ends = [next(ends for ends in met if (ends[0] - ends[1] == c).all()) for c in corners]
    ahead, behind = np.array(ends).swapaxes(0, 1)
    weights = _weights(corners)
    return np.stack([weights @ ahead, weights @ behind])


def _length(vector: Array) -> float:
    """Return the same as numpy's norm, which takes five times as long for three numbers."""
    return sqrt(vector @ vector)


def _weights(corners: Array) -> Array:
    """Return how much of each corner is in the point of their plane nearest to the origin."""
    size = len(corners)
    system = np.ones((size + 1, size + 1))
    system[:size, :size] = corners @ corners.T
    system[size, size] = 0.0
    return np.linalg.lstsq(system, np.append(np.zeros(size), 1.0))[0][:size]


def _nearest(points: Array) -> tuple[Array, Array]:
    """Return the point of a simplex nearest to the origin, and the corners that span its face.

    The newest corner, the last, is always one of them: it lies nearer to the origin's side than
    every other. A face counts if the nearest point of its plane lies within it.
    """
    newest, edges = points[-1], points[:-1] - points[-1]
    gram, pulls = (edges @ edges.T).tolist(), (-edges @ newest).tolist()
    best, corners, least = newest, points[-1:], float(newest @ newest)
    for size, solve in _SOLVERS.items():
        for rows in combinations(range(len(edges)), size):
            weights = solve(gram, pulls, *rows)
            if weights is None or min(weights) <= 0 or sum(weights) >= 1:
                continue
            nearest = newest + np.array(weights) @ edges[list(rows)]
            square = float(nearest @ nearest)
            if square < least:
                best, corners, least = nearest, points[[*rows, -1]], square
    return best, corners


# Solutions of G w = p for some rows; None where their edges are all but dependent. Cramer's rule
# takes a tenth of LAPACK's time for so few rows, and is as good where edges are far from dependent.
type _Weights = Sequence[float] | None
_DEPENDENT, _FLAT = 1e-14, 1e-6


def _on_edge(gram: list[list[float]], pulls: list[float], i: int) -> _Weights:
    return (pulls[i] / gram[i][i],) if gram[i][i] > 0 else None


def _on_triangle(gram: list[list[float]], pulls: list[float], i: int, j: int) -> _Weights:
    a, b, c = gram[i][i], gram[i][j], gram[j][j]
    det = a * c - b * b
    if det <= _FLAT * a * c:
        return _solved(gram, pulls, [i, j])
    return (c * pulls[i] - b * pulls[j]) / det, (a * pulls[j] - b * pulls[i]) / det


def _in_tetrahedron(
    gram: list[list[float]], pulls: list[float], i: int, j: int, k: int
) -> _Weights:
    a, b, c = gram[i][i], gram[i][j], gram[i][k]
    d, e, f = gram[j][j], gram[j][k], gram[k][k]
    p, q, r = pulls[i], pulls[j], pulls[k]
    # The adjugate, which is symmetric.
    aa, ab, ac = d * f - e * e, c * e - b * f, b * e - c * d
    bb, bc, cc = a * f - c * c, b * c - a * e, a * d - b * b
    det = a * aa + b * ab + c * ac
    if det <= _FLAT * a * d * f:
        return _solved(gram, pulls, [i, j, k])
    return (
        (aa * p + ab * q + ac * r) / det,
        (ab * p + bb * q + bc * r) / det,
        (ac * p + bc * q + cc * r) / det,
    )


def _solved(gram: list[list[float]], pulls: list[float], rows: list[int]) -> _Weights:
    square = np.array(gram)[np.ix_(rows, rows)]
    if np.linalg.det(square) <= _DEPENDENT * float(np.prod(np.diag(square))):
        return None
    weights: list[float] = np.linalg.solve(square, np.array(pulls)[rows]).tolist()
    return weights


_SOLVERS: dict[int, Callable[..., _Weights]] = {
    1: _on_edge,
    2: _on_triangle,
    3: _in_tetrahedron,
}
