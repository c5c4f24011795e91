"""Scene documents: what is wrong, where, on which line."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import planning
from planning.domain.geometry.shapes import Capsule, Convex, Cylinder, HalfSpace, Mesh, Sphere
from planning.errors import AssetNotFound, SceneInvalid
from planning.world.documents.scene_file import parse_scene, read_scene, with_line

HEAD = "robots:\n  - {name: arm, model: ur5e}\n"

FAULTS = [
    ("robot: []\n", 1, "robots"),
    (HEAD + "version: 2\n", 3, "version"),
    (HEAD + "obstacles: []\n", 3, "obstacles"),
    (HEAD + "objects:\n  - name: a\n    shape: {box: [1, 0, 1]}\n", 5, "objects.0.shape.box.1"),
    (HEAD + "objects:\n  - name: a\n    shape: {sphere: -0.1}\n", 5, "objects.0.shape.sphere"),
    (
        HEAD + "objects:\n  - name: a\n    shape: {sphere: 1, box: [1, 1, 1]}\n",
        5,
        "objects.0.shape",
    ),
    (HEAD + "objects:\n  - name: a\n    shape: {pyramid: 1}\n", 5, "objects.0.shape.pyramid"),
    (
        HEAD + "frames:\n  - {name: f, pose: {position: [0, .nan, 0]}}\n",
        4,
        "frames.0.pose.position.1",
    ),
    (HEAD + "frames:\n  - {name: f, pose: {quaternion: [0, 0, 0, 0]}}\n", 4, "frames.0.pose"),
    (HEAD + "margin: -0.1\n", 3, "margin"),
    (HEAD + "margin: '0.1'\n", 3, "margin"),
    (HEAD + "margin: 0.1\nmargin: 0.2\n", 4, ""),
    (HEAD + "objects: [\n", 4, ""),
    ("x: &a [1]\ny: *a\n" + HEAD, 2, ""),
    ("[" * 1000, 1, ""),
    ("- 1\n- 2\n", 1, ""),
    ("", 1, ""),
    ("\x00\x01", None, ""),
]


@pytest.mark.parametrize(("text", "line", "path"), FAULTS)
def test_faults_are_named_with_their_line(text: str, line: int | None, path: str) -> None:
    with pytest.raises(SceneInvalid) as refusal:
        parse_scene(text, "my.scene.yaml")
    assert refusal.value.evidence["line"] == line
    assert refusal.value.evidence["path"] == path
    assert "my.scene.yaml" in refusal.value.detail
    if line and path:
        assert f"line {line}" in refusal.value.detail
    json.dumps(refusal.value.evidence)


def test_shapes_of_every_kind_are_read() -> None:
    shapes = [
        "{sphere: 0.1}",
        "{cylinder: {radius: 0.1, length: 0.2}}",
        "{capsule: {radius: 0.1, length: 0.2}}",
        "{half_space: {}}",
        "{mesh: {uri: part.obj, scale: 2}}",
        "{convex: {points: [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]}}",
    ]
    lines = "".join(f"  - {{name: o{i}, shape: {s}}}\n" for i, s in enumerate(shapes))
    scene = parse_scene(HEAD + "objects:\n" + lines)
    kinds = [type(thing.shape) for thing in scene.objects]
    assert kinds == [Sphere, Cylinder, Capsule, HalfSpace, Mesh, Convex]
    mesh = scene.objects[4].shape
    assert isinstance(mesh, Mesh)
    assert np.array_equal(mesh.scale, [2, 2, 2])


@pytest.mark.parametrize("name", ["ur5e_pickup", "panda_shelf", "maze_2d", "window_3d", "two_arms"])
def test_json_and_yaml_are_the_same_scene(name: str) -> None:
    import yaml

    text = (planning.bundled_folder("scenes") / f"{name}.scene.yaml").read_text()
    as_json = json.dumps(yaml.safe_load(text))
    assert parse_scene(as_json) == parse_scene(text)
    assert parse_scene(as_json).digest == parse_scene(yaml.safe_load(text)).digest


@given(st.text(max_size=300))
def test_no_text_breaks_the_reader(text: str) -> None:
    with pytest.raises(SceneInvalid):
        parse_scene(text)


@pytest.mark.parametrize(
    ("tail", "line"),
    [
        ("frames:\n  - name: f\n    parent: tabel\n", 5),
        ("allowed_collisions:\n  - [arm::tool0, world]\n  - [arm::tool9, world]\n", 5),
        ("configurations:\n  c: {group: leg, positions: [1]}\n", 4),
    ],
)
def test_faults_that_only_loading_shows_get_their_line_too(tail: str, line: int) -> None:
    text = HEAD + tail
    with pytest.raises(SceneInvalid) as refusal:
        planning.load_world(parse_scene(text))
    found = with_line(refusal.value, text)
    assert found.evidence["line"] == line
    assert found.detail.startswith(f"line {line}: ")


def test_ten_megabytes_of_nonsense_are_refused_at_once() -> None:
    with pytest.raises(SceneInvalid, match="at most"):
        parse_scene("a: [" + "1, " * 3_400_000)


def test_a_missing_file_is_said_to_be_missing(tmp_path: Path) -> None:
    with pytest.raises(AssetNotFound, match=r"no\.scene\.yaml"):
        read_scene(tmp_path / "no.scene.yaml")
