"""Collision shapes that a description states are in the plant, or the description is refused."""

from collections.abc import Callable
from pathlib import Path

import pytest
import trimesh

import planning
from planning.errors import ModelInvalid
from planning.world.world import World

POINTS = "<point>0 0</point><point>1 0</point><point>0 1</point><height>1</height>"
LOST_BY_SDF = {
    "polyline": f"<polyline>{POINTS}</polyline>",
    "heightmap": "<heightmap><uri>x.png</uri><size>1 1 1</size></heightmap>",
    "cone": "<cone><radius>1</radius><length>1</length></cone>",
    "image": "<image><uri>x.png</uri></image>",
}
READ_IN_SDF = {
    "box": "<box><size>1 1 1</size></box>",
    "plane": "<plane><normal>0 0 1</normal></plane>",
    "capsule": "<capsule><radius>1</radius><length>1</length></capsule>",
    "ellipsoid": "<ellipsoid><radii>1 2 3</radii></ellipsoid>",
}
LOST_BY_MJCF = {
    "hfield": '<geom name="c" type="hfield" hfield="h"/>',
    "box fromto": '<geom name="c" type="box" fromto="0 0 0 1 0 0" size="0.1"/>',
    "ellipsoid fromto": '<geom name="c" type="ellipsoid" fromto="0 0 0 1 0 0" size="0.1 0.1 1"/>',
    "mesh": '<geom name="c" type="mesh" mesh="q"/>',
}
READ_IN_MJCF = {
    "sphere": '<geom size="0.1"/>',
    "capsule": '<geom type="capsule" fromto="0 0 0 1 0 0" size="0.1"/>',
    "cylinder": '<geom type="cylinder" fromto="0 0 0 1 0 0" size="0.1"/>',
}
SPHERE = '<geom size="0.1"/>'


def sdf(geometry: str, more: str = "") -> str:
    return f"""<sdf version="1.9"><model name="m"><link name="base"/>
<joint name="w" type="fixed"><parent>world</parent><child>base</child></joint>
<link name="a">
<collision name="ok"><geometry><sphere><radius>1</radius></sphere></geometry></collision>
<collision name="c"><geometry>{geometry}</geometry></collision></link>
<joint name="j" type="revolute"><parent>base</parent><child>a</child><axis><xyz>0 0 1</xyz>
<limit><lower>-1</lower><upper>1</upper></limit></axis></joint>{more}</model></sdf>"""


def mjcf(inside: str, before: str = "", world: str = "") -> str:
    return f"""<mujoco model="m">{before}<worldbody>{world}<body name="a">
<joint name="j" type="hinge" axis="0 0 1" range="-1 1"/>{inside}</body></worldbody></mujoco>"""


@pytest.fixture
def load(tmp_path: Path) -> Callable[[str, str], World]:
    def build(name: str, text: str) -> World:
        (tmp_path / name).write_text(text)
        robot = {"name": "r", "model": str(tmp_path / name)}
        return planning.load_world(planning.parse_scene({"name": "t", "robots": [robot]}))

    return build


def count(world: World, body: str) -> int:
    plant = world.drake.plant
    return len(plant.GetCollisionGeometriesForBody(plant.get_body(world.drake.bodies[body])))


@pytest.mark.parametrize("kind", LOST_BY_SDF)
def test_a_shape_that_sdf_loses_is_named(load: Callable[..., World], kind: str) -> None:
    with pytest.raises(ModelInvalid) as fault:
        load("m.sdf", sdf(LOST_BY_SDF[kind]))
    assert fault.value.evidence["link"] == "a"
    assert fault.value.evidence["elements"] == [f"c ({kind})"]
    assert f"c ({kind})" in fault.value.detail


@pytest.mark.parametrize("kind", READ_IN_SDF)
def test_a_shape_that_sdf_keeps_is_there(load: Callable[..., World], kind: str) -> None:
    assert count(load("m.sdf", sdf(READ_IN_SDF[kind])), "r::a") == 2


def test_an_empty_geometry_is_no_shape(load: Callable[..., World]) -> None:
    assert count(load("m.sdf", sdf("<empty/>")), "r::a") == 1


@pytest.mark.parametrize("kind", LOST_BY_MJCF)
def test_a_geom_that_mjcf_loses_is_named(load: Callable[..., World], kind: str) -> None:
    with pytest.raises(ModelInvalid) as fault:
        load("m.xml", mjcf(SPHERE + LOST_BY_MJCF[kind]))
    assert fault.value.evidence["link"] == "a"
    assert f"c ({kind})" in fault.value.evidence["elements"]


@pytest.mark.parametrize("kind", READ_IN_MJCF)
def test_a_geom_that_mjcf_keeps_is_there(load: Callable[..., World], kind: str) -> None:
    assert count(load("m.xml", mjcf(READ_IN_MJCF[kind])), "r::a") == 1


def test_what_stands_in_the_world_of_an_mjcf_counts(load: Callable[..., World]) -> None:
    assert count(load("m.xml", mjcf(SPHERE, world=SPHERE)), "world") == 1
    with pytest.raises(ModelInvalid, match="hfield") as fault:
        load("m.xml", mjcf(SPHERE, world=SPHERE + '<geom type="hfield" hfield="h"/>'))
    assert fault.value.evidence["link"] == "world"


def test_bodies_without_a_name_count(load: Callable[..., World]) -> None:
    load("m.xml", mjcf(f"{SPHERE}<body>{SPHERE}</body><body>{SPHERE}</body>"))
    with pytest.raises(ModelInvalid, match="hfield"):
        load("m.xml", mjcf(f'<body>{SPHERE}</body><body><geom type="hfield" hfield="h"/></body>'))


def test_classes_say_what_collides(load: Callable[..., World]) -> None:
    classes = """<default><geom type="sphere" size="0.1"/><default class="seen">
<geom contype="0" conaffinity="0"/><default class="high"><geom type="hfield"/></default></default>
<default class="lost"><geom type="box" fromto="0 0 0 1 0 0"/></default></default>"""
    seen = '<geom class="seen"/><geom/><body name="b" childclass="high"><geom/></body>'
    world = load("m.xml", mjcf(seen, classes))
    assert (count(world, "r::a"), count(world, "r::b")) == (1, 0)
    with pytest.raises(ModelInvalid, match="box fromto"):
        load(
            "m.xml",
            mjcf('<geom/><body name="b" childclass="lost"><geom name="g"/></body>', classes),
        )


@pytest.mark.parametrize(
    "inside",
    [
        f'<frame pos="1 0 0">{SPHERE}</frame>',
        f'<replicate count="3">{SPHERE}</replicate>',
        f'<composite type="grid" count="2 2 1">{SPHERE}</composite>',
    ],
)
def test_what_makes_geoms_is_refused(load: Callable[..., World], inside: str) -> None:
    with pytest.raises(ModelInvalid, match="is not read: write out"):
        load("m.xml", mjcf(SPHERE + inside))


def test_an_included_shape_counts(load: Callable[..., World], tmp_path: Path) -> None:
    trimesh.creation.box((1, 2, 3)).export(tmp_path / "box.obj")
    (tmp_path / "package.xml").write_text("<package><name>parts</name></package>")
    part = '<sdf version="1.9"><model name="p"><link name="p"><collision name="c"><geometry>{}'
    part += "</geometry></collision></link></model></sdf>"
    include = "<include><uri>package://parts/part.sdf</uri></include>"
    text = sdf("<mesh><uri>package://parts/box.obj</uri></mesh>", include)
    (tmp_path / "part.sdf").write_text(part.format(READ_IN_SDF["box"]))
    assert count(load("m.sdf", text), "r::p") == 1
    (tmp_path / "part.sdf").write_text(part.format(LOST_BY_SDF["cone"]))
    with pytest.raises(ModelInvalid, match="cone") as fault:
        load("m.sdf", text)
    assert fault.value.evidence["link"] == "p"


def test_an_included_geom_counts(load: Callable[..., World], tmp_path: Path) -> None:
    include = '<include file="part.xml"/>'
    (tmp_path / "part.xml").write_text(f'<mujoco><body name="p">{SPHERE}</body></mujoco>')
    assert count(load("m.xml", mjcf(SPHERE + include)), "r::p") == 1
    (tmp_path / "part.xml").write_text(
        '<mujoco><body name="p"><geom type="hfield" hfield="h"/></body></mujoco>'
    )
    with pytest.raises(ModelInvalid, match="hfield"):
        load("m.xml", mjcf(SPHERE + include))


def test_two_shapes_in_one_urdf_geometry_are_refused(urdf_world: Callable[..., World]) -> None:
    both = '<geometry><sphere radius="1"/><box size="1 1 1"/></geometry>'
    with pytest.raises(ModelInvalid, match="1 of its 2 collision shapes"):
        urdf_world(f'<robot name="r"><link name="a"><collision>{both}</collision></link></robot>')


def test_links_of_one_name_in_nested_models_are_refused(load: Callable[..., World]) -> None:
    nested = '<model name="n"><link name="a"/></model>'
    with pytest.raises(ModelInvalid, match="have the name 'a'"):
        load("m.sdf", sdf(READ_IN_SDF["box"], nested))


@pytest.mark.parametrize(
    "geom",
    [
        'type="box" size="0 1 1"',
        'type="box" size="-1 1 1"',
        'type="sphere" size="nan"',
        'type="sphere" size="0"',
        'type="sphere"',
        'type="capsule" size="-1 1"',
        'type="capsule" fromto="0 0 0 0 0 0" size="0.1"',
        'type="cylinder" size="0 1"',
    ],
)
def test_a_geom_of_no_size_is_refused(load: Callable[..., World], geom: str) -> None:
    with pytest.raises(ModelInvalid):
        load("m.xml", mjcf(f"<geom {geom}/>"))
