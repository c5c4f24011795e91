"""Edited in place is loaded anew: the same answers, whatever was done to the scene before."""

from dataclasses import replace
from pathlib import Path
from typing import Any

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
    RemoveObject,
    SetPositions,
    edit_scene,
    scene_summary,
)
from planning.domain.geometry.pose import Pose
from planning.domain.geometry.shapes import Box, Capsule, HalfSpace, Mesh, Sphere
from planning.domain.scene.scene import PairMargin, Scene, SceneObject, SceneRobot
from planning.domain.value import digest
from planning.errors import InputError, WayproofError
from planning.kernel.native import native
from planning.world.fingerprint import collision_fingerprint
from planning.world.world import World
from tests.clocks import no_hurry
from tests.profiles import num_cases

pytestmark = pytest.mark.skipif(native() is None, reason="without the kernel all is loaded anew")

NAMES = [f"b{i}" for i in range(5)]
BODIES = [*NAMES, "new", "arm::forearm_link", "arm::wrist_2_link"]
SCENE = planning.parse_scene({
    "name": "edited",
    "robots": [{"name": "arm", "model": "ur5e", "positions": "home"}],
    "objects": [
        {
            "name": name,
            "shape": {"box": [0.1, 0.1, 0.1]} if i % 2 else {"sphere": 0.07},
            "pose": {"position": [0.45, 0.2 * i - 0.4, 0.1]},
            "movable": True,
        }
        for i, name in enumerate(NAMES)
    ],
    "frames": [{"name": "on_b1", "parent": "b1"}, {"name": "on_it", "parent": "on_b1"}],
})
REST = SCENE.objects[1:]

near = st.floats(0.25, 0.7)
angle = st.floats(-3.0, 3.0)
poses = st.builds(
    Pose.from_parts,
    st.tuples(near, st.floats(-0.6, 0.6), st.floats(-0.1, 0.7)),
    rpy=st.tuples(angle, angle, angle),
)
names = st.sampled_from([*NAMES, "new"])
moves = st.builds(MoveObject, names, poses)
operations = st.one_of(
    moves,
    moves,
    st.builds(SetPositions, st.just("arm"), st.tuples(*[st.floats(-1.5, 1.5)] * 6)),
    st.builds(AttachObject, names, st.just("arm::tcp")),
    st.builds(DetachObject, names),
    st.builds(RemoveObject, names),
    st.builds(
        AddObject,
        st.builds(SceneObject, st.just("new"), st.just(Sphere(0.06)), poses, movable=st.just(True)),
    ),
    st.builds(
        AllowPair,
        st.tuples(st.sampled_from(BODIES), st.sampled_from(BODIES)).filter(lambda p: p[0] != p[1]),
    ),
    st.builds(ForbidPair, st.just(("b1", "arm::forearm_link"))),
)
CONFIGURATIONS = np.random.default_rng(1).uniform(-2.0, 2.0, (40, 6))


def load(scene: Scene, like: World | None = None) -> World:
    return planning.load_world(scene, previous=like)


def answers(world: World) -> list[Any]:
    """Return what a world says: verdicts, distances, frames, names; all of it values."""
    group = world.group("arm")
    oracle = world.collision_oracle(group, world.margins(0.02))
    probe = world.distance_probe(world.margins())
    full = world.embed(group, CONFIGURATIONS[:4])
    return [
        scene_summary(world),
        oracle.are_free(CONFIGURATIONS),
        planning.check_configurations(world, "arm", CONFIGURATIONS[:6], 0.05),
        [probe.pairs_within(q, 0.2) for q in full],
        {frame: world.frame_poses(frame, full) for frame in scene_summary(world).frames},
        world.state,
        collision_fingerprint(world, group),
    ]


def planned(world: World) -> list[Any]:
    """Return the bytes of a plan, or of why there is none."""
    goal = planning.JointGoal(np.array([[0.6, -1.2, 1.4, -1.6, -1.5, 0.2]]))
    try:
        found = planning.plan(
            planning.PlanningProblem("arm", goal, seed=3), world, deadline=no_hurry()
        )
    except WayproofError as failure:
        return [failure.code, failure.evidence.get("pairs")]
    return [found.trajectory, found.certificate]


def compared(actual: list[Any], expected: list[Any]) -> None:
    assert digest(actual) == digest(expected)


# With shapes checked, beartype draws from `random` while operations are built.
@pytest.mark.filterwarnings("ignore:Do not use the `random` module inside strategies")
@given(steps=st.lists(operations, min_size=1, max_size=6))
@settings(max_examples=num_cases(5, 320))
def test_edited_in_place_is_loaded_anew(steps: list[Any]) -> None:
    scene, world = SCENE, load(SCENE)
    done = 0
    for step in steps:
        try:
            scene = edit_scene(scene, [step])
        except InputError:
            continue
        world = load(scene, like=world)
        done += 1
        if done % 2:
            compared(answers(world), answers(load(scene)))
    compared(answers(world), answers(load(scene)))


@given(steps=st.lists(moves, min_size=1, max_size=3))
@settings(max_examples=num_cases(2))
def test_plans_in_an_edited_scene_are_the_same_to_the_bit(steps: list[Any]) -> None:
    scene, world = SCENE, load(SCENE)
    for step in steps:
        if step.name in NAMES:
            scene = edit_scene(scene, [step])
            world = load(scene, like=world)
    compared(planned(world), planned(load(scene)))


MOVED = edit_scene(SCENE, [MoveObject("b1", Pose.from_parts((0.5, 0.3, 0.4)))])


def test_moving_things_and_robots_loads_nothing_again() -> None:
    world = load(SCENE)
    moved = load(MOVED, like=world)
    assert moved.drake.diagram is world.drake.diagram
    placed = load(edit_scene(MOVED, [SetPositions("arm", (0.1, -1.0, 1.0, 0.0, 0.3, 0.0))]), moved)
    assert placed.drake.diagram is world.drake.diagram
    assert placed.state[0] == 0.1
    recolored = [SceneObject(t.name, t.shape, t.pose, color=np.ones(4)) for t in SCENE.objects]
    like = load(Scene(SCENE.name, SCENE.robots, tuple(recolored), SCENE.frames), like=world)
    assert like.drake.diagram is world.drake.diagram


CAPSULE = SceneObject("new", Capsule(0.05, 0.2), Pose.from_parts((0.4, 0.1, 0.3)))


@pytest.mark.parametrize(
    "scene",
    [
        edit_scene(SCENE, [RemoveObject("b3")]),
        edit_scene(SCENE, [AddObject(CAPSULE)]),
        edit_scene(SCENE, [RemoveObject("b4"), AddObject(CAPSULE)]),
        replace(SCENE, objects=(), frames=()),
        replace(SCENE, objects=SCENE.objects[::-1]),
        replace(SCENE, objects=(replace(SCENE.objects[0], shape=Box(np.full(3, 0.3))), *REST)),
    ],
    ids=["removed", "added", "exchanged", "none", "in another order", "shape"],
)
def test_other_objects_load_no_robot_again(scene: Scene) -> None:
    bare = replace(scene, frames=())
    world = load(replace(SCENE, frames=()))
    before = answers(world)
    other = load(bare, like=world)
    assert other.drake.diagram is world.drake.diagram
    compared(answers(other), answers(load(bare)))
    compared(planned(other), planned(load(bare)))
    compared(answers(world), before)
    back = load(world.scene, like=other)
    assert back.drake.diagram is world.drake.diagram
    compared(answers(back), before)


@pytest.mark.parametrize(
    "step",
    [
        AddObject(SceneObject("new", HalfSpace(), Pose.from_parts((0.0, 0.0, -0.5)))),
        AttachObject("b3", "arm::tcp"),
        AllowPair(("b1", "arm::forearm_link")),
    ],
    ids=lambda step: type(step).__name__,
)
def test_what_is_in_drakes_model_is_loaded_again(step: Any) -> None:
    world = load(SCENE)
    scene = edit_scene(SCENE, [step])
    edited = load(scene, like=world)
    assert edited.drake.diagram is not world.drake.diagram
    compared(answers(edited), answers(load(scene)))


def test_a_margin_is_loaded_again() -> None:
    """A scene that is posted anew may have it changed."""
    scene = replace(SCENE, margins=(PairMargin(("b1", "arm::forearm_link"), 0.4),))
    world = load(SCENE)
    other = load(scene, like=world)
    assert other.drake.diagram is not world.drake.diagram
    compared(answers(other), answers(load(scene)))
    assert digest(answers(other)) != digest(answers(world))


TRAY = """<sdf version="1.9"><model name="m"><link name="base"/>
<joint name="w" type="fixed"><parent>world</parent><child>base</child></joint>
<link name="tray"><collision name="c"><geometry><plane><normal>0 0 1</normal>
<size>1 1</size></plane></geometry></collision></link>
<joint name="j" type="revolute"><parent>base</parent>
<child>tray</child><axis><xyz>1 0 0</xyz><limit><lower>-1</lower><upper>1</upper></limit></axis>
</joint></model></sdf>"""


def test_the_first_object_that_drake_has_to_have_is_loaded(tmp_path: Path) -> None:
    (tmp_path / "tray.sdf").write_text(TRAY)
    library = planning.ModelLibrary.bundled(allow_paths=True)
    tray = SceneRobot("r", str(tmp_path / "tray.sdf"), Pose.identity(), None)
    bare = Scene("tilted", (tray,))
    scene = edit_scene(bare, [AddObject(CAPSULE)])
    other = planning.load_world(scene, library, previous=planning.load_world(bare, library))
    assert "new" in other.drake.bodies
    expected = planning.load_world(scene, library)
    q = np.linspace(-1, 1, 9)[:, None]
    compared(
        [planning.check_configurations(other, "r", q)],
        [planning.check_configurations(expected, "r", q)],
    )


def test_pairs_that_may_touch_stay_so_beside_other_objects() -> None:
    allowed = edit_scene(SCENE, [AllowPair(("b1", "arm::forearm_link"))])
    world, scene = load(allowed), edit_scene(allowed, [AddObject(CAPSULE), RemoveObject("b4")])
    other = load(scene, like=world)
    assert other.drake.diagram is world.drake.diagram
    compared(answers(other), answers(load(scene)))


@pytest.mark.parametrize(
    "scene",
    [
        replace(SCENE, objects=(SCENE.objects[0], *SCENE.objects[2:])),
        replace(SCENE, frames=(), objects=(*REST, replace(CAPSULE, name="arm"))),
        replace(SCENE, frames=(), objects=(*REST, replace(CAPSULE, name="b1"))),
        replace(SCENE, frames=(), objects=(*REST, replace(CAPSULE, name="arm::forearm_link"))),
        replace(SCENE, objects=(*REST, replace(CAPSULE, name="on_it"))),
        replace(SCENE, frames=(), objects=REST, allowed_collisions=(("b0", "arm::base_link"),)),
        replace(SCENE, frames=(), objects=REST, allowed_collisions=(("b0", "b2"),)),
        replace(SCENE, frames=(), margins=(PairMargin(("b0", "b9"), 0.1),)),
        replace(
            SCENE,
            frames=(),
            objects=(*REST, replace(CAPSULE, shape=Mesh("nowhere.obj", np.ones(3)))),
        ),
    ],
    ids=[
        "frame on it",
        "robot",
        "twice",
        "link",
        "frame",
        "allowed",
        "both allowed",
        "margin",
        "mesh",
    ],
)
def test_a_fault_is_told_as_by_a_scene_loaded_anew(scene: Scene) -> None:
    everything = replace(scene, objects=(*SCENE.objects, CAPSULE), margins=())
    world = load(everything)
    with pytest.raises(InputError) as expected:
        load(scene)
    with pytest.raises(InputError) as found:
        load(scene, like=world)
    assert found.type is expected.type
    assert (found.value.detail, found.value.evidence) == (
        expected.value.detail,
        expected.value.evidence,
    )


def test_the_world_before_an_edit_answers_as_before() -> None:
    """Both share Drake's model, and nothing that an object's place has a part in."""
    world = load(SCENE)
    before = answers(world)
    moved = load(MOVED, like=world)
    after = answers(moved)
    compared(answers(world), before)
    compared(answers(moved), after)
    assert digest(before) != digest(after)


def test_a_robot_without_home_starts_where_a_scene_loaded_anew_has_it(tmp_path: Path) -> None:
    """Wherever queries of the world before have put it."""
    description = tmp_path / "hinge.urdf"
    description.write_text(
        '<robot name="hinge"><link name="base"/><link name="tip"/><joint name="j" type="revolute">'
        '<parent link="base"/><child link="tip"/><axis xyz="0 0 1"/>'
        '<limit lower="-2" upper="2" velocity="1" effort="1"/></joint></robot>'
    )
    library = planning.ModelLibrary.bundled(allow_paths=True)
    arm = SceneRobot("arm", str(description), Pose.identity(), None)
    box = SceneObject("b1", Box(np.full(3, 0.1)), Pose.from_parts((1.0, 0.0, 0.0)))
    world = planning.load_world(Scene("hinged", (arm,), (box,)), library)
    world.frame_poses("arm::tip", np.array([[0.3]]))
    scene = edit_scene(world.scene, [MoveObject("b1", Pose.from_parts((2.0, 0.0, 0.0)))])
    moved = planning.load_world(scene, library, previous=world)
    assert moved.shares_engine_with(world)
    assert moved.state.tolist() == planning.load_world(scene, library).state.tolist() == [0.0]


def test_a_judge_that_was_asked_before_the_edit_does_not_answer_after_it() -> None:
    """An object is put where the arm is: what was free no longer is."""
    world = load(SCENE)
    group = world.group("arm")
    q = world.positions(group)
    assert world.collision_oracle(group, world.margins()).is_free(q)
    at_the_tool = world.frame_pose("arm::wrist_3_link", world.state)
    moved = load(edit_scene(SCENE, [MoveObject("b2", at_the_tool)]), like=world)
    assert not moved.collision_oracle(group, moved.margins()).is_free(q)
    assert not planning.check_configurations(moved, "arm", q[None])[0].valid
    assert world.collision_oracle(group, world.margins()).is_free(q)


def test_what_is_moved_to_a_robot_is_warned_of() -> None:
    """Also if the warnings of revisions between were never asked for."""
    world, num_warned = load(SCENE), 0
    scene_summary(world)
    hand = world.frame_pose("arm::wrist_2_link", world.state).position
    for gap in (1.0, 0.5, 0.2, 0.12, 0.05, 0.0, 0.4):
        pose = Pose.from_parts(hand + np.array([gap, 0, 0]))
        scene = edit_scene(world.scene, [MoveObject("b1", pose)])
        between = load(scene, like=world)
        after = edit_scene(scene, [MoveObject("b3", Pose.from_parts((3.0, gap, 0.0)))])
        world = load(after, like=between)
        warnings = scene_summary(world).warnings
        assert warnings == scene_summary(load(after)).warnings
        num_warned += bool(warnings)
    assert 0 < num_warned < 7


def test_a_robot_that_is_moved_to_what_stands_is_warned_of() -> None:
    first, has_warnings = load(SCENE), set()
    there = first.embed(first.group("arm"), CONFIGURATIONS[2])
    hand = MoveObject("b1", first.frame_pose("arm::wrist_2_link", there))
    world = load(edit_scene(SCENE, [hand]))
    for q in CONFIGURATIONS[:4]:
        scene = edit_scene(world.scene, [SetPositions("arm", tuple(q))])
        world = load(scene, like=world)
        assert scene_summary(world).warnings == scene_summary(load(scene)).warnings
        has_warnings.add(bool(scene_summary(world).warnings))
    assert has_warnings == {True, False}
