"""Polytopes of many vertices reach exactly as far as their farthest vertex, along any direction.

The height of a hull over a half space is that of its lowest vertex, which numpy finds among all.
"""

from typing import Any

import numpy as np
import pytest

from planning.kernel.native import native
from tests.profiles import rng_of, seeds

IDENTITY = np.append(np.eye(3).ravel(), np.zeros(3))
FAR = 1e3


def ball(rng: np.random.Generator, count: int) -> np.ndarray:
    points = rng.normal(size=(count, 3))
    return points / np.linalg.norm(points, axis=1)[:, None] * [0.3, 0.1, 0.7]


def prism(rng: np.random.Generator, count: int) -> np.ndarray:
    """Return two regular polygons, which lie in planes: all their vertices are equally far."""
    angles = np.linspace(0, 2 * np.pi, count // 2 + 1)[:-1]
    ring = np.stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)], axis=1)
    return np.vstack([ring, ring + np.array([0.0, 0.0, 1.0])])[rng.permutation(len(ring) * 2)] * 0.2


def grid(rng: np.random.Generator, count: int) -> np.ndarray:
    """Return points of a box, most within its faces, some of them twice."""
    points = rng.integers(-2, 3, (count, 3)) / 10
    return points[np.abs(points).max(axis=1) > 0.15]


def far_away(rng: np.random.Generator, count: int) -> np.ndarray:
    """Return a small body far from its own origin."""
    return 1e-3 * rng.normal(size=(count, 3)) + [5.0, -3.0, 2.0]


def directions(rng: np.random.Generator) -> np.ndarray:
    """Return unit directions, also along the borders of cells and a rounding beside them."""
    lattice = rng.integers(-4, 5, (300, 3)) / 4
    lattice = lattice[np.abs(lattice).max(axis=1) > 0]
    beside = lattice + rng.normal(0.0, 1e-15, lattice.shape)
    n = np.vstack([rng.normal(size=(300, 3)), lattice, beside])
    return n / np.linalg.norm(n, axis=1)[:, None]


def heights(vertices: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Return the kernel's heights of a hull over half spaces through the origin."""
    module: Any = native()
    scene = module.Scene(1, 1)
    scene.add_link(-1, IDENTITY, module.JointKind.PRISMATIC, np.array([1.0, 0.0, 0.0]), 0, 0)
    no_spheres, ball_of_all = np.zeros((0, 4)), np.array([[0.0, 0.0, 0.0, FAR]])
    add = scene.add_geometry
    add(
        *(0, IDENTITY, module.ShapeKind.HULL, np.zeros(3), np.ascontiguousarray(vertices)),
        *(np.zeros((2, 4)), ball_of_all, no_spheres, ball_of_all[0]),
    )
    for k, n in enumerate(normals):
        axes = np.linalg.svd(n[None])[2][1:]
        pose = np.append(np.column_stack([*axes, n]).ravel(), np.zeros(3))
        kind, none = module.ShapeKind.HALF_SPACE, np.zeros((0, 3))
        add(
            *(-1, pose, kind, np.zeros(3), none),
            *(no_spheres, no_spheres, no_spheres, ball_of_all[0]),
        )
        scene.add_pair(0, k + 1)
    first = np.zeros(1, dtype=np.int64)
    query = module.DistanceQuery(scene, first, first, np.zeros(1))
    _, pairs, found, _, _ = query.within(np.zeros((1, 1)), np.full(len(normals), FAR))
    np.testing.assert_array_equal(pairs, np.arange(len(normals)))
    return found


@pytest.mark.skipif(native() is None, reason="the native kernel is not built")
@pytest.mark.parametrize("make", [ball, prism, grid, far_away])
@pytest.mark.parametrize("count", [17, 60, 400, 3000])
@pytest.mark.parametrize("seed", seeds(1))
def test_a_hull_reaches_as_far_as_its_farthest_vertex(make: Any, count: int, seed: int) -> None:
    rng = rng_of(seed)
    vertices, normals = make(rng, count), directions(rng)
    expected = (vertices @ normals.T).min(axis=0)
    np.testing.assert_allclose(heights(vertices, normals), expected, rtol=0, atol=1e-14)
