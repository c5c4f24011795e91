"""GJK: distance bounds and nearest points of two convex shapes (Gilbert, Johnson, Keerthi).

The distance of A and B is that of the origin from the set of all a - b. Every step takes the point
v of a simplex in that set that is nearest to the origin: |v| is an upper bound on the distance. The
point w of the set that lies farthest along -v gives the slab v . w / |v|, a lower bound, and joins
the simplex. (Gilbert, Johnson, Keerthi, "A fast procedure for computing the distance between
complex objects in three-dimensional space", 1988; van den Bergen 1999 for the two bounds.) Both
bounds hold at every step, so an early end or a degenerate simplex loses sharpness, not validity.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array

type Row = list[float]

_MAX_STEPS = 60
# Length of a direction below which it is zero [m].
_TOLERANCE = 1e-10
# Determinant below which a simplex has no extent, as a share of its largest possible value.
_DEGENERATE_DETERMINANT = 1e-14
# Gap of the bounds that ends the search where the lower one cannot become large enough [m].
GAP_TOLERANCE = 1e-5


@dataclass(frozen=True)
class GjkResult:
    """Lower and upper bound on a distance.

    Attributes:
        lower: Width of the largest separating slab [m]; negative if none separates.
        upper: Smallest distance between points of the two shapes [m]; 0 if they overlap.
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
    sufficient_distance: float,
    gap_tolerance: float = GAP_TOLERANCE,
) -> GjkResult:
    """Bound the distance of the origin from a convex set.

    Args:
        support: Returns the point of the set that lies farthest along a vector.
        guess: Initial direction, for example from B's middle to A's.
        sufficient_distance: A lower bound as large as this ends the search [m].
        gap_tolerance: Bounds as near to each other end the search where the upper one is not
            `sufficient_distance` [m].
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
        if lower >= sufficient_distance or upper - lower <= max(
            _TOLERANCE, 0.0 if upper > sufficient_distance else gap_tolerance
        ):
            break
        v, simplex = _nearest_in_simplex(np.concatenate([simplex, w[None]]))
        length = _length(v)
        if length >= upper:
            break
        upper, corners = length, simplex
        if upper <= _TOLERANCE:
            return GjkResult(lower, 0.0, direction, corners)
    return GjkResult(lower, upper, direction, corners)


def closest_points(
    support_a: Callable[[Array], Array],
    support_b: Callable[[Array], Array],
    guess: Float64[np.ndarray, "3"],
) -> Float64[np.ndarray, "2 3"]:
    """Return the nearest points of two convex sets [m]; of sets that overlap, a common one twice.

    The nearest point of the set of all a - b is a convex combination of corners of the last
    simplex; the points of A and B are the same combination of the a and the b of those corners.

    Args:
        support_a: Returns the point of A that lies farthest along a vector.
        support_b: The same of B.
        guess: Initial direction, from B's middle to A's.
    """
    support_pairs: list[tuple[Array, Array]] = []

    def support(n: Array) -> Array:
        support_pairs.append((support_a(n), support_b(-n)))
        return support_pairs[-1][0] - support_pairs[-1][1]

    corners = separation(support, guess, np.inf).corners
    ends = [next(ends for ends in support_pairs if (ends[0] - ends[1] == c).all()) for c in corners]
    points_on_a, points_on_b = np.array(ends).swapaxes(0, 1)
    weights = _weights(corners)
    return np.stack([weights @ points_on_a, weights @ points_on_b])


def _weights(corners: Array) -> Array:
    """Return the weights of the corners in the point of their plane nearest to the origin."""
    size = len(corners)
    system = np.ones((size + 1, size + 1))
    system[:size, :size] = corners @ corners.T
    system[size, size] = 0.0
    return np.linalg.lstsq(system, np.append(np.zeros(size), 1.0))[0][:size]


def _nearest_in_simplex(points: Array) -> tuple[Array, Array]:
    """Return the point of a simplex nearest to the origin, and the corners that span its face.

    The newest corner, the last, is always one of them: it lies nearer to the origin's side than
    every other. A face counts if the nearest point of its plane lies within it. Computed in plain
    numbers: calls of numpy would take ten times as long as the arithmetic.
    """
    *rows, newest = points.tolist()
    edges = [_difference(row, newest) for row in rows]
    gram = [[_dot(a, b) for b in edges] for a in edges]
    right_side = [-_dot(edge, newest) for edge in edges]
    best, chosen, least_square = newest, (), _dot(newest, newest)
    for size in range(1, len(points)):
        for others in combinations(range(len(rows)), size):
            weights = _solve_subsystem(gram, right_side, others)
            if not weights or min(weights) <= 0 or sum(weights) >= 1:
                continue
            nearest = newest
            for weight, i in zip(weights, others, strict=True):
                nearest = [x + weight * e for x, e in zip(nearest, edges[i], strict=True)]
            square = _dot(nearest, nearest)
            if square < least_square:
                best, chosen, least_square = nearest, others, square
    return np.array(best), points[[*chosen, len(rows)]]


def _solve_subsystem(gram: list[Row], right_side: Row, rows: tuple[int, ...]) -> Row:
    """Return the solution of some rows and columns of a linear system; empty if it has none.

    By elimination, which takes no pivoting where a matrix is positive definite (Golub, Van Loan,
    "Matrix computations", 4.2).
    """
    a = [[*(gram[i][j] for j in rows), right_side[i]] for i in rows]
    determinant = diagonal = 1.0
    for k, pivot in enumerate(a):
        determinant *= pivot[k]
        diagonal *= gram[rows[k]][rows[k]]
        if not determinant > _DEGENERATE_DETERMINANT * diagonal:
            return []
        for below in a[k + 1 :]:
            factor = below[k] / pivot[k]
            for j in range(k + 1, len(pivot)):
                below[j] -= factor * pivot[j]
    solution = [0.0] * len(a)
    for k in reversed(range(len(a))):
        known = sum(a[k][j] * solution[j] for j in range(k + 1, len(a)))
        solution[k] = (a[k][-1] - known) / a[k][k]
    return solution


def _difference(a: Row, b: Row) -> Row:
    return [a[0] - b[0], a[1] - b[1], a[2] - b[2]]


def _dot(a: Row, b: Row) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _length(v: Array) -> float:
    return math.sqrt(v.dot(v))
