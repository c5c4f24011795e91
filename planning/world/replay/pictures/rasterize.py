"""rasterize(): which triangle each pixel shows, by a depth buffer in numpy.

Triangles are cut into the rows of the picture that they reach, and rows into pixels, all of them
together: only pixels that are covered cost anything. What is nearer is a larger number, since 1/z
is linear on the picture.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array

# Rows or pixels that are looked at together: some 30 MB for each number of them.
_MAX_TOGETHER = 2**22
_DEPTH_BITS = 32
# Twice the area [pixel^2] below which a triangle is a line.
_FLAT = 1e-9


@dataclass(frozen=True)
class Hits:
    """What the pixels of a picture show.

    Attributes:
        rows: Of the triangles, shape (height, width); -1 for nothing.
        weights: Of their corners at each pixel, in space, shape (height, width, 3).
        inverse_depth: 1/z [1/m], or -z [m] where it was projected in parallel; -inf for nothing.
    """

    rows: np.ndarray[Any, np.dtype[np.int64]]
    weights: Float64[np.ndarray, "h w 3"]
    inverse_depth: Float64[np.ndarray, "h w"]


def rasterize(
    corners: Float64[np.ndarray, "n 3 2"],
    inverse_depth: Float64[np.ndarray, "n 3"],
    size: tuple[int, int],
    *,
    is_perspective: bool,
) -> Hits:
    """Return what each pixel shows.

    Args:
        corners: Of the triangles, on the picture [pixel], x to the right and y down.
        inverse_depth: Of the corners: 1/z [1/m] in perspective, else -z [m].
        size: Width and height [pixel].
        is_perspective: Whether weights in space are others than those on the picture.
    """
    width, height = size
    best = np.zeros(width * height, dtype=np.uint64)
    if len(corners):
        low, high = float(inverse_depth.min()), float(inverse_depth.max())
        scale = (2**_DEPTH_BITS - 1) / max(high - low, 1e-12)
        for rows, x, y, near in _covered(corners, inverse_depth, size):
            level = ((near - low) * scale).clip(0, 2**_DEPTH_BITS - 1).astype(np.uint64)
            # Of equally near triangles the first one wins, whatever the order of the pixels.
            key = (
                (level << np.uint64(_DEPTH_BITS))
                + np.uint64(2**_DEPTH_BITS - 1)
                - rows.astype(np.uint64)
            )
            np.maximum.at(best, y * width + x, key)
    shown = best > 0
    low_half = best & np.uint64(2**_DEPTH_BITS - 1)
    rows = np.where(shown, 2**_DEPTH_BITS - 1 - low_half.astype(np.int64), -1)
    return _hits(rows.reshape(height, width), corners, inverse_depth, is_perspective=is_perspective)


def _hits(rows: Any, corners: Array, inverse_depth: Array, *, is_perspective: bool) -> Hits:
    height, width = rows.shape
    weights, near = np.zeros((height, width, 3)), np.full((height, width), -np.inf)
    y, x = np.nonzero(rows >= 0)
    shown = rows[y, x]
    if len(shown):
        points = np.stack([x, y], axis=1).astype(np.float64) + 0.5
        found = _barycentric(corners[shown], points)
        found = found.clip(0.0, 1.0)
        found /= found.sum(axis=1, keepdims=True)
        near[y, x] = np.einsum("nk,nk->n", found, inverse_depth[shown])
        if is_perspective:
            found = found * inverse_depth[shown]
            found /= found.sum(axis=1, keepdims=True)
        weights[y, x] = found
    return Hits(rows, weights, near)


def _covered(
    corners: Array, inverse_depth: Array, size: tuple[int, int]
) -> Iterator[tuple[Any, Any, Any, Array]]:
    """Yield triangles (rows), columns and rows of pixels in them, and how near they are there."""
    planes, is_flat = _planes(corners, inverse_depth)
    low, high = corners[..., 1].min(axis=1), corners[..., 1].max(axis=1)
    # Of pixels whose middle is inside.
    first = np.ceil(low - 0.5).clip(0, size[1]).astype(np.int64)
    last = np.floor(high - 0.5).clip(-1, size[1] - 1).astype(np.int64)
    counts = np.where(is_flat, 0, (last - first + 1).clip(0))
    for chosen in _portions(counts):
        rows, k = _repeated(chosen, counts[chosen])
        y = first[rows] + k
        begin, end = _spans(corners[rows], y + 0.5, size[0])
        widths = (end - begin).clip(0)
        for part in _portions(widths):
            spans, k = _repeated(part, widths[part])
            x = begin[spans] + k
            shown, line = rows[spans], y[spans]
            a, b, c = planes[shown].T
            yield shown, x, line, a * (x + 0.5) + b * (line + 0.5) + c


def _portions(counts: Any) -> Iterator[Any]:
    """Yield consecutive rows whose counts are together as many as fit into memory, or one row."""
    total = np.cumsum(counts)
    begin, before = 0, 0
    while begin < len(counts):
        end = int(np.searchsorted(total, before + _MAX_TOGETHER, side="right"))
        end = max(end, begin + 1)
        rows = np.arange(begin, end)
        yield rows[counts[begin:end] > 0]
        begin, before = end, int(total[end - 1])


def _repeated(rows: Any, counts: Any) -> tuple[Any, Any]:
    """Return each row as often as its count says, and 0, 1, ... beside it."""
    begins = np.cumsum(counts) - counts
    return np.repeat(rows, counts), np.arange(int(counts.sum())) - np.repeat(begins, counts)


def _spans(triangles: Array, y: Array, width: int) -> tuple[Any, Any]:
    """Return the columns from and before which triangles cover the lines at y."""
    low, high = np.full(len(y), np.inf), np.full(len(y), -np.inf)
    for i in range(3):
        p, q = triangles[:, i], triangles[:, (i + 1) % 3]
        crosses = (p[:, 1] <= y) != (q[:, 1] <= y)
        rise = np.where(crosses, q[:, 1] - p[:, 1], 1.0)
        x = p[:, 0] + (y - p[:, 1]) * (q[:, 0] - p[:, 0]) / rise
        low = np.where(crosses, np.minimum(low, x), low)
        high = np.where(crosses, np.maximum(high, x), high)
    begin = np.ceil(low.clip(-1, width + 1) - 0.5).clip(0, width)
    end = np.floor(high.clip(-1, width + 1) - 0.5).clip(-1, width - 1) + 1
    return begin.astype(np.int64), end.astype(np.int64)


def _planes(corners: Array, inverse_depth: Array) -> tuple[Array, Any]:
    """Return (a, b, c) of inverse_depth = a x + b y + c, (n, 3), and which triangles are lines."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    area = _cross(b - a, c - a)
    is_flat = np.abs(area) < _FLAT
    area = np.where(is_flat, 1.0, area)
    to_b, to_c = (
        inverse_depth[:, 1] - inverse_depth[:, 0],
        inverse_depth[:, 2] - inverse_depth[:, 0],
    )
    along_x = (to_b * (c - a)[:, 1] - to_c * (b - a)[:, 1]) / area
    along_y = (to_c * (b - a)[:, 0] - to_b * (c - a)[:, 0]) / area
    rest = inverse_depth[:, 0] - along_x * a[:, 0] - along_y * a[:, 1]
    return np.stack([along_x, along_y, rest], axis=1), is_flat


def _barycentric(triangles: Array, points: Array) -> Array:
    """Return the weights of the corners at points, shape (n, 3)."""
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    area = _cross(b - a, c - a)
    second = _cross(points - a, c - a) / area
    third = _cross(b - a, points - a) / area
    return np.stack([1.0 - second - third, second, third], axis=1)


def _cross(first: Array, second: Array) -> Array:
    return first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
