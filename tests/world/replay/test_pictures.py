"""Pictures of scenes: which triangle each pixel shows, and how large things are."""

import io
import itertools

import numpy as np
import pytest
from PIL import Image

from planning.domain.geometry.pose import Pose
from planning.domain.geometry.shapes import Box, Capsule, Cylinder, Ellipsoid, Sphere
from planning.domain.scene.geometry import VisibleBody, VisibleShape
from planning.world.replay.pictures.png import png
from planning.world.replay.pictures.rasterize import rasterize
from planning.world.replay.pictures.shade import shade
from planning.world.replay.pictures.surface import joined, surface_of
from planning.world.replay.pictures.view_point import view_of
from tests.profiles import rng_of, seeds

_GRAY = np.array([0.5, 0.5, 0.5, 1.0])


def nearest_by_hand(corners, inverse_depth, size):
    """Each pixel and each triangle in turn: inside if on the same side of all edges."""
    width, height = size
    rows = np.full((height, width), -1)
    near = np.full((height, width), -np.inf)
    doubtful = np.zeros((height, width), dtype=bool)
    for y in range(height):
        for x in range(width):
            point = np.array([x + 0.5, y + 0.5])
            for row, (triangle, values) in enumerate(zip(corners, inverse_depth, strict=True)):
                matrix = np.vstack([triangle.T, np.ones(3)])
                weights = np.linalg.solve(matrix, [*point, 1.0])
                doubtful[y, x] |= np.abs(weights).min() < 1e-6
                if weights.min() >= 0 and weights @ values > near[y, x]:
                    doubtful[y, x] |= abs(weights @ values - near[y, x]) < 1e-6
                    rows[y, x], near[y, x] = row, weights @ values
    return rows, near, doubtful


@pytest.mark.campaign
@pytest.mark.parametrize("seed", seeds(3))
def test_each_pixel_shows_the_nearest_triangle_that_covers_it(seed):
    rng = rng_of(seed)
    size = (23, 17)
    count = int(rng.integers(1, 30))
    corners = rng.uniform(-8, 30, size=(count, 3, 2))
    inverse_depth = rng.uniform(0.1, 2.0, size=(count, 3))
    hits = rasterize(corners, inverse_depth, size, is_perspective=False)
    rows, near, doubtful = nearest_by_hand(corners, inverse_depth, size)
    sure = ~doubtful
    np.testing.assert_array_equal(hits.rows[sure], rows[sure])
    shown = sure & (rows >= 0)
    np.testing.assert_allclose(hits.inverse_depth[shown], near[shown], atol=1e-9)
    np.testing.assert_allclose(hits.weights[shown].sum(axis=1), 1.0)


def test_triangles_that_share_an_edge_leave_no_gap_and_no_triangle_no_pixel():
    ticks = np.linspace(-3.0, 40.0, 12)
    quads = [
        [[(a, c), (b, c), (a, d)], [(b, c), (b, d), (a, d)]]
        for a, b in itertools.pairwise(ticks)
        for c, d in itertools.pairwise(ticks)
    ]
    corners = np.array(quads).reshape(-1, 3, 2)
    hits = rasterize(corners, np.ones(corners.shape[:2]), (37, 29), is_perspective=True)
    assert (hits.rows >= 0).all()
    none = rasterize(np.empty((0, 3, 2)), np.empty((0, 3)), (4, 3), is_perspective=True)
    assert (none.rows == -1).all()
    assert np.isneginf(none.inverse_depth).all()


@pytest.mark.parametrize(
    ("shape", "volume"),
    [
        (Box(np.array([0.3, 0.2, 0.5])), 0.03),
        (Sphere(0.2), 4 / 3 * np.pi * 0.008),
        (Cylinder(0.1, 0.4), np.pi * 0.004),
        (Capsule(0.1, 0.4), np.pi * 0.004 + 4 / 3 * np.pi * 0.001),
        (Ellipsoid(np.array([0.1, 0.2, 0.3])), 4 / 3 * np.pi * 0.006),
    ],
)
def test_surfaces_enclose_what_they_are_of_and_look_outwards(shape, volume):
    surface = surface_of(body_of(shape), {})
    a, b, c = surface.corners.transpose(1, 0, 2)
    # the divergence theorem, about a point that must not matter
    enclosed = np.einsum("nd,nd->n", a - 7.0, np.cross(b - 7.0, c - 7.0)).sum() / 6
    assert enclosed == pytest.approx(volume, rel=0.01)
    middle = surface.corners.mean(axis=1)
    centre = np.array([0.1, 0.2, 0.3])
    outwards = np.einsum("nd,nd->n", surface.normals.mean(axis=1), middle - centre)
    assert (outwards > 0).all()
    np.testing.assert_allclose(np.linalg.norm(surface.normals, axis=2), 1.0, atol=1e-6)


def body_of(shape, color=_GRAY):
    pose = Pose.from_parts([0.1, 0.2, 0.3], [1.0, 0.0, 0.0, 0.0])
    return VisibleBody("body", pose, (VisibleShape(shape, pose, color),))


@pytest.mark.parametrize("direction", [[1, -1, 0.5], [0, 0, 1], [0.2, 3, -1]])
def test_a_ball_fills_its_share_of_the_picture_from_everywhere(direction):
    surface = surface_of(body_of(Sphere(0.2)), {})
    cloud = surface.corners.reshape(-1, 3)
    picture = shade(surface, view_of(cloud, np.array(direction, dtype=float), 120, 90), cloud)
    shown = (picture < 0.98).any(axis=2)
    assert shown.sum() == pytest.approx(np.pi / 4 * (0.88 * 90) ** 2, rel=0.04)
    y, x = np.nonzero(shown)
    assert [x.mean(), y.mean()] == pytest.approx([59.5, 44.5], abs=1.0)
    again = shade(surface, view_of(cloud, np.array(direction, dtype=float), 120, 90), cloud)
    assert png(again) == png(picture)


def test_shadows_fall_on_what_is_behind_and_glass_shows_it():
    floor = surface_of(body_of(Box(np.array([2.0, 2.0, 0.02]))), {})
    ball = surface_of(body_of(Sphere(0.2)), {})
    raised = ball.placed(Pose.from_parts([0.0, 0.0, 0.6], [1.0, 0.0, 0.0, 0.0]).matrix)
    cloud = np.concatenate([floor.corners, raised.corners]).reshape(-1, 3)
    view = view_of(cloud, np.array([1.0, -1.0, 1.0]), 160, 120)
    bare = shade(floor, view, cloud)
    under = shade(joined([floor, raised]), view, cloud)
    darker = (bare - under).mean(axis=2) > 0.1
    ball_only = (shade(raised, view, cloud) < 0.98).any(axis=2)
    assert (darker & ~ball_only).sum() > 100
    glass = shade(joined([floor, raised.painted([0.5, 0.5, 0.5, 0.01])]), view, cloud)
    assert np.abs(glass - bare).max() < 0.05


def test_files_hold_what_was_drawn():
    picture = rng_of(3).uniform(size=(7, 11, 3))
    read = np.asarray(Image.open(io.BytesIO(png(picture))).convert("RGB"))
    np.testing.assert_array_equal(read, (picture * 255).round())
