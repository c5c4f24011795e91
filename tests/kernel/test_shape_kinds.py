"""Every kind of shape has all that the kernel and its tests need; a new one fails until it has.

`docs/explanation/kernel.md` has the steps. Truth are samples of the shape, and distances that
`bodies.py` computes from its definition.
"""

from typing import Any

import numpy as np
import pytest
from pydrake.geometry import Convex

from planning.errors import ModelInvalid
from planning.goals.targets.tool_target import FreedomKind
from planning.kernel.coverings.covering import cover
from planning.kernel.native import native, verdict_numbers
from planning.kernel.shape import ConvexShape, ShapeKind
from planning.kernel.support import farthest_point
from planning.world.kernel.convex_shapes import convex_shape
from planning.world.kernel.link_tree import LinkKind
from tests.kernel.bodies import body, depth, distance, hull, inside, on_surface
from tests.kernel.conftest import COLLIDING, FREE, UNSURE
from tests.profiles import num_cases, rng_of, seeds

pytestmark = pytest.mark.campaign

KINDS = pytest.mark.parametrize("kind", ShapeKind)
BOUNDED = pytest.mark.parametrize("kind", [k for k in ShapeKind if k is not ShapeKind.HALF_SPACE])
RADIUS = 0.05
ROUNDING = 1e-9


def example(kind: ShapeKind) -> ConvexShape:
    return hull(5, 20, 0.2, 0.3, 0.4) if kind is ShapeKind.HULL else body(kind, 0.2, 0.3, 0.4)


def directions(rng: np.random.Generator, count: int) -> np.ndarray:
    n = rng.normal(size=(count, 3))
    return n / np.linalg.norm(n, axis=1)[:, None]


def test_python_and_the_kernel_have_the_same_kinds() -> None:
    module: Any = native()
    assert [kind.name for kind in ShapeKind] == [kind.name for kind in module.ShapeKind]
    assert {kind.name for kind in LinkKind} | {"FIXED"} == {k.name for k in module.JointKind}
    assert verdict_numbers(module) == (FREE, COLLIDING, UNSURE)
    assert {kind.name for kind in FreedomKind} == {kind.name for kind in module.Freedom}


@KINDS
@pytest.mark.parametrize("seed", seeds(1))
def test_samplers_and_distances_agree(kind: ShapeKind, seed: int) -> None:
    shape, rng = example(kind), rng_of(seed)
    within, surface = inside(shape, rng, 500), on_surface(shape, rng, 500)
    assert (depth(shape, within) >= -ROUNDING).all()
    assert (distance(shape, within) <= ROUNDING).all()
    assert (distance(shape, surface) <= ROUNDING).all()
    middle, radius = shape.ball
    for points in (within, surface):
        assert (np.linalg.norm(points - middle, axis=1) <= radius + ROUNDING).all()


@BOUNDED
@pytest.mark.parametrize("seed", seeds(1))
def test_the_support_function_is_as_far_as_any_point_and_a_point_of_the_shape(
    kind: ShapeKind, seed: int
) -> None:
    shape, rng = example(kind), rng_of(seed)
    surface = on_surface(shape, rng, 5000)
    for n in directions(rng, 50):
        farthest = farthest_point(shape, n)
        assert (surface @ n).max() <= farthest @ n + ROUNDING
        assert distance(shape, farthest[None])[0] <= ROUNDING


def test_a_half_space_has_no_farthest_point_and_no_covering() -> None:
    with pytest.raises(ModelInvalid, match="half_space"):
        farthest_point(example(ShapeKind.HALF_SPACE), np.array([0.0, 0.0, 1.0]))
    with pytest.raises(ModelInvalid, match="half_space"):
        cover(example(ShapeKind.HALF_SPACE))


@KINDS
@pytest.mark.parametrize("moves", [False, True])
@pytest.mark.parametrize("seed", seeds(1))
def test_no_verdict_on_a_sphere_beside_the_shape_is_wrong(
    kind: ShapeKind, seed: int, *, moves: bool
) -> None:
    shape, rng = example(kind), rng_of(seed)
    count = num_cases(200, 3000)
    surface = on_surface(shape, rng, 5000)
    centers = surface[rng.integers(len(surface), size=count)]
    centers = centers + rng.normal(0.0, 1.5 * RADIUS, (count, 3))
    qs = _configurations(centers, rng, moves=moves)
    samples = np.concatenate([surface, inside(shape, rng, 2000)])
    module: Any = native()
    for name in module.batch_kernels():
        verdicts = _checker(shape, name, moves=moves).check(qs)
        for center in centers[verdicts == FREE]:
            assert np.linalg.norm(samples - center, axis=1).min() > RADIUS
        assert (distance(shape, centers[verdicts == COLLIDING]) < RADIUS).all()
        assert set(np.unique(verdicts)) >= {FREE, COLLIDING}
        assert (verdicts == UNSURE).mean() < 0.02


@KINDS
def test_a_margin_below_zero_permits_that_depth_and_no_more(kind: ShapeKind) -> None:
    """Lanes know distances, but few depths: what is deeper than is permitted is never free."""
    shape, rng = example(kind), rng_of(0)
    centers = inside(shape, rng, 300)
    permitted = 0.03
    qs = _configurations(centers, rng, moves=False)
    # A ball about a point of the shape overlaps by its depth and more.
    too_deep = depth(shape, centers) + RADIUS > permitted + 1e-4
    assert too_deep.any()
    module: Any = native()
    for name in module.batch_kernels():
        verdicts = _checker(shape, name, moves=False, margin=-permitted).check(qs)
        assert (verdicts[too_deep] != FREE).all()


@pytest.mark.parametrize("corners", [np.eye(3) * [0.1, 0.2, 0.3], np.eye(3)[:, :2] * 0.4])
@pytest.mark.parametrize("moves", [False, True])
def test_a_flat_hull_collides_on_neither_side_of_it(corners: np.ndarray, *, moves: bool) -> None:
    """Drake has one face of it: a point behind that is not inside the hull."""
    points = np.asfortranarray(np.pad(corners, ((0, 0), (0, 3 - corners.shape[1]))).T)
    shape, rng = convex_shape(Convex(points, "flat")), rng_of(0)
    assert shape is not None
    assert len(cover(shape).inner) == 0
    centers = inside(shape, rng, 2000)[:2000] + rng.normal(0.0, 2 * RADIUS, (2000, 3))
    far = distance(shape, centers) > RADIUS
    module: Any = native()
    for name in module.batch_kernels():
        verdicts = _checker(shape, name, moves=moves).check(
            _configurations(centers, rng, moves=moves)
        )
        assert (verdicts[far] != COLLIDING).all()
        assert (verdicts == FREE).any()
        assert (verdicts == COLLIDING).any()


def _configurations(centers: np.ndarray, rng: np.random.Generator, *, moves: bool) -> np.ndarray:
    """Return configurations [quaternion, position] with the sphere at those points of the shape."""
    if not moves:
        turns = np.repeat(np.array([[1.0, 0.0, 0.0, 0.0]]), len(centers), axis=0)
        return np.column_stack([turns, centers])
    turns = rng.normal(size=(len(centers), 4))
    turns /= np.linalg.norm(turns, axis=1)[:, None]
    w, v = turns[:, :1], turns[:, 1:]
    # The sphere stays in the world's origin: p_WG = -R c.
    turned = centers + 2 * np.cross(v, np.cross(v, centers) + w * centers)
    return np.column_stack([turns, -turned])


def _checker(shape: ConvexShape, name: str, *, moves: bool, margin: float = 0.0) -> Any:
    """Return a checker of the shape and a sphere, one of which floats."""
    module: Any = native()
    eye = np.array([1.0, 0, 0, 0, 1.0, 0, 0, 0, 1.0, 0, 0, 0])
    made = module.Scene(7, 6)
    made.add_link(-1, eye, module.JointKind.FLOATING, np.zeros(3), 0, 0)
    for each, link in ((shape, moves), (body(ShapeKind.SPHERE, RADIUS, 0, 0), not moves)):
        spheres = (np.zeros((0, 4)), np.zeros((0, 4)), np.zeros(4))
        if link and each.kind is not ShapeKind.HALF_SPACE:
            covering = cover(each)
            spheres = covering.outer, covering.inner, covering.bound
        kind = module.ShapeKind[each.kind.name]
        made.add_geometry(
            0 if link else -1, eye, kind, each.size, each.vertices, each.planes, *spheres
        )
    made.add_pair(0, 1)
    state = np.array([1.0, 0, 0, 0, 0, 0, 0])
    limits = np.full((1, 2), margin)
    return module.Checker(made, np.arange(7), np.arange(6), state, limits, name)
