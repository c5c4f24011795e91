"""What Drake's parser does not read of joints: references, origins, equalities."""

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import planning
from planning.errors import ModelInvalid, SceneInvalid
from planning.world.world import World

SDF = """<sdf version="1.9"><model name="m"><link name="base"/><link name="a"/><link name="b"/>
<joint name="w" type="fixed"><parent>world</parent><child>base</child></joint>
<joint name="j" type="prismatic"><parent>base</parent><child>a</child><axis><xyz>1 0 0</xyz>
<limit><lower>-1</lower><upper>1</upper></limit></axis></joint>
<joint name="k" type="prismatic"><parent>base</parent><child>b</child><axis><xyz>1 0 0</xyz>
<limit><lower>-9</lower><upper>9</upper></limit><mimic joint="j"><multiplier>2</multiplier>
<offset>0.1</offset><reference>0.5</reference></mimic></axis></joint></model></sdf>"""
MJCF = """<mujoco model="m"><compiler {compiler}/><worldbody>
<body name="a"><joint name="j" type="{kind}" axis="0 0 1" {x} range="-9 9"/><geom size="1"/></body>
<body name="b"><joint name="k" type="{kind}" axis="0 0 1" {y} range="-9 9"/><geom size="1"/></body>
</worldbody><equality>{equality}</equality></mujoco>"""
JOINT = '<joint joint1="k" joint2="j" polycoef="{}"/>'


@pytest.fixture
def load(tmp_path: Path) -> Callable[..., World]:
    def build(name: str, text: str, **more: object) -> World:
        (tmp_path / name).write_text(text)
        robot = {"name": "r", "model": str(tmp_path / name), **more}
        return planning.load_world(planning.parse_scene({"name": "t", "robots": [robot]}))

    return build


def mjcf(
    equality: str, kind: str = "slide", compiler: str = 'angle="radian"', x: str = "", y: str = ""
) -> str:
    return MJCF.format(equality=equality, kind=kind, compiler=compiler, x=x, y=y)


def follower(world: World, leader: float) -> float:
    """Return where `k` is when `j`, the only joint of the group, is at `leader`."""
    group = world.group("r")
    assert [joint.name for joint in group.joints] == ["r::j"]
    full = world.embed(group, np.array([leader]))
    joint = world.drake.plant.get_joint(world.drake.joint_indices["r::k"])
    return float(full[joint.position_start()])


@pytest.mark.parametrize("q", [-0.3, 0.0, 0.5])
def test_the_reference_of_an_sdf_mimic(load: Callable[..., World], q: float) -> None:
    assert follower(load("m.sdf", SDF), q) == pytest.approx(2 * (q - 0.5) + 0.1, abs=1e-12)


@pytest.mark.parametrize("q", [-0.3, 0.0, 0.5])
def test_an_equality_of_joints_is_a_mimic(load: Callable[..., World], q: float) -> None:
    text = mjcf(JOINT.format("0.1 2 0 0 0"), x='ref="0.5"', y='ref="-0.2"')
    assert follower(load("m.xml", text), q) == pytest.approx(-0.2 + 0.1 + 2 * (q - 0.5), abs=1e-12)


def test_references_are_in_the_files_own_angles(load: Callable[..., World]) -> None:
    text = mjcf(JOINT.format("0 1"), "hinge", 'angle="degree"', 'ref="5"', 'ref="3"')
    assert follower(load("m.xml", text), 0.0) == pytest.approx(math.radians(-2.0), abs=1e-12)


def test_an_equality_without_a_polynomial_is_one_to_one(load: Callable[..., World]) -> None:
    assert follower(load("m.xml", mjcf('<joint joint1="k" joint2="j"/>')), 0.3) == 0.3


@pytest.mark.parametrize(
    ("equality", "named"),
    [
        (JOINT.format("0 1 0.5 0 0"), "degree"),
        (JOINT.format("0.3 0 0 0 0"), "degree"),
        ('<joint joint1="k"/>', "not both"),
        ('<joint joint1="k" joint2="nope"/>', "nope"),
        ('<weld body1="a" body2="b"/>', "weld"),
        ('<connect body1="a" body2="b" anchor="0 0 0"/>', "connect"),
        (JOINT.format("0 1") * 2, "already follows"),
    ],
)
def test_an_equality_of_another_kind_is_refused(
    load: Callable[..., World], equality: str, named: str
) -> None:
    with pytest.raises(ModelInvalid, match=named):
        load("m.xml", mjcf(equality))


def test_an_equality_that_is_not_active_is_none(load: Callable[..., World]) -> None:
    world = load("m.xml", mjcf('<weld body1="a" body2="b" active="false"/>'))
    assert len(world.group("r").joints) == 2


def test_the_origin_of_a_floating_joint(urdf_world: Callable[..., World]) -> None:
    origin = '<origin xyz="1 2 3" rpy="0 0 1.5707963267948966"/>'
    world = urdf_world(
        '<robot name="r"><link name="base"/><link name="a"/><joint name="j" type="floating">'
        f'<parent link="base"/><child link="a"/>{origin}</joint></robot>'
    )
    group = world.group("r")
    at_rest = world.frame_pose("r::a", world.embed(group, np.array([1.0, 0, 0, 0, 0, 0, 0])))
    np.testing.assert_allclose(at_rest.position, [1, 2, 3], atol=1e-12)
    moved = world.frame_pose("r::a", world.embed(group, np.array([1.0, 0, 0, 0, 0.5, 0, 0])))
    np.testing.assert_allclose(moved.position, [1, 2.5, 3], atol=1e-12)  # its x is the world's y


def test_a_base_that_cannot_be_placed_is_refused(load: Callable[..., World]) -> None:
    load("m.sdf", SDF, base={"position": [0, 0, 0]})
    with pytest.raises(SceneInvalid, match=r"robots\.0\.base"):
        load("m.sdf", SDF, base={"position": [1, 0, 0]})


def test_a_joint_that_follows_what_does_not_move_is_refused(
    urdf_world: Callable[..., World],
) -> None:
    joint = '<joint name="{0}" type="{1}"><parent link="base"/><child link="{0}_link"/>{2}</joint>'
    still = joint.format("w", "fixed", "")
    follows = joint.format("j", "continuous", '<axis xyz="0 0 1"/><mimic joint="w"/>')
    links = "".join(f'<link name="{name}"/>' for name in ("base", "w_link", "j_link"))
    with pytest.raises(ModelInvalid):
        urdf_world(f'<robot name="r">{links}{still}{follows}</robot>')
