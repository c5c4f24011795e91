"""`warnings` of a scene's summary say what is not what it seems."""

import logging
from collections.abc import Callable
from pathlib import Path

import pytest
import trimesh

import planning
from planning import scene_summary
from planning.world.models.model_warnings import parser_warnings
from planning.world.world import World

LINK = '<link name="a">{}</link>'
ROBOT = """<robot name="r"><link name="base"/>{}<joint name="j" type="continuous">
<parent link="base"/><child link="a"/></joint></robot>"""
MESH = '<collision><geometry><mesh filename="{}" scale="{}"/></geometry></collision>'


def el(arm: float) -> trimesh.Trimesh:
    """Return an L of two boxes of 1 x 1 x (1 + arm); its hull adds a prism of arm^2 / 2."""
    outline = [[0, 0], [1 + arm, 0], [1 + arm, 1], [1, 1], [1, 1 + arm], [0, 1 + arm]]
    vertices = [[x, y, z] for z in (0, 1) for x, y in outline]
    flat = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]]
    low = [face[::-1] for face in flat]
    high = [[i + 6 for i in face] for face in flat]
    sides = [
        triangle
        for i in range(6)
        for triangle in ([i, (i + 1) % 6, i + 6], [(i + 1) % 6, (i + 1) % 6 + 6, i + 6])
    ]
    return trimesh.Trimesh(vertices, low + high + sides, process=False)


@pytest.mark.parametrize("name", ["el.obj", "el.stl"])
@pytest.mark.parametrize("scale", ["1 1 1", "0.5 0.5 0.5", "1 2 3"])
def test_a_concave_mesh_says_how_much_larger_its_hull_is(
    urdf_world: Callable[..., World], tmp_path: Path, name: str, scale: str
) -> None:
    el(1.0).export(tmp_path / name)
    world = urdf_world(ROBOT.format(LINK.format(MESH.format(name, scale))))
    # Volume 3, hull 3.5.
    assert scene_summary(world).warnings == (
        f"r::a: its mesh '{name}' is checked as its convex hull, which is 17% larger",
    )


def test_a_convex_mesh_is_nothing_to_warn_of(
    urdf_world: Callable[..., World], tmp_path: Path
) -> None:
    trimesh.creation.box((1, 2, 3)).export(tmp_path / "box.stl")
    world = urdf_world(ROBOT.format(LINK.format(MESH.format("box.stl", "1 1 1"))))
    assert scene_summary(world).warnings == ()


def test_a_mesh_that_is_inside_out_says_that_it_is_not_sure(
    urdf_world: Callable[..., World], tmp_path: Path
) -> None:
    box = trimesh.creation.box((1, 2, 3))
    inside_out = trimesh.Trimesh(box.vertices, box.faces[:, ::-1], process=False)
    inside_out.export(tmp_path / "m.obj")
    world = urdf_world(ROBOT.format(LINK.format(MESH.format("m.obj", "1 1 1"))))
    (warning,) = scene_summary(world).warnings
    assert "its volume is not well defined" in warning


def test_a_mesh_of_an_object_counts(urdf_world: Callable[..., World], tmp_path: Path) -> None:
    el(1.0).export(tmp_path / "el.obj")
    thing = {"name": "o", "shape": {"mesh": {"uri": str(tmp_path / "el.obj")}}}
    world = urdf_world(ROBOT.format(LINK.format("")), objects=[thing])
    assert scene_summary(world).warnings == (
        "o: its mesh 'el.obj' is checked as its convex hull, which is 17% larger",
    )


def test_a_link_that_is_only_seen_is_told(urdf_world: Callable[..., World]) -> None:
    seen = '<visual><geometry><sphere radius="1"/></geometry></visual>'
    world = urdf_world(ROBOT.format(LINK.format(seen)))
    assert scene_summary(world).warnings == (
        "r::a is visible but has no collision shape: it collides with nothing",
    )
    both = seen + seen.replace("visual", "collision")
    assert scene_summary(urdf_world(ROBOT.format(LINK.format(both)))).warnings == ()


def test_what_the_parser_leaves_out_is_told(tmp_path: Path) -> None:
    (tmp_path / "m.sdf").write_text(
        """<sdf version="1.9"><model name="m"><link name="base"/><link name="a"/>
        <joint name="w" type="fixed"><parent>world</parent><child>base</child></joint>
        <joint name="j" type="continuous"><parent>base</parent><child>a</child>
        <axis><xyz>0 0 1</xyz></axis><axis2><xyz>0 1 0</xyz></axis2></joint></model></sdf>"""
    )
    robot = {"name": "r", "model": str(tmp_path / "m.sdf")}
    world = planning.load_world(planning.parse_scene({"name": "t", "robots": [robot]}))
    (warning,) = scene_summary(world).warnings
    assert warning.startswith("r: line 3: ")
    assert "axis2" in warning


def test_errors_of_the_parser_go_on_to_the_log_and_its_warnings_do_not(
    caplog: pytest.LogCaptureFixture,
) -> None:
    drake, warnings = logging.getLogger("drake"), list[str]()
    with parser_warnings("r", warnings):
        drake.warning("odd")
        drake.error("bad")
    drake.warning("not asked for")
    drake.critical("worse")
    assert warnings == ["r: odd"]
    assert [record.getMessage() for record in caplog.records] == ["bad", "worse"]
