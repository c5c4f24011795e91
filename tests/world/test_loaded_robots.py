"""What is said of a robot when it is loaded: overlaps, joints without limits, floating bases."""

import json
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import planning
from planning import scene_document, scene_summary
from planning.domain.scene.scene import NamedConfiguration
from planning.errors import SceneInvalid
from planning.world.documents.scene_file import parse_scene
from planning.world.world import World

LIMIT = '<limit lower="-2" upper="2" velocity="1" effort="9"/>'


def ball(name: str, radius: float, x: float = 0.0) -> str:
    shape = f'<origin xyz="{x} 0 0"/><geometry><sphere radius="{radius}"/></geometry>'
    return f'<link name="{name}"><collision>{shape}</collision></link>'


def hinge(name: str, parent: str, child: str, x: float, limit: str = LIMIT) -> str:
    return (
        f'<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{x} 0 0"/><axis xyz="0 0 1"/>{limit}</joint>'
    )


# `a` and `c` are two joints apart, on one axis: they overlap wherever the joints are. `e` is at
# `a` only while `j3` is about 0, where it reaches back along the arm.
CHAIN = "".join([
    '<robot name="m">',
    ball("a", 0.1),
    '<link name="b"/>',
    ball("c", 0.1, 0.02),
    '<link name="d"/>',
    ball("e", 0.1, -1.0),
    hinge("j1", "a", "b", 0.0),
    hinge("j2", "b", "c", 0.0),
    hinge("j3", "c", "d", 1.0),
    hinge("j4", "d", "e", 0.0),
    "</robot>",
])


def test_a_robot_that_starts_in_itself_is_told_with_an_edit_to_paste(
    urdf_world: Callable[..., World],
) -> None:
    world = urdf_world(CHAIN)
    *overlaps, offer = scene_summary(world).warnings
    found = [re.search(r"(r::\w) and (r::\w) overlap by (\S+) m: no motion", t) for t in overlaps]
    depths = {(hit[1], hit[2]): float(hit[3]) for hit in found if hit}
    assert depths == {("r::a", "r::c"): 0.18, ("r::a", "r::e"): 0.2, ("r::c", "r::e"): 0.18}
    assert offer.startswith("1 of these pairs overlap in all 21 sampled configurations")
    edit = json.loads(offer[offer.index("{") :])
    assert edit == {"operations": [{"op": "allow", "pair": ["r::a", "r::c"]}]}
    pairs = [operation["pair"] for operation in edit["operations"]]
    mended = urdf_world(CHAIN, allowed_collisions=pairs)
    assert not [text for text in scene_summary(mended).warnings if "r::a and r::c" in text]
    elsewhere = planning.edit_scene(
        mended.scene, [planning.SetPositions("r", (0.0, 0.0, 1.0, 1.0))]
    )
    assert scene_summary(planning.load_world(elsewhere)).warnings == ()


def test_a_configuration_in_which_links_overlap_is_told(urdf_world: Callable[..., World]) -> None:
    folded = {"folded": {"group": "r", "positions": [0, 0, 0, 0]}}
    free = {"open": {"group": "r", "positions": [0, 0, 1, 1]}}
    pair = [["r::a", "r::c"]]
    world = urdf_world(CHAIN, allowed_collisions=pair, configurations={**folded, **free})
    moved = planning.edit_scene(world.scene, [planning.SetPositions("r", "open")])
    (warning,) = scene_summary(planning.load_world(moved)).warnings
    assert warning == (
        "configuration 'folded' of r is in collision with itself: r::a and r::e overlap by 0.2 m"
    )


def test_what_starts_nearer_to_a_thing_than_its_margin_is_told(
    urdf_world: Callable[..., World],
) -> None:
    one = f'<robot name="m"><link name="a"/>{ball("b", 0.1)}{hinge("j", "a", "b", 0.0)}</robot>'
    near = {"name": "o", "shape": {"sphere": 0.1}, "pose": {"position": [0.21, 0, 0]}}
    assert scene_summary(urdf_world(one, objects=[near])).warnings == ()
    (margin,) = scene_summary(urdf_world(one, objects=[near], margin=0.02)).warnings
    assert "o and r::b are 0.01 m apart, less than their margin of 0.02 m" in margin
    flush = {**near, "pose": {"position": [0.2, 0, 0]}}
    (touch,) = scene_summary(urdf_world(one, objects=[flush], margin=1e-6)).warnings
    assert "o and r::b touch: no motion can start from there" in touch
    into = {**near, "pose": {"position": [0.15, 0, 0]}}
    (overlap,) = scene_summary(urdf_world(one, objects=[into])).warnings  # and no edit is offered
    assert "o and r::b overlap by 0.05 m" in overlap


def test_many_overlaps_are_counted(urdf_world: Callable[..., World]) -> None:
    links = "".join(ball(f"l{i}", 0.1) + f'<link name="k{i}"/>' for i in range(7))
    joints = "".join(hinge(f"a{i}", "k0", f"k{i}", 0.0) for i in range(1, 7))
    joints += "".join(hinge(f"b{i}", f"k{i}", f"l{i}", 0.0) for i in range(7))
    warnings = scene_summary(urdf_world(f'<robot name="m">{links}{joints}</robot>')).warnings
    assert len(warnings) == 12
    assert "11 more pairs" in warnings[10]
    assert len(json.loads(warnings[11][warnings[11].index("{") :])["operations"]) == 21


def test_of_many_robots_overlaps_are_told_and_like_configurations_once(
    urdf_world: Callable[..., World],
) -> None:
    one = urdf_world(CHAIN, allowed_collisions=[["r::a", "r::c"]]).scene
    arms = [
        replace(one.robots[0], name=f"r{i}", base=planning.Pose.from_parts((3.0 * i, 0, 0)))
        for i in range(5)
    ]
    pairs = tuple((f"r{i}::a", f"r{i}::c") for i in range(5))
    positions = {"open": (0.0, 0.0, 1.0, 1.0), "folded": (0.0, 0.0, 0.0, 0.0)}
    named = tuple(
        NamedConfiguration(name, arm.name, np.array(q))
        for arm in arms
        for name, q in positions.items()
    )
    arms = [replace(arm, positions="open" if i else "folded") for i, arm in enumerate(arms)]
    scene = replace(
        one, robots=tuple(arms), allowed_collisions=pairs, configurations=named, files={}
    )
    warnings = scene_summary(planning.load_world(scene)).warnings
    assert all(text.startswith("at the scene's positions r0::") for text in warnings)
    assert "r0::a and r0::e overlap by 0.2 m" in warnings[0]
    apart = tuple(replace(arm, positions="open") for arm in arms)
    (folded,) = scene_summary(planning.load_world(replace(scene, robots=apart))).warnings
    assert folded.startswith("configuration 'folded' of r0 is in collision with itself")


@pytest.mark.parametrize(
    ("limit", "is_told"),
    [
        (LIMIT, False),
        ("", True),
        ('<limit velocity="1" effort="9"/>', True),
        ('<limit lower="-1" velocity="1" effort="9"/>', True),
    ],
)
def test_joints_without_an_end_are_told(
    urdf_world: Callable[..., World], limit: str, is_told: bool
) -> None:
    text = '<robot name="m"><link name="a"/><link name="b"/>'
    world = urdf_world(text + hinge("j", "a", "b", 0.0, limit) + "</robot>")
    limits = world.limits(world.group("r"))
    assert np.isfinite([limits.lower[0], limits.upper[0]]).all() is np.bool_(not is_told)
    warning = "r::j has no `limit` with `lower` and `upper` and is treated as unlimited: "
    warning += "add the limits, or make it `continuous`"
    assert list(scene_summary(world).warnings) == ([warning] if is_told else [])
    endless = (text + hinge("j", "a", "b", 0.0, limit) + "</robot>").replace(
        "revolute", "continuous"
    )
    assert scene_summary(urdf_world(endless)).warnings == ()


SDF = """<sdf version="1.9"><model name="m">{}<link name="base"/><link name="a"/>
<joint name="j" type="revolute"><parent>base</parent><child>a</child>
<axis><xyz>0 0 1</xyz><limit><lower>-1</lower><upper>1</upper></limit></axis></joint></model>
</sdf>"""
MJCF = """<mujoco><worldbody><body name="base">{}<geom type="sphere" size="0.05"/>
<body name="a" pos="0 0 1"><joint name="j" type="hinge" axis="0 0 1" range="-60 60"/>
<geom type="sphere" size="0.1"/></body></body></worldbody></mujoco>"""
URDF = f'<robot name="m"><link name="base"/><link name="a"/>{hinge("j", "base", "a", 0.0)}</robot>'
PLACE = {"position": [1, 2, 3]}


@pytest.fixture
def load(tmp_path: Path) -> Callable[..., World]:
    def build(name: str, text: str, **robot: object) -> World:
        (tmp_path / name).write_text(text)
        entry = {"name": "r", "model": str(tmp_path / name), **robot}
        return planning.load_world(parse_scene({"name": "s", "robots": [entry]}))

    return build


FLOATING = [("m.sdf", SDF.format("")), ("m.xml", MJCF.format("<freejoint/>"))]


@pytest.mark.parametrize(("name", "text"), FLOATING)
def test_a_base_that_floats_is_told_and_welded_on_request(
    load: Callable[..., World], name: str, text: str
) -> None:
    world = load(name, text)
    assert world.group("r").num_positions == 8
    (warning,) = scene_summary(world).warnings
    assert warning.startswith("r: its base link 'base' has no parent joint")
    assert "`weld: true` of robot 'r'" in warning
    welded = load(name, text, weld=True, base=PLACE)
    assert welded.group("r").num_positions == 1
    assert scene_summary(welded).warnings == ()
    np.testing.assert_allclose(welded.frame_pose("r::base", welded.state).position, [1, 2, 3])
    floating = load(name, text, weld=False, base=PLACE)
    assert floating.group("r").num_positions == 8
    assert scene_summary(floating).warnings == ()
    np.testing.assert_allclose(floating.frame_pose("r::base", floating.state).position, [1, 2, 3])
    with pytest.raises(SceneInvalid, match=r"robots.0.base: .* set `weld: true`"):
        load(name, text, base=PLACE)


def test_a_urdf_is_welded_unless_the_scene_wants_it_to_float(load: Callable[..., World]) -> None:
    for weld in (None, True):
        world = load("m.urdf", URDF, weld=weld, base=PLACE)
        assert world.group("r").num_positions == 1
        np.testing.assert_allclose(world.frame_pose("r::base", world.state).position, [1, 2, 3])
    world = load("m.urdf", URDF, weld=False, base=PLACE)
    assert world.group("r").num_positions == 8
    np.testing.assert_allclose(world.frame_pose("r::base", world.state).position, [1, 2, 3])


@pytest.mark.parametrize("weld", [None, True])
def test_a_link_that_a_joint_lets_float_is_no_base(
    load: Callable[..., World], weld: bool | None
) -> None:
    world = load("m.urdf", URDF.replace("revolute", "floating"), weld=weld, base=PLACE)
    assert world.group("r").num_positions == 7
    assert scene_summary(world).warnings == ()
    np.testing.assert_allclose(world.frame_pose("r::base", world.state).position, [1, 2, 3])


def test_a_link_without_a_joint_is_told_what_helps(load: Callable[..., World]) -> None:
    two = URDF.replace('<link name="a"/>', '<link name="a"/><link name="lone"/>')
    (warning,) = scene_summary(load("m.urdf", two)).warnings
    assert warning.startswith("r: its link 'lone' has no parent joint and is not its base")
    assert "weld" not in warning


def test_what_the_description_settles_is_refused(load: Callable[..., World]) -> None:
    fixed = MJCF.format("")
    assert load("m.xml", fixed).group("r").num_positions == 1
    for setting in ({"weld": False}, {"weld": True}, {"base": PLACE}):
        with pytest.raises(
            SceneInvalid, match=f"robots.0.{next(iter(setting))}: .*already fixes it"
        ):
            load("m.xml", fixed, **setting)
    two = SDF.format('<link name="other"/>')
    assert len(scene_summary(load("m.sdf", two)).warnings) == 2
    with pytest.raises(SceneInvalid, match=r"robots.0.weld: .*2 root links"):
        load("m.sdf", two, weld=True)


def test_the_wish_survives_an_edit(load: Callable[..., World]) -> None:
    world = load("m.sdf", SDF.format(""), weld=True)
    moved = planning.edit_scene(world.scene, [planning.SetPositions("r", (0.5,))])
    assert scene_document(moved).robots[0].weld is True
    assert planning.load_world(moved).group("r").num_positions == 1
