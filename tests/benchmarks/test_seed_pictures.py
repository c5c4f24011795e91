"""Pictures of the seeds: solids where they are, near ones before far ones, small files."""

import struct
import zlib
from pathlib import Path

import numpy as np
import pytest
from pydrake import geometry

from benchmarks.seed_pictures import VIEWS, draw
from benchmarks.seed_scenes.canvas import Canvas
from benchmarks.seed_scenes.meshes import triangles
from benchmarks.seed_scenes.seeds import SEEDS
from tests.clocks import no_hurry
from tests.conftest import bundled_world

IMAGES = Path(__file__).parents[2] / "docs" / "images"
RED, BLUE = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])


def pixels(png: bytes) -> np.ndarray:
    """Decode what `Canvas.png` writes, shape (rows, columns, 3)."""
    assert png.startswith(b"\x89PNG\r\n\x1a\n")
    width, height = struct.unpack(">II", png[16:24])
    begin = png.index(b"IDAT")
    (length,) = struct.unpack(">I", png[begin - 4 : begin])
    raw = zlib.decompress(png[begin + 4 : begin + 4 + length])
    return np.frombuffer(raw, np.uint8).reshape(height, -1)[:, 1:].reshape(height, width, 3)


@pytest.mark.parametrize(
    ("shape", "volume"),
    [
        (geometry.Box(0.1, 0.2, 0.3), 0.006),
        (geometry.Cylinder(0.1, 0.3), np.pi * 0.01 * 0.3),
        (geometry.Sphere(0.1), 4 / 3 * np.pi * 1e-3),
        (geometry.Ellipsoid(0.1, 0.2, 0.3), 4 / 3 * np.pi * 6e-3),
        (geometry.Capsule(0.1, 0.3), np.pi * 0.01 * 0.3 + 4 / 3 * np.pi * 1e-3),
    ],
)
def test_triangles_enclose_the_shape_and_face_outwards(shape, volume) -> None:
    corners = triangles(shape)
    signed = np.einsum("ni,ni->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    assert signed == pytest.approx(volume, rel=0.06)
    assert signed <= volume * (1 + 1e-9)


def test_near_things_hide_far_ones_in_any_order() -> None:
    box = triangles(geometry.Box(0.2, 0.2, 0.2))
    for first_is_near in (True, False):
        canvas = Canvas(np.array([0.0, 0.0, 1.0]), np.zeros(3), 1.0, (50, 50))
        near, far = (box + np.eye(3)[2], RED), (box + 0.1 * np.eye(3)[0], BLUE)
        for mesh, color in (near, far) if first_is_near else (far, near):
            canvas.draw(mesh, color)
        image = pixels(canvas.png())
        assert image[25, 25, 0] > 100 > image[25, 25, 2]
        assert image[25, 33, 2] > 100 > image[25, 33, 0]
        assert (image[2, 2] == 255).all()


def test_a_seed_is_drawn_in_a_small_file() -> None:
    seed = next(seed for seed in SEEDS if seed.name == "window_3d")
    deadline = no_hurry(60.0)
    png = draw(seed.run(bundled_world("window_3d"), 0, deadline), VIEWS["window_3d"])
    image = pixels(png)
    assert len(np.unique(image.reshape(-1, 3), axis=0)) > 20
    assert len(png) < 100_000


def test_every_view_has_its_picture_in_the_guide() -> None:
    guide = "".join(page.read_text() for page in IMAGES.parent.rglob("*.md"))
    for name in VIEWS:
        picture = IMAGES / f"{name}.png"
        assert f"images/{name}.png" in guide
        assert 2_000 < len(picture.read_bytes()) < 100_000
