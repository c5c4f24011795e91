"""Replays of several motions: what is held moves along, what comes and goes is told and named."""

import numpy as np
import pytest

from planning import DetachObject, SetPositions, edit_scene, read_scene
from planning.domain.curves.curve import JointSpline, TimedTrajectory
from planning.domain.geometry.pose import Pose
from planning.domain.geometry.shapes import Box
from planning.domain.scene.scene import SceneObject
from planning.domain.scene.scene_operation import AddObject, AttachObject, RemoveObject
from planning.world.documents.scene_file import parse_scene
from planning.world.loading.load_world import load_world
from planning.world.models.model_library import bundled_folder
from planning.world.replay.replay_writer import ShownMotion, replay_html, replay_motions_html
from planning.world.world import World
from tests.world.meshcat_messages import animation, messages, overlay, tracks

PICKUP = read_scene(bundled_folder("scenes") / "ur5e_pickup.scene.yaml")
GRASP = AttachObject("can", "arm::tcp", pose=Pose.from_parts((0.0, 0.0, 0.01)))
FRAMES = 6  # of each motion: a second at 5 a second


def motion(world: World, by: float) -> TimedTrajectory:
    group = world.groups[0]
    start = world.positions(group)
    line = JointSpline.through(group.joints, np.array([start, start + by]))
    return TimedTrajectory(line.joints, line.breaks, line.bases, line.coefficients)


def shown(scene, title: str, by: float) -> tuple[ShownMotion, tuple[float, ...]]:
    """Return a motion in a scene, and where it ends."""
    world = load_world(scene, kernel=False)
    trajectory = motion(world, by)
    group = world.groups[0]
    return ShownMotion(title, world, group, trajectory), tuple(map(float, trajectory.end))


@pytest.fixture(scope="module")
def fetched() -> str:
    """A page: the arm moves, grasps and carries the can, leaves it and moves on without the box."""
    first, end = shown(PICKUP, "approach", 0.1)
    held = edit_scene(PICKUP, [SetPositions("arm", end), GRASP])
    second, end = shown(held, "carry", 0.2)
    left = edit_scene(held, [SetPositions("arm", end), DetachObject("can"), RemoveObject("box")])
    third, _ = shown(left, "leave", -0.1)
    return replay_motions_html([first, second, third], frames_per_second=5.0)


def test_the_can_follows_the_gripper_while_it_is_held_and_only_then(fetched: str) -> None:
    moved = tracks(fetched)
    can, hand = moved["/bodies/can"], moved["/bodies/arm/hand_base"]
    assert len(can) == len(hand) == 3 * FRAMES
    free, held, left = (slice(k * FRAMES, (k + 1) * FRAMES) for k in range(3))
    for still in (free, left):
        np.testing.assert_allclose(can[still], np.broadcast_to(can[still][0], (6, 4, 4)))
        assert np.abs(hand[still] - hand[still][0]).max() > 0.01
    grasps = np.linalg.inv(hand[held]) @ can[held]
    np.testing.assert_allclose(grasps, np.broadcast_to(grasps[0], grasps.shape), atol=1e-5)
    assert np.abs(can[held] - can[held][0]).max() > 0.05
    np.testing.assert_allclose(can[left][0], can[held][-1], atol=1e-6)


def test_frames_on_what_moves_move_along(fetched: str) -> None:
    moved = tracks(fetched)
    offsets = np.linalg.inv(moved["/bodies/can"]) @ moved["/frames/pick"]
    np.testing.assert_allclose(offsets, np.broadcast_to(offsets[0], offsets.shape), atol=1e-5)


def test_what_is_removed_is_hidden_from_then_on(fetched: str) -> None:
    (entry,) = [e for e in animation(fetched)["animations"] if e["path"] == "/bodies/box"]
    (seen,) = [t["keys"] for t in entry["clip"]["tracks"] if t["name"] == ".visible"]
    assert [(key["time"], key["value"]) for key in seen] == [
        (0, True), (FRAMES, True), (2 * FRAMES, False),
    ]  # fmt: skip


def test_what_is_added_later_is_drawn() -> None:
    thing = SceneObject("new", Box(np.array([0.1, 0.1, 0.1])), Pose.from_parts((0.0, 0.6, 0.1)))
    first, _ = shown(PICKUP, "before", 0.1)
    second, _ = shown(edit_scene(PICKUP, [AddObject(thing)]), "after", 0.1)
    page = replay_motions_html([first, second], frames_per_second=2.0)
    assert "/bodies/new/0" in {m["path"] for m in messages(page) if m["type"] == "set_object"}
    (entry,) = [e for e in animation(page)["animations"] if e["path"] == "/bodies/new"]
    (seen,) = [t["keys"] for t in entry["clip"]["tracks"] if t["name"] == ".visible"]
    assert [key["value"] for key in seen] == [False, True]


def test_it_plays_by_itself_for_ever(fetched: str) -> None:
    options = animation(fetched)["options"]
    assert options["play"] is True
    assert options["loopMode"] == 2201
    assert options["repetitions"] > 1e5


def test_it_says_what_goes_on_and_names_what_is_there(fetched: str) -> None:
    content = overlay(fetched)
    assert content["title"] == PICKUP.name
    assert "<title>ur5e_pickup</title>" in fetched
    sections = [(section["title"], round(5 * section["end"])) for section in content["sections"]]
    assert sections == [("approach", FRAMES), ("carry", 2 * FRAMES), ("leave", 3 * FRAMES)]
    named = {(label["path"], label["text"]): label["kind"] for label in content["labels"]}
    assert named["/bodies/can/0", "can"] == named["/bodies/arm/base_link/0", "arm"] == "thing"
    assert named["/frames/pick", "pick"] == "frame"
    assert named["/bodies/arm/forearm_link/0", "forearm_link"] == "link"
    drawn = {message["path"] for message in messages(fetched) if message["type"] == "set_object"}
    for path, _ in named:
        assert any(known.startswith(path) for known in drawn), path


def test_no_name_ends_the_script_that_it_is_in() -> None:
    first, _ = shown(PICKUP, "</script><script>alert(1)</script>", 0.1)
    page = replay_motions_html([first], frames_per_second=2.0)
    assert "<script>alert" not in page
    assert overlay(page)["sections"][0]["title"] == first.title


def test_a_motion_that_was_stopped_is_shown_as_far_as_it_went() -> None:
    whole, _ = shown(PICKUP, "stopped", 0.1)
    stopped = ShownMotion(whole.title, whole.world, whole.group, whole.trajectory, until=0.5)
    ends = [
        tracks(replay_motions_html([one], frames_per_second=5.0))["/bodies/arm/hand_base"][-1]
        for one in (whole, stopped)
    ]
    at = whole.world.embed(whole.group, whole.trajectory.positions(np.array([1.0, 0.5])))
    for pose, state in zip(ends, at, strict=True):
        expected = whole.world.frame_pose("arm::hand_base", state).matrix
        np.testing.assert_allclose(pose, expected, atol=1e-6)


BARE = """
<robot name="bare">
  <material name="red"><color rgba="1 0 0 1"/></material>
  <link name="base"><collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision></link>
  <link name="one">
    <collision><origin xyz="0.4 0 0"/><geometry><box size="0.4 0.1 0.1"/></geometry></collision>
  </link>
  <link name="two">
    <visual><origin xyz="0.4 0 0"/><geometry><box size="0.4 0.1 0.1"/></geometry></visual>
    <collision><origin xyz="0.4 0 0"/><geometry><sphere radius="0.5"/></geometry></collision>
  </link>
  <link name="three">
    <visual><geometry><sphere radius="0.05"/></geometry><material name="red"/></visual>
  </link>
  <joint name="a" type="revolute"><parent link="base"/><child link="one"/><axis xyz="0 0 1"/>
    <limit lower="-2" upper="2" velocity="1" effort="9"/></joint>
  <joint name="b" type="revolute"><parent link="one"/><child link="two"/><axis xyz="0 0 1"/>
    <origin xyz="1.2 0 0"/><limit lower="-2" upper="2" velocity="1" effort="9"/></joint>
  <joint name="c" type="fixed"><parent link="two"/><child link="three"/></joint>
</robot>
"""


def test_links_without_visuals_are_drawn_and_each_has_a_colour(tmp_path) -> None:
    (tmp_path / "bare.urdf").write_text(BARE)
    document = {"name": "s", "robots": [{"name": "r", "model": str(tmp_path / "bare.urdf")}]}
    world = load_world(parse_scene(document), kernel=False)
    page = replay_html(world, world.groups[0], motion(world, 0.3), frames_per_second=2.0)
    drawn = {m["path"]: m["object"] for m in messages(page) if m["type"] == "set_object"}
    shapes = {
        link: [
            o["geometries"][0]["type"]
            for p, o in drawn.items()
            if p.startswith(f"/bodies/r/{link}/")
        ]
        for link in ("base", "one", "two", "three")
    }
    box, sphere = ["BoxGeometry"], ["SphereGeometry"]
    assert shapes == {"base": box, "one": box, "two": box, "three": sphere}
    colors = [drawn[f"/bodies/r/{link}/0"]["materials"][0]["color"] for link in shapes]
    assert len(set(colors)) == 4
    assert colors[3] == 0xFF0000
