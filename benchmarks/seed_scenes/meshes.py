"""Triangles of Drake's shapes, for pictures."""

import numpy as np
from pydrake import geometry

from planning.domain.arrays import Array

_AROUND = 20


def triangles(shape: geometry.Shape) -> Array:
    """Return the surface of a shape, counter-clockwise from outside, shape (n, 3, 3).

    Raises:
        ValueError: It is of a kind that no seed scene has.
    """
    match shape:
        case geometry.Box():
            return _prism(np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) / 2, shape.size())
        case geometry.Cylinder():
            size = np.array([shape.radius(), shape.radius(), shape.length()])
            return _prism(_circle(), size)
        case geometry.Sphere():
            return _ball(np.full(3, shape.radius()))
        case geometry.Ellipsoid():
            return _ball(np.array([shape.a(), shape.b(), shape.c()]))
        case geometry.Capsule():
            return _ball(np.full(3, shape.radius()), shape.length())
        case _:
            message = f"{type(shape).__name__} is not drawn"
            raise ValueError(message)


def _circle() -> Array:
    angles = np.linspace(0.0, 2 * np.pi, _AROUND, endpoint=False)
    return np.stack([np.cos(angles), np.sin(angles)], axis=1)


def _prism(outline: Array, size: Array) -> Array:
    """Return a prism over an outline, one unit high before it is scaled by `size`."""
    count = len(outline)
    low = np.column_stack([outline, np.full(count, -0.5)])
    high = np.column_stack([outline, np.full(count, 0.5)])
    found: list[list[Array]] = []
    for i in range(count):
        k = (i + 1) % count
        found += [[low[i], low[k], high[k]], [low[i], high[k], high[i]]]
        found += [[high[0], high[i], high[k]], [low[0], low[k], low[i]]]
    return np.array(found) * size


def _ball(semi_axes: Array, length: float = 0.0) -> Array:
    """Return an ellipsoid, its halves `length` apart along z."""
    polar = np.linspace(0.0, np.pi, _AROUND // 2 + 1)
    ring = _circle()
    grid = np.array([
        [*(np.sin(angle) * point), np.cos(angle)] for angle in polar for point in ring
    ])
    grid = grid * semi_axes + np.array([0, 0, 1]) * (np.sign(grid[:, 2:]) * length / 2)
    rows = grid.reshape(len(polar), _AROUND, 3)
    ahead = np.roll(rows, -1, axis=1)
    first = np.stack([rows[:-1], rows[1:], ahead[1:]], axis=2)
    second = np.stack([rows[:-1], ahead[1:], ahead[:-1]], axis=2)
    return np.concatenate([first.reshape(-1, 3, 3), second.reshape(-1, 3, 3)])
