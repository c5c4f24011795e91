"""What the SRDF beside a URDF says: groups, named configurations, end effectors."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import planning
from planning import scene_summary
from planning.world.collision.unchecked_pairs import unchecked_pairs
from planning.world.documents.scene_file import parse_scene
from planning.world.world import World


def joint(name: str, parent: str, child: str, kind: str = "revolute", more: str = "") -> str:
    limit = "" if kind == "fixed" else '<limit lower="-2" upper="2" velocity="1" effort="9"/>'
    side = {"left": 0.2, "right": -0.2}.get(child, 0.0)
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="0 {side} 0.4"/><axis xyz="0 1 0"/>{limit}{more}</joint>'
    )


def link(name: str) -> str:
    shape = '<origin xyz="0 0 0.2"/><geometry><box size="0.05 0.05 0.2"/></geometry>'
    return f'<link name="{name}"><collision>{shape}</collision></link>'


ARM = "".join([
    '<robot name="m">',
    *(link(name) for name in ("base", "l1", "l2", "palm", "left", "right")),
    '<link name="flange"/>',
    joint("j1", "base", "l1"),
    joint("j2", "l1", "l2"),
    joint("mount", "l2", "flange", "fixed"),
    joint("glue", "flange", "palm", "fixed"),
    joint("f1", "palm", "left", "prismatic"),
    joint("f2", "palm", "right", "prismatic", '<mimic joint="f1"/>'),
    "</robot>",
])
HAND = '<group name="hand"><link name="palm"/><link name="left"/><link name="right"/></group>'
CHAIN = '<group name="arm"><chain base_link="base" tip_link="l2"/></group>'
EFFECTOR = '<end_effector name="grip" parent_link="flange" group="hand"{}/>'
HOME = '<group_state name="home" group="arm">{}</group_state>'
SAID = '<joint name="j2" value="-1.5"/><joint name="j1" value="0.5"/>'


@pytest.fixture
def load(tmp_path: Path) -> Callable[..., World]:
    def build(*srdf: str, **robot: object) -> World:
        (tmp_path / "m.urdf").write_text(ARM)
        (tmp_path / "m.srdf").write_text(f'<robot name="m">{"".join(srdf)}</robot>')
        entry = {"name": "r", "model": str(tmp_path / "m.urdf"), **robot}
        return planning.load_world(parse_scene({"name": "s", "robots": [entry]}))

    return build


def test_group_states_are_configurations_to_start_from_and_to_go_to(
    load: Callable[..., World],
) -> None:
    folded = '<group_state name="open" group="hand"><joint name="f1" value="0.3"/></group_state>'
    world = load(CHAIN, HAND, HOME.format(SAID), folded)
    arm, hand = world.group("r"), world.group("r::hand")
    assert [joint.name for joint in arm.joints] == ["r::j1", "r::j2"]
    # in the group's order, whatever the state's; and a robot starts at `home`
    np.testing.assert_array_equal(world.configuration(arm, "home"), [0.5, -1.5])
    np.testing.assert_array_equal(world.positions(arm), [0.5, -1.5])
    np.testing.assert_array_equal(world.configuration(hand, "open"), [0.3])
    opened = load(CHAIN, HAND, HOME.format(SAID), folded, positions="open")
    np.testing.assert_array_equal(opened.positions(hand), [0.3])
    assert scene_summary(world).groups["r"].configurations == {"home": (0.5, -1.5)}


@pytest.mark.parametrize("of", ["", ' parent_group="arm"'])
def test_end_effectors_are_tool_frames_of_what_carries_them(
    load: Callable[..., World], of: str
) -> None:
    by_name = '<group name="arm"><joint name="j1"/><joint name="j2"/></group>'
    # the hand comes first in the file, and is not what the bare name stands for all the same
    world = load(HAND, by_name, EFFECTOR.format(of))
    assert world.group("r").tool_frames == ("r::flange",)
    assert [joint.name for joint in world.group("r").joints] == ["r::j1", "r::j2"]
    assert [joint.name for joint in world.group("r::hand").joints] == ["r::f1"]
    chained = load(HAND, CHAIN, EFFECTOR.format(of))
    assert chained.group("r").tool_frames == ("r::l2", "r::flange")


def test_groups_are_made_of_groups(load: Callable[..., World]) -> None:
    whole = (
        '<group name="whole"><group name="arm"/><group name="hand"/><group name="whole"/></group>'
    )
    world = load(whole, CHAIN, HAND)
    assert [joint.name for joint in world.group("r::whole").joints] == ["r::j1", "r::j2", "r::f1"]
    assert world.group("r").name == world.group("r::arm").name == "r"


def test_an_end_effector_may_touch_what_it_holds(
    tmp_path: Path, load: Callable[..., World]
) -> None:
    load(CHAIN, HAND, EFFECTOR.format(""))  # writes the files
    thing = {"name": "o", "shape": {"sphere": 0.1}, "attached": {"frame": "r::flange"}}
    robot = {"name": "r", "model": str(tmp_path / "m.urdf")}
    world = planning.load_world(parse_scene({"name": "s", "robots": [robot], "objects": [thing]}))
    held = {
        b for pair in unchecked_pairs(world.drake) if pair.reason == "held" for b in pair.bodies
    }
    assert held >= {"r::left", "r::right", "r::palm", "o"}
    assert "r::l1" not in held


@pytest.mark.parametrize(
    ("state", "word"),
    [
        (HOME.format('<joint name="j1" value="0.5"/>'), "has no value for joint 'j2'"),
        (HOME.format(SAID.replace("0.5", "half")), "needs 1 finite number, got 'half'"),
        (HOME.format(SAID.replace("0.5", "nan")), "needs 1 finite number, got 'nan'"),
        (HOME.format(SAID.replace("0.5", "0.5 1")), "got '0.5 1'"),
        (HOME.format(SAID).replace('"arm"', '"leg"'), "no such group"),
    ],
)
def test_a_group_state_that_cannot_be_read_is_told(
    load: Callable[..., World], state: str, word: str
) -> None:
    world = load(CHAIN, state)
    assert world.configurations(world.group("r")) == {}
    (warning,) = scene_summary(world).warnings
    assert warning.startswith("r: group state 'home' of")
    assert word in warning


def test_a_configuration_beyond_the_limits_is_told(load: Callable[..., World]) -> None:
    world = load(CHAIN, HOME.format(SAID.replace("0.5", "2.5")), positions=[0, 0])
    (warning,) = scene_summary(world).warnings
    assert warning == (
        "configuration 'home' of r lies outside its limits: r::j1 at 2.5, limits [-2, 2]"
    )


def test_a_virtual_joint_that_moves_is_told(load: Callable[..., World]) -> None:
    planar = '<virtual_joint name="v" type="planar" parent_frame="odom" child_link="base"/>'
    (warning,) = scene_summary(load(CHAIN, planar)).warnings
    assert "virtual joint 'v'" in warning
    assert scene_summary(load(CHAIN, planar.replace("planar", "fixed"))).warnings == ()


def warned(load: Callable[..., World], *srdf: str) -> list[str]:
    return list(scene_summary(load(*srdf)).warnings)


def test_a_sound_srdf_is_read_without_a_word(load: Callable[..., World]) -> None:
    pair = '<disable_collisions link1="left" link2="right" reason="Never"/>'
    passive = '<passive_joint name="f2"/>'  # it follows another
    assert warned(load, CHAIN, HAND, EFFECTOR.format(""), HOME.format(SAID), pair, passive) == []


ARM_IS_OUT = "r: group 'arm' in m.srdf is left out: no joint of it moves by itself"


def chain(base: str, tip: str) -> str:
    return f'<group name="arm"><chain base_link="{base}" tip_link="{tip}"/></group>'


@pytest.mark.parametrize(
    ("group", "fault"),
    [
        (chain("base", "l22"), "tip_link 'l22' does not exist; did you mean 'l2'?"),
        (chain("basis", "l2"), "base_link 'basis' does not exist; did you mean 'base'?"),
        (chain("l2", "base"), "it is reversed: exchange base_link 'l2' and tip_link 'base'"),
        (chain("palm", "l1"), "it is reversed: exchange base_link 'palm' and tip_link 'l1'"),
        (
            chain("left", "right"),
            (
                "base_link 'left' is not above tip_link 'right'; links above: "
                "['palm', 'flange', 'l2', 'l1', 'base']"
            ),
        ),
    ],
)
def test_a_chain_that_is_none_is_told(load: Callable[..., World], group: str, fault: str) -> None:
    told = warned(load, group)
    assert told == [f"r: group 'arm' in m.srdf: a chain is left out: {fault}", ARM_IS_OUT]
    assert [joint.name for joint in load(group).group("r").joints] == ["r::j1", "r::j2", "r::f1"]


def test_a_chain_may_begin_at_the_frame_that_holds_the_robot(load: Callable[..., World]) -> None:
    fixed = '<virtual_joint name="v" type="fixed" parent_frame="world" child_link="base"/>'
    world = load(fixed, chain("world", "l2"))
    assert [joint.name for joint in world.group("r").joints] == ["r::j1", "r::j2"]
    assert scene_summary(world).warnings == ()


STATE = HOME.format(SAID)
MEMBERS = '<group name="arm"><joint name="j1"/><joint name="j2"/>{}</group>'


@pytest.mark.parametrize(
    ("srdf", "told"),
    [
        (
            MEMBERS.format('<joint name="jj2"/>'),
            "group 'arm' in m.srdf: joint 'jj2' does not exist; did you mean 'j2'?",
        ),
        (
            MEMBERS.format('<link name="palme"/>'),
            "group 'arm' in m.srdf: link 'palme' does not exist; did you mean 'palm'?",
        ),
        (
            MEMBERS.format('<group name="arn"/>'),
            "group 'arm' in m.srdf: group 'arn' does not exist; did you mean 'arm'?",
        ),
        (CHAIN + CHAIN, "group 'arm' in m.srdf is given 2 times: the last one is read"),
        (
            CHAIN + HAND + EFFECTOR.format("").replace("flange", "flannge"),
            (
                "end effector 'grip' in m.srdf: parent_link: link 'flannge' does not exist; did "
                "you mean 'flange'?"
            ),
        ),
        (
            CHAIN + HAND + EFFECTOR.format("").replace('group="hand"', 'group="hnd"'),
            (
                "end effector 'grip' in m.srdf: group: group 'hnd' does not exist; did you mean "
                "'hand'?"
            ),
        ),
        (
            CHAIN + HAND + EFFECTOR.format(' parent_group="arms"'),
            (
                "end effector 'grip' in m.srdf: parent_group: group 'arms' does not exist; did you "
                "mean 'arm'?"
            ),
        ),
        (
            CHAIN + '<disable_collisions link1="l1" link2="palms"/>' * 2,
            (
                "disable_collisions in m.srdf: 2 pairs are ignored: link 'palms' does not exist; "
                "did you mean 'palm'?"
            ),
        ),
        (
            CHAIN + HOME.format(SAID + '<joint name="j3" value="0"/>'),
            (
                "group state 'home' in m.srdf: a value is ignored: in group 'arm' joint 'j3' does "
                "not exist; there are ['j1', 'j2']"
            ),
        ),
        (
            CHAIN + STATE + STATE,
            "group state 'home' of 'arm' in m.srdf is given 2 times: the last one is read",
        ),
        (
            CHAIN + '<passive_joint name="j1"/>',
            "passive joint 'j1' in m.srdf is not read: it is planned for like the others",
        ),
        (
            CHAIN + '<passive_joint name="j9"/>',
            (
                "passive_joint in m.srdf: joint 'j9' does not exist; there are "
                "['j1', 'j2', 'mount', 'glue', 'f1', 'f2']"
            ),
        ),
        (
            CHAIN + '<enable_collisions link1="l1" link2="palm"/>',
            "<enable_collisions> in m.srdf is not read (1 of them)",
        ),
    ],
)
def test_what_is_not_read_is_told_with_what_was_meant(
    load: Callable[..., World], srdf: str, told: str
) -> None:
    assert warned(load, srdf) == [f"r: {told}"]


def test_of_the_srdf_of_another_robot_not_every_fault_is_told(load: Callable[..., World]) -> None:
    foreign = "".join(f'<disable_collisions link1="l1" link2="x{i}"/>' for i in range(500))
    warnings = warned(load, CHAIN, foreign)
    assert len(warnings) == 21
    assert warnings[-1] == "r: 480 more parts of m.srdf are not read"
