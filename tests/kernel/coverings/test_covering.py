"""Outer spheres contain a shape, inner ones lie inside it, and files give back what was written."""

import json
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.geometry import Box, Capsule, Convex, Cylinder, Ellipsoid, Sphere

from planning.errors import ModelInvalid
from planning.kernel.coverings.covering import Covering, cover, stored_covering
from planning.kernel.coverings.solid import Solid
from planning.kernel.shape import ConvexShape, ShapeKind
from planning.world.kernel.convex_shapes import convex_shape
from tests.profiles import num_cases

SIZES = st.floats(0.004, 0.4)


def shape_of(kind: str, a: float, b: float, c: float, seed: int) -> ConvexShape:
    rng = np.random.default_rng(seed)
    points = np.asfortranarray((rng.normal(size=(25, 3)) * [a, b, c]).T)
    made = {
        "box": Box(a, b, c),
        "sphere": Sphere(a),
        "cylinder": Cylinder(a, b),
        "capsule": Capsule(a, b),
        "ellipsoid": Ellipsoid(a, b, c),
        "hull": Convex(points, "hull"),
    }
    shape = convex_shape(made[kind])
    assert shape is not None
    return shape


def points_of(shape: ConvexShape, rng: np.random.Generator, count: int) -> np.ndarray:
    """Return points of a shape, most of them on its surface: random ways out, followed to it."""
    n = rng.normal(size=(count, 3))
    n /= np.linalg.norm(n, axis=1)[:, None]
    size = shape.size
    match shape.kind:
        case ShapeKind.BOX:
            ends = np.sign(n) * size
            ends = ends * np.where(rng.random((count, 3)) < 0.5, 1.0, rng.random((count, 3)))
        case ShapeKind.SPHERE:
            ends = n * size[0]
        case ShapeKind.CYLINDER:
            around = n[:, :2] / np.linalg.norm(n[:, :2], axis=1)[:, None] * size[0]
            ends = np.column_stack([around, rng.uniform(-1, 1, count) * size[1]])
            ends[::2, 2] = np.sign(ends[::2, 2]) * size[1]
        case ShapeKind.CAPSULE:
            ends = n * size[0] + np.outer(rng.uniform(-1, 1, count) * size[1], [0, 0, 1])
        case ShapeKind.ELLIPSOID:
            ends = n * size
        case _:
            weights = rng.dirichlet(np.full(len(shape.vertices), 0.1), count)
            ends = np.concatenate([weights @ shape.vertices, shape.vertices])
    inwards = np.where(rng.random(len(ends)) < 0.7, 1.0, rng.random(len(ends)))
    middle = shape.vertices.mean(axis=0) if len(shape.vertices) else np.zeros(3)
    return middle + inwards[:, None] * (ends - middle)


def uncovered(points: np.ndarray, spheres: np.ndarray) -> int:
    """Return how many points lie in none of the spheres."""
    away = np.linalg.norm(points[:, None] - spheres[None, :, :3], axis=2)
    return int((away > spheres[None, :, 3] * (1 + 1e-12)).all(axis=1).sum())  # but for rounding


@settings(max_examples=num_cases(6))
@given(
    kind=st.sampled_from(["box", "sphere", "cylinder", "capsule", "ellipsoid", "hull"]),
    a=SIZES,
    b=SIZES,
    c=SIZES,
    seed=st.integers(0, 1000),
)
def test_the_shape_lies_between_its_spheres(kind, a, b, c, seed):
    shape = shape_of(kind, a, b, c, seed)
    covering = cover(shape)
    points = points_of(shape, np.random.default_rng(seed), 2000)
    assert uncovered(points, covering.outer) == 0
    assert uncovered(points, covering.bound[None]) == 0
    inside = covering.inner[:, :3]
    if len(inside) and kind != "sphere":
        assert (Solid.of(shape).depth(inside) >= covering.inner[:, 3]).all()
    assert len(covering.outer) <= 128
    assert list(covering.outer[:, 3]) == sorted(covering.outer[:, 3], reverse=True)


@pytest.mark.parametrize("kind", ["box", "cylinder", "hull"])
def test_outer_spheres_reach_no_farther_than_is_said(kind):
    shape = shape_of(kind, 0.12, 0.2, 0.3, 4)
    covering = cover(shape)
    rng = np.random.default_rng(0)
    n = rng.normal(size=(200, 3))
    n /= np.linalg.norm(n, axis=1)[:, None]
    solid = Solid.of(shape)
    for x, y, z, r in covering.outer:
        # A point at the protrusion beyond the surface has a depth of no less than minus that.
        rim = np.array([x, y, z]) + r * n
        assert solid.depth(rim).min() >= -covering.protrusion - 1e-9


def test_one_sphere_less_is_too_few():
    """What finds holes finds this one."""
    shape = shape_of("box", 0.2, 0.2, 0.3, 0)
    covering = cover(shape)
    points = points_of(shape, np.random.default_rng(1), 20_000)
    holes = [
        uncovered(points, np.delete(covering.outer, k, axis=0)) for k in range(len(covering.outer))
    ]
    assert max(holes) > 0


def test_the_same_shape_has_the_same_spheres():
    shape = shape_of("hull", 0.1, 0.2, 0.1, 3)
    assert cover(shape) == cover(shape)


def test_a_half_space_has_no_covering():
    endless = ConvexShape(ShapeKind.HALF_SPACE, np.zeros(3), np.zeros((0, 3)), np.zeros((0, 4)))
    with pytest.raises(ModelInvalid, match="half_space"):
        cover(endless)


def test_files_give_back_what_was_written(tmp_path):
    shapes = [shape_of("box", 0.1 + 0.01 * k, 0.2, 0.1, 0) for k in range(3)]
    for shape in shapes:
        assert stored_covering(shape, tmp_path) == cover(shape)
    assert len(list(tmp_path.iterdir())) == len(shapes)


@pytest.mark.parametrize("damage", ["", "{}", "[1]", '{"outer": 3}', "\x00\x01"])
def test_a_damaged_file_is_made_anew(tmp_path, damage):
    shape = shape_of("cylinder", 0.1, 0.2, 0.1, 0)
    whole = stored_covering(shape, tmp_path)
    (file,) = tmp_path.iterdir()
    written = file.read_text("utf-8")
    file.write_text(damage, "utf-8")
    assert stored_covering(shape, tmp_path) == whole
    assert file.read_text("utf-8") == written


def test_a_file_with_other_numbers_is_not_believed(tmp_path):
    shape = shape_of("cylinder", 0.1, 0.2, 0.1, 0)
    whole = stored_covering(shape, tmp_path)
    (file,) = tmp_path.iterdir()
    content = json.loads(file.read_text("utf-8"))
    content["outer"] = content["outer"][1:]
    file.write_text(json.dumps(content), "utf-8")
    assert stored_covering(shape, tmp_path) == whole


def test_a_folder_that_cannot_be_written_to_is_no_fault(tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("not a folder", "utf-8")
    shape = shape_of("box", 0.11, 0.21, 0.1, 0)
    assert isinstance(stored_covering(shape, blocked / "below"), Covering)


def test_bigger_spheres_come_first():
    radii = cover(shape_of("capsule", 0.05, 0.4, 0.1, 0)).outer[:, 3]
    assert all(a >= b for a, b in pairwise(radii))
