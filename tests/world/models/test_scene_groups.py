"""Groups that span robots: their joints, limits, configurations and names, and what is refused."""

from pathlib import Path

import numpy as np
import pytest

import planning
from planning.domain.scene.scene import NamedGroup
from planning.errors import ProblemInvalid, SceneInvalid, UnknownName
from planning.world.documents.scene_writer import scene_document
from planning.world.world import World
from tests.discs import discs

TWO = {"a": (-1.0, 0.0), "b": (0.0, -1.0)}
BOTH = """groups: {both: [a, b], turned: [b, a]}
configurations:
  met: {group: both, positions: [0.1, 0.2, 0.3, 0.4]}
  right: {group: a, positions: [1, 0]}
  odd: {group: b, positions: [2, 0]}
"""


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> World:
    return discs(tmp_path_factory.mktemp("discs"), TWO, more=BOTH)


def test_coordinates_stack_in_the_order_of_the_members(world: World) -> None:
    both, turned = world.group("both"), world.group("turned")
    assert both.position_names == ("a::x", "a::y", "b::x", "b::y")
    assert turned.position_names == ("b::x", "b::y", "a::x", "a::y")
    assert both.tool_frames == (*world.group("a").tool_frames, *world.group("b").tool_frames)
    assert world.positions(turned).tolist() == [0.0, -1.0, -1.0, 0.0]
    full = world.embed(turned, np.array([1.0, 2.0, 3.0, 4.0]))
    assert world.frame_pose("b::disc", full).position.tolist() == [1.0, 2.0, 0.0]
    assert world.frame_pose("a::disc", full).position.tolist() == [3.0, 4.0, 0.0]


def test_limits_are_those_of_the_members(world: World) -> None:
    whole, a, b = (world.limits(world.group(name)) for name in ("both", "a", "b"))
    for name in ("lower", "upper", "velocity", "acceleration", "jerk", "effort"):
        stacked = np.concatenate([getattr(a, name), getattr(b, name)])
        assert getattr(whole, name).tolist() == stacked.tolist()
    assert whole.blocks == ((0,), (1,), (2,), (3,))


def test_joined_members_are_the_group_that_the_scene_names(world: World) -> None:
    assert world.group("a::all+b::all") is world.group("both") is world.group("a+b")


def test_names_are_joined_where_the_scene_has_none(tmp_path: Path) -> None:
    world = discs(tmp_path, TWO)
    joined = world.group("a::all+b::all")
    assert joined.name == "a+b"
    assert [joint.name for joint in joined.joints] == ["a::x", "a::y", "b::x", "b::y"]
    assert world.group("a+b") is joined


def test_configurations_are_those_of_all_members_and_those_of_the_group(tmp_path: Path) -> None:
    world = discs(tmp_path, TWO, more=BOTH + "  far: {group: both, positions: [9, 9, 9, 9]}\n")
    assert set(world.configurations(world.group("both"))) == {"met", "far"}
    assert set(world.configurations(world.group("a+b"))) == {"met", "far"}
    assert set(world.configurations(world.group("turned"))) == set()
    assert world.configuration(world.group("a+b"), "met").tolist() == [0.1, 0.2, 0.3, 0.4]
    with pytest.raises(UnknownName, match="'right'"):
        world.configuration(world.group("both"), "right")


def test_a_configuration_of_every_member_is_one_of_the_group() -> None:
    scene = planning.parse_scene("""
robots:
  - {name: l, model: irb120, base: {position: [0, 0.5, 0]}}
  - {name: r, model: irb120, base: {position: [0, -0.5, 0]}}
""")
    world = planning.load_world(scene)
    whole = world.configuration(world.group("l+r"), "ready")
    one = world.configuration(world.group("l"), "ready")
    assert whole.tolist() == [*one, *one]


def test_a_configuration_may_name_a_joined_group(tmp_path: Path) -> None:
    more = "configurations: {together: {group: b+a, positions: [5, 6, 7, 8]}}\n"
    world = discs(tmp_path, TWO, more=more)
    assert world.configuration(world.group("b+a"), "together").tolist() == [5, 6, 7, 8]
    assert list(planning.scene_summary(world).groups) == ["a", "b", "b+a"]
    assert planning.scene_summary(world).groups["b+a"].members == ("b", "a")


def test_the_summary_has_the_groups_of_the_scene_after_those_of_robots(world: World) -> None:
    summary = planning.scene_summary(world)
    assert list(summary.groups) == ["a", "b", "both", "turned"]
    assert [group.members for group in summary.groups.values()] == [
        (),
        (),
        ("a", "b"),
        ("b", "a"),
    ]
    assert summary.groups["both"].positions == (-1.0, 0.0, 0.0, -1.0)
    assert [group.name for group in world.groups] == ["a", "b"]


def test_a_joint_in_two_members_is_named(world: World) -> None:
    for name in ("a+a", "both+a", "b+turned"):
        with pytest.raises(ProblemInvalid) as refusal:
            world.group(name)
        assert refusal.value.evidence["joint"] in {"a::x", "b::x"}
        assert refusal.value.evidence["joint"] in refusal.value.detail


def test_unknown_members_are_named_with_the_nearest(world: World) -> None:
    with pytest.raises(UnknownName) as refusal:
        world.group("a+bot")
    assert refusal.value.evidence["name"] == "bot"
    assert refusal.value.evidence["nearest"] == ["both"]


FAULTS = [
    ("groups: {both: [a, c]}", "groups.both.1"),
    ("groups: {both: [a, a]}", "groups.both"),
    ("groups: {both: [a, both]}", "groups.both.1"),
    ("groups: {a: [b]}", "groups.a"),
    ("groups: {both: []}", "groups.both"),
    ("configurations: {met: {group: a+c, positions: [1]}}", "configurations.met.group"),
    ("groups: {both: [a, b]}\nconfigurations: {met: {group: both, positions: [1]}}",
     "configurations.met.positions"),
]  # fmt: skip


@pytest.mark.parametrize(("more", "path"), FAULTS)
def test_faults_of_the_document_have_a_path(tmp_path: Path, more: str, path: str) -> None:
    with pytest.raises(SceneInvalid) as refusal:
        discs(tmp_path, TWO, more=more + "\n")
    assert refusal.value.evidence["path"] == path


def test_documents_keep_the_groups(world: World) -> None:
    assert world.scene.groups == (NamedGroup("both", ("a", "b")), NamedGroup("turned", ("b", "a")))
    again = scene_document(world.scene).value()
    assert again.groups == world.scene.groups
    moved = planning.edit_scene(world.scene, [planning.SetPositions("a", (0.5, 0.5))])
    assert moved.groups == world.scene.groups
    assert planning.load_world(moved).positions(world.group("both")).tolist() == [0.5, 0.5, 0, -1]


def test_only_scenes_with_groups_have_another_digest(world: World) -> None:
    bare = planning.parse_scene("robots: [{name: a, model: irb120}]")
    assert bare.digest == "50b4a85496a9644fb4707b5f83b9b2bc1cca59c9e4dc0497dc6d48c2b25a24e7"
    named = planning.parse_scene("robots: [{name: a, model: irb120}]\ngroups: {g: [a]}")
    assert named.digest != bare.digest
