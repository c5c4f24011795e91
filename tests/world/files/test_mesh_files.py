"""Converted meshes lie with the copies of a library, by content, and not more than there may be."""

import os
from pathlib import Path

import pytest
import trimesh

import planning
from planning.world.files import mesh_files
from planning.world.models.model_library import ModelLibrary

URDF = """<robot name="r"><link name="base"><collision><geometry><mesh filename="{mesh}"/>
</geometry></collision></link><link name="a"/><joint name="j" type="prismatic">
<parent link="base"/><child link="a"/><axis xyz="1 0 0"/>
<limit lower="-1" upper="1" velocity="1" effort="1"/></joint></robot>"""


def load(folder: Path, size: float, library: ModelLibrary) -> Path:
    """Load a robot of one box in STL, and return the mesh that was made of it."""
    trimesh.creation.box((size, size, size)).export(folder / "b.stl")
    (folder / "r.urdf").write_text(URDF.format(mesh="b.stl"))
    robot = {"name": "r", "model": str(folder / "r.urdf")}
    planning.load_world(planning.parse_scene({"name": "s", "robots": [robot]}), library)
    assert library.copies is not None
    made = sorted((library.copies / "meshes").rglob("*.obj"), key=lambda file: file.stat().st_mtime)
    return made[-1]


@pytest.fixture
def library(tmp_path: Path) -> ModelLibrary:
    return ModelLibrary.bundled(copies=tmp_path / "copies")


def test_converted_meshes_lie_with_the_copies(
    tmp_path: Path, library: ModelLibrary, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    assert load(tmp_path, 1.0, library).is_relative_to(tmp_path / "copies" / "meshes")
    assert not list((tmp_path / "cache").rglob("*.stl.obj"))


def test_those_that_were_not_used_for_longest_make_room(
    tmp_path: Path, library: ModelLibrary, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(mesh_files, "_MAX_BYTES", 1)
    old = load(tmp_path, 1.0, library)
    young = load(tmp_path, 2.0, library)
    assert old.exists()  # a loaded world may read it again
    os.utime(old, (0, 0))
    load(tmp_path, 3.0, library)
    assert not old.exists()
    assert young.exists()
    assert load(tmp_path, 1.0, library) == old
