"""What a robot holds is a body of it: it moves, collides, keeps margins, and reaches goals."""

import base64
import re
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import planning
from planning import AttachObject, MoveObject, Pose, SetPositions, edit_scene, scene_summary
from planning.domain.curves.curve import JointSpline, TimedTrajectory
from planning.domain.scene.scene import Attachment, Scene
from planning.errors import SceneInvalid
from tests.clocks import no_hurry

PICKUP = planning.read_scene(planning.bundled_folder("scenes") / "ur5e_pickup.scene.yaml")
GRASP = AttachObject(
    "can", "arm::tcp", pose=Pose.from_parts((0.0, 0.0, 0.01), rpy=(np.pi, 0.0, 0.0))
)
HELD = edit_scene(PICKUP, [GRASP])
WORLD = planning.load_world(HELD)
ARM = WORLD.group("arm")


@cache
def held_world(kernel: bool) -> planning.World:
    return planning.load_world(HELD, kernel=kernel)


def violating(world: planning.World, q: np.ndarray, margin: float) -> list[set[str]]:
    probe = world.distance_probe(world.margins(margin))
    return [{b for p in probe.violations(row) for b in p.bodies} for row in world.embed(ARM, q)]


@pytest.mark.parametrize("kernel", [True, False])
@pytest.mark.parametrize("margin", [0.0, 0.02])
def test_the_fast_judge_and_the_slow_one_agree_on_what_is_held(kernel, margin) -> None:
    world = held_world(kernel)
    q = np.random.default_rng(1).uniform(-2.5, 2.5, (200, 6))
    found = violating(world, q, margin)
    assert any("can" in bodies for bodies in found)
    free = world.collision_oracle(ARM, world.margins(margin)).are_free(q)
    np.testing.assert_array_equal(free, [not bodies for bodies in found])


def test_no_margin_is_owed_to_the_robot_that_holds_but_no_collision_either() -> None:
    q = np.random.default_rng(2).uniform(-2.5, 2.5, (100, 6))
    probe = WORLD.distance_probe(WORLD.margins(0.1))
    pairs = [p for row in WORLD.embed(ARM, q) for p in probe.violations(row) if "can" in p.bodies]
    within = [p.distance for p in pairs if any("::" in body for body in p.bodies)]
    outside = [p.distance for p in pairs if not any("::" in body for body in p.bodies)]
    assert within
    assert max(within) < 0 < max(outside) <= 0.1


def test_what_may_be_touched_by_default_is_the_tool_and_its_fingers() -> None:
    inside = edit_scene(HELD, [SetPositions("arm", {"left_finger_joint": 0.0})])
    start = WORLD.positions(ARM)
    assert planning.load_world(inside).violations(ARM, start, WORLD.margins()) == ()
    strict = edit_scene(
        PICKUP, [replace(GRASP, touch=()), SetPositions("arm", {"left_finger_joint": 0.0})]
    )
    pairs = planning.load_world(strict).violations(ARM, start, WORLD.margins())
    assert {pair.bodies for pair in pairs} >= {("arm::left_finger", "can")}


@pytest.mark.parametrize(
    ("place", "hit"),
    [((0.0, 0.0, 0.0), "arm::shoulder_link"), ((-0.425, 0.0, 0.0), "arm::forearm_link")],
)
def test_links_before_and_after_that_which_holds_are_not_to_be_touched(place, hit) -> None:
    on_the_arm = AttachObject("can", "arm::upper_arm_link", pose=Pose.from_parts(place))
    world = planning.load_world(edit_scene(PICKUP, [on_the_arm]))
    pairs = world.violations(ARM, WORLD.positions(ARM), WORLD.margins())
    assert (hit, "can") in {pair.bodies for pair in pairs}


def held(frame: str, touch: tuple[str, ...] | None = None) -> Scene:
    can = replace(PICKUP.objects[1], attached=Attachment(frame, touch))
    return replace(PICKUP, objects=(PICKUP.objects[0], can, *PICKUP.objects[2:]))


@pytest.mark.parametrize(
    ("scene", "path"),
    [
        (held("arm::tpc"), "objects.1.attached.frame"),
        (held("place"), "objects.1.attached.frame"),
        (held("table"), "objects.1.attached.frame"),
        (held("can"), ""),
        (held("pick"), ""),
        (held("arm::tcp", ("arm::thumb",)), "objects.1.attached.touch.0"),
    ],
)
def test_attachments_that_cannot_be_are_refused_with_their_place(scene, path) -> None:
    with pytest.raises(SceneInvalid) as refusal:
        planning.load_world(scene)
    assert refusal.value.evidence["path"] == path


def test_a_held_thing_is_carried_to_a_pose_and_the_whole_way_is_free() -> None:
    """The goal is a pose of the can itself; every state is judged by a world of its own."""
    place = planning.PoseTarget(Pose.from_parts((0.5, -0.28, 0.07)))
    goal = planning.PoseGoal((place,), "can", np.zeros(3), np.array([0.0, 0.0, np.pi]))
    found = planning.plan(
        planning.PlanningProblem("arm", goal, margin=0.002, seed=3),
        WORLD,
        deadline=no_hurry(30.0),
    )
    assert found.certificate.proven
    rows = found.trajectory.positions(found.trajectory.sample_times(0.02))
    judge = held_world(kernel=False)
    assert violating(judge, rows, 0.0019) == [set()] * len(rows)
    end = judge.frame_pose("can", judge.embed(ARM, found.goal_configuration))
    assert np.linalg.norm(end.position - place.pose.position) < 1e-4


def test_a_replay_moves_what_is_held() -> None:
    start = WORLD.positions(ARM)
    line = JointSpline.through(ARM.joints, np.array([start, start + 0.1]))
    motion = TimedTrajectory(line.joints, line.breaks, line.bases, line.coefficients)
    page = planning.replay_html(WORLD, ARM, motion, frames_per_second=5.0)
    contents = [base64.b64decode(text) for text in re.findall(r"base64,([A-Za-z0-9+/=]+)", page)]
    (animation,) = [message for message in contents if b"set_animation" in message]
    assert b"/bodies/can" in animation
    assert b"/bodies/box" not in animation


def test_a_simulated_arm_carries_what_it_holds() -> None:
    simulation = planning.Simulation(WORLD, ARM, WORLD.positions(ARM))
    at = np.zeros(6)
    simulation.command(WORLD.positions(ARM), at, at)
    assert simulation.advance_to(0.02) == ()
    assert np.abs(simulation.q - WORLD.positions(ARM)).max() < 1e-3


def test_what_stands_is_no_part_of_a_robot() -> None:
    dropped = edit_scene(HELD, [planning.DetachObject("can"), MoveObject("can", Pose.identity())])
    world = planning.load_world(dropped)
    assert not world.drake.owners
    assert not world.margins(0.1).are_of_one_robot("can", "arm::tcp")
    assert WORLD.margins(0.1).are_of_one_robot("can", "arm::tcp")


CHAIN = """<robot name="m"><link name="base"/>
<link name="a"><collision><origin xyz="0.2 0 0"/><geometry><sphere radius="0.05"/></geometry>
</collision></link>
<link name="b"><collision><origin xyz="0.2 0 0"/><geometry><sphere radius="0.05"/></geometry>
</collision></link>
<link name="c"><collision><origin xyz="0.2 0 0"/><geometry><sphere radius="0.05"/></geometry>
</collision></link>
<joint name="j0" type="revolute"><parent link="base"/><child link="a"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3" velocity="1" effort="1"/></joint>
<joint name="j1" type="revolute"><parent link="a"/><child link="b"/><origin xyz="0.4 0 0"/>
<axis xyz="0 0 1"/><limit lower="-3" upper="3" velocity="1" effort="1"/></joint>
<joint name="j2" type="revolute"><parent link="b"/><child link="c"/><origin xyz="0.4 0 0"/>
<axis xyz="0 0 1"/><limit lower="-3" upper="3" velocity="1" effort="1"/></joint></robot>"""


def test_what_a_robot_without_a_card_holds_may_touch_nothing_that_it_carries(urdf_world) -> None:
    """Held by the first link, it was never held against the second and the third."""
    attached = {"name": "t", "shape": {"sphere": 0.05}, "attached": {"frame": "r::a"}}
    world = urdf_world(CHAIN, objects=[attached])
    held = {pair.bodies for pair in scene_summary(world).unchecked if pair.reason == "held"}
    assert held == {("r::a", "t")}
