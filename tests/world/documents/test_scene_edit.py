"""Edited scenes: what is named changes, what is not stays, what cannot be is refused."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import planning
from planning import (
    AddObject,
    AllowPair,
    AttachObject,
    DetachObject,
    ForbidPair,
    MoveObject,
    Pose,
    RemoveObject,
    SetPositions,
    edit_scene,
)
from planning.domain.geometry.shapes import Sphere
from planning.domain.scene.scene import Attachment, SceneObject
from planning.errors import SceneEditImpossible, UnknownName
from tests.profiles import num_cases

PICKUP = planning.read_scene(planning.bundled_folder("scenes") / "ur5e_pickup.scene.yaml")
HELD = edit_scene(PICKUP, [AttachObject("can", "arm::tcp")])
BALL = SceneObject("ball", Sphere(0.03), Pose.from_parts((0.2, -0.5, 0.4)), movable=True)
ELSEWHERE = Pose.from_parts((0.3, 0.4, 0.5), rpy=(0.1, 0.2, 0.3))

angle = st.floats(-3.0, 3.0)
poses = st.builds(
    Pose.from_parts, st.tuples(*[st.floats(-1, 1)] * 3), rpy=st.tuples(angle, angle, angle)
)


def thing(scene: planning.Scene, name: str) -> SceneObject:
    return next(entry for entry in scene.objects if entry.name == name)


def in_world(scene: planning.Scene, name: str) -> Pose:
    world = planning.load_world(scene, kernel=False)
    return world.frame_pose(name, world.state)


@given(pose=poses, q=st.tuples(*[angle] * 6), frame=st.sampled_from(["arm::tcp", "arm::tool0"]))
@settings(max_examples=num_cases(6))
def test_attaching_and_detaching_leave_a_thing_where_it_is(pose, q, frame) -> None:
    edited = edit_scene(
        PICKUP, [MoveObject("can", pose), SetPositions("arm", q), AttachObject("can", frame)]
    )
    assert max(in_world(edited, "can").distance(pose)) < 1e-6
    dropped = edit_scene(edited, [DetachObject("can")])
    assert max(thing(dropped, "can").pose.distance(pose)) < 1e-6
    assert thing(dropped, "can").attached is None


@given(q=st.tuples(*[angle] * 6))
@settings(max_examples=num_cases(6))
def test_what_is_attached_follows_its_frame_and_frames_follow_it(q) -> None:
    grasp = Pose.from_parts((0.01, 0.0, 0.02), rpy=(0.1, 0.2, 0.3))
    moved = edit_scene(
        PICKUP, [AttachObject("can", "arm::tcp", pose=grasp), SetPositions("arm", q)]
    )
    world = planning.load_world(moved, kernel=False)
    x_wt = world.frame_pose("arm::tcp", world.state)
    assert max(world.frame_pose("can", world.state).distance(x_wt @ grasp)) < 1e-9
    pick = next(frame for frame in moved.frames if frame.name == "pick")
    x_wp = world.frame_pose("pick", world.state)
    assert max(x_wp.distance(x_wt @ grasp @ pick.pose)) < 1e-9
    dropped = edit_scene(moved, [DetachObject("can")])
    assert max(thing(dropped, "can").pose.distance(x_wt @ grasp)) < 1e-9


@pytest.mark.parametrize(
    "operation",
    [
        AddObject(BALL),
        MoveObject("box", ELSEWHERE),
        AttachObject("can", "arm::tcp"),
        SetPositions("arm", "upright"),
        AllowPair(("can", "box")),
        ForbidPair(("arm::base_link", "table")),
    ],
    ids=lambda operation: type(operation).__name__,
)
def test_the_scene_given_and_all_that_is_not_named_stay(operation) -> None:
    before = PICKUP.digest
    edited = edit_scene(PICKUP, [operation])
    assert PICKUP.digest == before
    assert edited.digest != before
    kept = {"box", "table", "can"} - {getattr(operation, "name", "")}
    for name in kept:
        assert thing(edited, name) == thing(PICKUP, name)
    assert edited.frames == PICKUP.frames
    planning.load_world(edited)


def test_what_is_done_can_be_undone() -> None:
    there = [AddObject(BALL), AllowPair(("ball", "box")), AllowPair(("box", "ball"))]
    assert edit_scene(PICKUP, [*there, RemoveObject("ball")]) == PICKUP
    pair = AllowPair(("can", "box")), ForbidPair(("box", "can"))
    assert edit_scene(PICKUP, pair) == PICKUP
    assert edit_scene(PICKUP, []) == PICKUP


def test_what_is_removed_takes_along_what_hangs_on_it() -> None:
    edited = edit_scene(PICKUP, [AllowPair(("can", "table")), RemoveObject("can")])
    assert [frame.name for frame in edited.frames] == ["place"]
    assert edited.allowed_collisions == PICKUP.allowed_collisions
    planning.load_world(edited)


def test_joints_that_are_not_named_stay() -> None:
    closed = edit_scene(PICKUP, [SetPositions("arm", {"left_finger_joint": 0.004})])
    reached = edit_scene(closed, [SetPositions("arm", (0.1, -1.2, 1.9, -2.2, -1.5, 0.3))])
    world = planning.load_world(reached)
    assert world.positions(world.group("arm::gripper")).tolist() == [0.004]
    q = world.positions(world.group("arm"))
    np.testing.assert_array_equal(q, [0.1, -1.2, 1.9, -2.2, -1.5, 0.3])
    turned = edit_scene(reached, [SetPositions("arm", {"arm::wrist_3_joint": -1.0})])
    world = planning.load_world(turned)
    assert world.positions(world.group("arm")).tolist() == [*q[:5], -1.0]
    assert world.positions(world.group("arm::gripper")).tolist() == [0.004]


MISSING = [
    (MoveObject("cann", ELSEWHERE), "object", "can"),
    (RemoveObject("tabel"), "object", "table"),
    (AttachObject("can", "arm::tpc"), "frame", "arm::tcp"),
    (AttachObject("can", "arm::tcp", ("arm::left_fingr",)), "body", "arm::left_finger"),
    (DetachObject("arm::tcp"), "object", None),
    (SetPositions("arn", "home"), "scene robot", "arm"),
    (AllowPair(("can", "arm::left_fingr")), "body", "arm::left_finger"),
    (ForbidPair(("can", "tabl")), "body", "table"),
]


@pytest.mark.parametrize(("operation", "kind", "nearest"), MISSING)
def test_unknown_names_are_refused_with_the_right_ones(operation, kind, nearest) -> None:
    with pytest.raises(UnknownName) as refusal:
        edit_scene(PICKUP, [AddObject(BALL), operation])
    evidence = refusal.value.evidence
    assert (evidence["kind"], evidence["operation"]) == (kind, 1)
    assert evidence["nearest"][:1] == ([] if nearest is None else [nearest])
    assert evidence["known"]


FIXED = [
    (PICKUP, AddObject(thing(PICKUP, "can")), "taken"),
    (PICKUP, AddObject(SceneObject("place", Sphere(0.1), ELSEWHERE)), "taken"),
    (PICKUP, AttachObject("table", "arm::tcp"), "not `movable`"),
    (PICKUP, AttachObject("can", "place"), "not a frame of a robot"),
    (PICKUP, AttachObject("can", "world"), "not a frame of a robot"),
    (PICKUP, AttachObject("can", "pick"), "not a frame of a robot"),
    (PICKUP, DetachObject("can"), "not attached"),
    (PICKUP, SetPositions("arm", "hoem"), "did you mean 'home'"),
    (PICKUP, SetPositions("arm", (0.0,)), "6"),
    (PICKUP, SetPositions("arm", {"elbow": 0.0}), "elbow_joint"),
    (PICKUP, ForbidPair(("can", "box")), "does not allow"),
    (PICKUP, ForbidPair(("arm::left_finger", "arm::right_finger")), "does not allow"),
    (HELD, MoveObject("can", ELSEWHERE), "detach it first"),
    (HELD, AttachObject("can", "arm::tool0"), "already"),
]


@pytest.mark.parametrize(("scene", "operation", "words"), FIXED)
def test_what_the_scene_does_not_admit_is_refused(scene, operation, words) -> None:
    with pytest.raises(SceneEditImpossible, match=r"operations\.0: ") as refusal:
        edit_scene(scene, [operation])
    assert words in refusal.value.detail
    assert refusal.value.evidence["operation"] == 0


def test_a_thing_in_a_thing_in_the_hand() -> None:
    """A lid on the can in the hand: it follows, and the can cannot be taken away under it."""
    lid = SceneObject("lid", Sphere(0.01), Pose.identity(), attached=Attachment("pick"))
    both = edit_scene(HELD, [AddObject(lid)])
    assert max(in_world(both, "lid").distance(in_world(both, "pick"))) < 1e-9
    with pytest.raises(SceneEditImpossible, match="detach them first"):
        edit_scene(both, [RemoveObject("can")])
    assert edit_scene(both, [RemoveObject("lid")]) == HELD
