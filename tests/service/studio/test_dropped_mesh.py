"""Files that are dropped on the page: as trimesh writes them, as people break them."""

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from service.studio.editing.dropped_mesh import MAX_BYTES, hull_of_file, name_of_file


def solids(seed):
    """A box, a ball, and something concave, somewhere, of some size."""
    rng = np.random.default_rng(seed)
    box = trimesh.creation.box(extents=rng.uniform(0.1, 2.0, 3))
    ball = trimesh.creation.icosphere(subdivisions=2, radius=rng.uniform(0.1, 2.0))
    torus = trimesh.creation.torus(1.0, 0.2)
    for mesh in (box, ball, torus):
        mesh.apply_translation(rng.normal(size=3))
        yield mesh


@pytest.mark.parametrize("kind", ["stl", "stl_ascii", "obj"])
@given(seed=st.integers(0, 2**32 - 1), unit=st.sampled_from([1.0, 0.001, 0.0254]))
def test_the_hull_is_that_of_the_solid_in_its_unit(kind, seed, unit):
    for mesh in solids(seed):
        written = mesh.export(file_type=kind)
        content = written.encode() if isinstance(written, str) else written
        corners = hull_of_file(f"part.{kind[:3].upper()}", content, unit)
        wanted = mesh.copy().apply_scale(unit).convex_hull
        found = trimesh.convex.convex_hull(corners)
        np.testing.assert_allclose(found.bounds, wanted.bounds, rtol=1e-5, atol=1e-5 * unit)
        assert found.volume == pytest.approx(wanted.volume, rel=1e-4)
        # no corner of the solid is outside: the obstacle is not smaller than what was dropped
        planes = np.einsum("fk,vfk->vf", found.face_normals, unit * mesh.vertices[:, None] -
                           found.triangles_center[None])  # fmt: skip
        assert planes.max() < 1e-5 * max(1.0, found.scale)


@given(content=st.binary(max_size=400), ending=st.sampled_from([".stl", ".obj"]))
def test_what_is_no_mesh_is_refused_in_words(content, ending):
    with pytest.raises(ValueError, match="part"):
        hull_of_file(f"part{ending}", content, 1.0)


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("a.step", b"", "none of .stl, .obj"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\n", "encloses no volume"),
        ("a.obj", b"v 0 0 0\nv 1 0\n", "three numbers"),
        ("a.obj", b"v 0 0 0\nv 1 0 nan\nv 0 1 0\nv 0 0 1\n", "not finite"),
        ("a.obj", b"v 0 0 zero\n", "cannot be read"),
        ("a.stl", b"solid\nendsolid\n", "0 corners"),
        ("a.stl", b" " * (MAX_BYTES + 1), "more than 32 MB"),
    ],
)
def test_it_says_what_is_wrong(name, content, words):
    with pytest.raises(ValueError, match=words):
        hull_of_file(name, content, 1.0)


@given(name=st.text(max_size=80))
def test_the_name_of_an_object_has_letters_that_names_may_have(name):
    found = name_of_file(f"{name}.stl")
    assert found.isascii()
    assert found.replace("_", "a").isalnum()
    assert len(found) <= 40
