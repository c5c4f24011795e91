"""Coverings hold their shapes, stay inside them, and reach no farther than they say."""

from itertools import product

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from planning.errors import ModelInvalid
from planning.kernel.coverings.covering import Covering, cover
from planning.kernel.shape import ConvexShape, ShapeKind
from tests.kernel.bodies import body, depth, distance, hull, inside, on_surface
from tests.profiles import num_cases

# Random points and spheres are computed in doubles of size about one.
ROUNDING = 1e-12

PRIMITIVES = (
    ShapeKind.BOX,
    ShapeKind.SPHERE,
    ShapeKind.CYLINDER,
    ShapeKind.CAPSULE,
    ShapeKind.ELLIPSOID,
)
sizes = st.floats(0.003, 1.0)


@pytest.fixture(autouse=True)
def _only_with_kernel() -> None:
    """Coverings need no native code."""


primitives = st.builds(body, st.sampled_from(PRIMITIVES), sizes, sizes, sizes)
hulls = st.builds(hull, st.integers(0, 2**32 - 1), st.integers(4, 60), sizes, sizes, sizes)
shapes = st.one_of(primitives, hulls)


def left_out(spheres: np.ndarray, points: np.ndarray) -> float:
    """Return how far the worst of the points lies outside of all spheres; negative within."""
    away = np.linalg.norm(points[:, None] - spheres[None, :, :3], axis=2) - spheres[:, 3]
    return float(away.min(axis=1).max())


def samples(shape: ConvexShape, seed: int = 0, times: int = 1) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return np.concatenate([inside(shape, rng, 3000 * times), on_surface(shape, rng, 6000 * times)])


@settings(max_examples=num_cases(6))
@given(shape=shapes)
@example(shape=body(ShapeKind.BOX, 0.5, 0.5, 0.5))
@example(shape=body(ShapeKind.BOX, 0.01, 0.4, 0.6))
@example(shape=body(ShapeKind.CYLINDER, 0.005, 0.4, 0.0))
@example(shape=body(ShapeKind.CYLINDER, 0.4, 0.003, 0.0))
@example(shape=body(ShapeKind.CAPSULE, 0.1, 0.0, 0.0))
@example(shape=body(ShapeKind.ELLIPSOID, 0.3, 0.02, 0.1))
@example(shape=body(ShapeKind.ELLIPSOID, 0.2, 0.2, 0.2))
def test_outer_spheres_and_the_bound_contain_the_shape(shape: ConvexShape) -> None:
    covering = cover(shape)
    points = samples(shape)
    assert left_out(covering.outer, points) <= ROUNDING
    assert left_out(covering.bound[None], points) <= ROUNDING


@settings(max_examples=num_cases(6))
@given(shape=shapes)
def test_outer_spheres_reach_no_farther_than_said(shape: ConvexShape) -> None:
    covering = cover(shape)
    rng = np.random.default_rng(1)
    away = rng.normal(size=(len(covering.outer), 300, 3))
    away /= np.linalg.norm(away, axis=2)[:, :, None]
    points = covering.outer[:, None, :3] + covering.outer[:, None, 3:] * away
    assert distance(shape, points.reshape(-1, 3)).max() <= covering.protrusion + 1e-7


@settings(max_examples=num_cases(6))
@given(shape=shapes)
def test_inner_spheres_lie_inside(shape: ConvexShape) -> None:
    covering = cover(shape)
    assert len(covering.inner)
    assert (covering.inner[:, 3] > 0).all()
    assert (depth(shape, covering.inner[:, :3]) >= covering.inner[:, 3] - ROUNDING).all()
    rng = np.random.default_rng(2)
    away = rng.normal(size=(len(covering.inner), 200, 3))
    away /= np.linalg.norm(away, axis=2)[:, :, None]
    points = covering.inner[:, None, :3] + covering.inner[:, None, 3:] * away
    assert distance(shape, points.reshape(-1, 3)).max() <= 1e-7


@settings(max_examples=num_cases(6))
@given(shape=shapes)
def test_the_checker_finds_a_sphere_that_is_missing(shape: ConvexShape) -> None:
    """These samples show that a sphere is not there, unless others cover all but a crumb."""
    outer = cover(shape).outer
    if len(outer) == 1:
        return
    less = [np.delete(outer, i, axis=0) for i in range(len(outer))]
    crumb = 0.01 * outer[:, 3].max()
    points, dense = samples(shape, 3), samples(shape, 4, times=6)
    assert all(
        left_out(spheres, points) > ROUNDING for spheres in less if left_out(spheres, dense) > crumb
    )
    assert max(left_out(spheres, points) for spheres in less) > ROUNDING


@settings(max_examples=num_cases(6))
@given(a=sizes, b=sizes, c=sizes)
def test_a_partition_proves_that_boxes_are_covered(a: float, b: float, c: float) -> None:
    """Cells whose corners share a sphere are in it; the others are halved until none is left."""
    half = np.array([a, b, c])
    outer = cover(body(ShapeKind.BOX, a, b, c)).outer * 1.0
    # What is held but for a hair would be halved for ever.
    outer[:, 3] += 2e-3 * half.max()
    cells = [(-half, half)]
    for _ in range(40):
        cells = [part for cell in cells if not _is_held(cell, outer) for part in _halves(*cell)]
        if not cells:
            return
    pytest.fail("some cells are in no sphere")


def _is_held(cell: tuple[np.ndarray, np.ndarray], outer: np.ndarray) -> bool:
    corners = np.array(list(product(*np.transpose(cell))))
    away = np.linalg.norm(corners[:, None] - outer[None, :, :3], axis=2)
    return bool((away <= outer[:, 3]).all(axis=0).any())


def _halves(low: np.ndarray, high: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    axis = int(np.argmax(high - low))
    upper, lower = high.copy(), low.copy()
    upper[axis] = lower[axis] = (low[axis] + high[axis]) / 2
    return [(low, upper), (lower, high)]


@pytest.mark.parametrize(
    "shape",
    [
        body(ShapeKind.BOX, 0.1, 0.2, 0.3),
        body(ShapeKind.CYLINDER, 0.1, 0.2, 0.0),
        body(ShapeKind.CAPSULE, 0.1, 0.2, 0.0),
        body(ShapeKind.ELLIPSOID, 0.1, 0.2, 0.3),
        hull(7, 200, 0.1, 0.2, 0.3),
    ],
)
def test_few_spheres_reach_much_less_far_than_one_and_fill_much(shape: ConvexShape) -> None:
    covering = cover(shape)
    assert len(covering.outer) <= 16
    assert len(covering.inner) <= 12
    alone = covering.bound[3] - depth(shape, covering.bound[None, :3])[0]
    assert covering.protrusion < 0.35 * alone
    surface = on_surface(shape, np.random.default_rng(4), 2000)
    gaps = np.linalg.norm(surface[:, None] - covering.inner[None, :, :3], axis=2)
    assert (gaps - covering.inner[:, 3]).min(axis=1).mean() < 0.6 * depth(
        shape, covering.inner[:, :3]
    ).max()


@given(shape=shapes)
@settings(max_examples=num_cases(6))
def test_the_same_shape_has_the_same_covering(shape: ConvexShape) -> None:
    again = ConvexShape(shape.kind, shape.size, shape.vertices, shape.planes)
    first, second = cover(shape), cover(again)
    assert first == second
    assert first.outer.tobytes() == second.outer.tobytes()
    assert (np.diff(first.outer[:, 3]) <= 0).all()


@settings(max_examples=num_cases(6))
@given(shape=hulls, x=st.floats(-50, 50))
def test_hulls_far_from_their_origin_are_covered(shape: ConvexShape, x: float) -> None:
    shift = np.array([x, -x, 2 * x])
    planes = shape.planes.copy()
    planes[:, 3] = ((shape.vertices + shift) @ planes[:, :3].T).max(axis=0)
    moved = ConvexShape(shape.kind, shape.size, shape.vertices + shift, planes)
    covering = cover(moved)
    assert left_out(covering.outer, samples(shape) + shift) <= 1e-10
    assert covering.protrusion < covering.bound[3]


def test_a_sphere_is_its_own_covering() -> None:
    covering = cover(body(ShapeKind.SPHERE, 0.3, 0.0, 0.0))
    ball = np.array([0.0, 0.0, 0.0, 0.3])
    assert covering == Covering(ball[None], ball[None], ball, 0.0)


def test_a_hull_without_thickness_is_covered() -> None:
    square = np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]) * 0.1
    sides = [(1.0, 0, 0, 0.1), (-1, 0, 0, 0.1), (0, 1, 0, 0.1), (0, -1, 0, 0.1)]
    planes = np.array([*sides, (0, 0, 1, 0.0), (0, 0, -1, 0.0)])
    covering = cover(ConvexShape(ShapeKind.HULL, np.zeros(3), square, planes))
    points = np.random.default_rng(5).uniform(-0.1, 0.1, (4000, 3)) * [1, 1, 0]
    assert left_out(covering.outer, np.concatenate([points, square])) <= ROUNDING
    assert not len(covering.inner)


def test_a_half_space_has_no_covering() -> None:
    with pytest.raises(ModelInvalid, match="half_space"):
        cover(body(ShapeKind.HALF_SPACE, 0.0, 0.0, 0.0))
