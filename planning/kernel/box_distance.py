"""Distances of pairs of boxes, exact, and their separating slabs.

Two convex polytopes that do not overlap are nearest at a corner of one and any point of the other,
or at an edge of each (Ericson, "Real-Time Collision Detection", 2005, section 5.1). All of these
are tried: 2 x 8 corners and 12 x 12 pairs of edges, for many pairs of boxes at once.
"""

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array

_SIGNS = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
# Pairs of corners that differ in one sign.
_EDGES = np.array([
    (i, j) for i in range(8) for j in range(i) if np.abs(_SIGNS[i] - _SIGNS[j]).sum() == 2
])
_MIN_DENOMINATOR = 1e-30
# The sine of the angle between edges up to which they are parallel.
_PARALLEL_SINE = 1e-6


def box_distances(
    half_a: Float64[np.ndarray, "n 3"],
    X_WA: Float64[np.ndarray, "n 4 4"],
    half_b: Float64[np.ndarray, "n 3"],
    X_WB: Float64[np.ndarray, "n 4 4"],
) -> tuple[Float64[np.ndarray, " n"], Float64[np.ndarray, "n 2 3"]]:
    """Return the distances of pairs of boxes [m], and the nearest points of both in world.

    Not promised: the penetration depth of boxes that overlap. Their distance is then the smallest
    between corners and edges: zero if a corner of one is in the other. `box_gaps` has the depth.

    Args:
        half_a: Half sizes of the first boxes [m].
        X_WA: Their poses.
        half_b: Half sizes of the second [m].
        X_WB: Their poses.
    """
    corners_a, corners_b = _corners(half_a, X_WA), _corners(half_b, X_WB)
    nearest_in_b = _nearest_points_in_boxes(corners_a, half_b, X_WB)
    nearest_in_a = _nearest_points_in_boxes(corners_b, half_a, X_WA)
    edge_points = _edge_points(corners_a, corners_b)
    points_on_a = np.concatenate([corners_a, nearest_in_a, edge_points[0]], axis=1)
    points_on_b = np.concatenate([nearest_in_b, corners_b, edge_points[1]], axis=1)
    lengths = np.linalg.norm(points_on_a - points_on_b, axis=2)
    best, rows = np.argmin(lengths, axis=1), np.arange(len(lengths))
    return lengths[rows, best], np.stack([points_on_a[rows, best], points_on_b[rows, best]], axis=1)


def box_gaps(
    half_a: Float64[np.ndarray, "n 3"],
    X_WA: Float64[np.ndarray, "n 4 4"],
    half_b: Float64[np.ndarray, "n 3"],
    X_WB: Float64[np.ndarray, "n 4 4"],
) -> Float64[np.ndarray, " n"]:
    """Return the widest slabs between pairs of boxes [m]; negative is the depth of overlap.

    Separating axis test: two boxes are separate if a slab across an axis of one, or across an edge
    of each, separates them (Gottschalk, Lin, Manocha, "OBBTree", 1996).

    Args:
        half_a: Half sizes of the first boxes [m].
        X_WA: Their poses.
        half_b: Half sizes of the second [m].
        X_WB: Their poses.
    """
    R_WA, R_WB = X_WA[:, :3, :3], X_WB[:, :3, :3]
    edge_products = np.cross(R_WA[:, :, :, None], R_WB[:, :, None, :], axis=1).reshape(
        len(half_a), 3, 9
    )
    axes = np.concatenate([R_WA, R_WB, edge_products], axis=2)
    lengths = np.linalg.norm(axes, axis=1)
    gaps = np.abs(np.einsum("ni,nik->nk", X_WA[:, :3, 3] - X_WB[:, :3, 3], axes))
    for half, R_WG in ((half_a, R_WA), (half_b, R_WB)):
        gaps -= np.einsum("nj,njk->nk", half, np.abs(np.einsum("nij,nik->njk", R_WG, axes)))
    # Nearly parallel edges give no separating axis of their own.
    is_axis = lengths > _PARALLEL_SINE
    return np.where(is_axis, gaps / np.where(is_axis, lengths, 1.0), -np.inf).max(axis=1)


def _corners(half: Array, X_WB: Array) -> Array:
    local = _SIGNS[None] * half[:, None]
    return np.einsum("nij,nkj->nki", X_WB[:, :3, :3], local) + X_WB[:, None, :3, 3]


def _nearest_points_in_boxes(points: Array, half: Array, X_WB: Array) -> Array:
    """Return the points of boxes nearest to given points, shape (n, k, 3)."""
    local = np.einsum("nji,nkj->nki", X_WB[:, :3, :3], points - X_WB[:, None, :3, 3])
    inside = np.clip(local, -half[:, None], half[:, None])
    return np.einsum("nij,nkj->nki", X_WB[:, :3, :3], inside) + X_WB[:, None, :3, 3]


def _edge_points(corners_a: Array, corners_b: Array) -> tuple[Array, Array]:
    """Return the nearest points of every edge of a and every edge of b, shape (n, 144, 3) each."""
    p, q = corners_a[:, _EDGES[:, 0]][:, :, None], corners_b[:, _EDGES[:, 0]][:, None]
    u = corners_a[:, _EDGES[:, 1]][:, :, None] - p
    v = corners_b[:, _EDGES[:, 1]][:, None] - q
    r = p - q
    uu, vv, uv = (u * u).sum(-1), (v * v).sum(-1), (u * v).sum(-1)
    ur, vr = (u * r).sum(-1), (v * r).sum(-1)
    # Any point of parallel edges suffices: corners are tried as well.
    s = np.clip((uv * vr - ur * vv) / np.maximum(uu * vv - uv * uv, _MIN_DENOMINATOR), 0.0, 1.0)
    t = np.clip((uv * s + vr) / vv, 0.0, 1.0)
    s = np.clip((uv * t - ur) / uu, 0.0, 1.0)
    on_a, on_b = p + s[..., None] * u, q + t[..., None] * v
    return on_a.reshape(len(p), -1, 3), on_b.reshape(len(p), -1, 3)
