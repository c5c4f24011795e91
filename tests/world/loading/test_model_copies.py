"""A copy of a model answers as the one that was built, and shares nothing with it."""

from dataclasses import replace
from itertools import count
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import planning
from planning import AttachObject, edit_scene, scene_summary
from planning.domain.geometry.pose import Pose
from planning.domain.geometry.shapes import Box, Sphere
from planning.domain.scene.scene import Scene, SceneFrame, SceneObject, SceneRobot
from planning.domain.value import digest
from planning.kernel.native import native
from planning.world.fingerprint import collision_fingerprint
from planning.world.world import World
from tests.clocks import no_hurry
from tests.profiles import num_cases

pytestmark = pytest.mark.skipif(native() is None, reason="without the kernel all is built anew")

NUMBERS = count()
TOOLS = {"ur5e": "tcp", "irb120": "tool0", "panda": "panda_hand"}


def never_built(robot: str, seed: int) -> Scene:
    """Return a scene whose model this process has not built yet: a frame has a name of its own."""
    rng = np.random.default_rng(seed)
    boxes = [
        SceneObject(
            f"b{i}",
            Box(rng.uniform(0.03, 0.2, 3)) if i % 2 else Sphere(0.06),
            Pose.from_parts(rng.uniform(-0.8, 0.8, 3)),
            movable=True,
        )
        for i in range(5)
    ]
    frame = SceneFrame(f"f{next(NUMBERS)}", "world", Pose.identity())
    arm = SceneRobot("arm", robot, Pose.identity(), "home")
    scene = Scene("copied", (arm,), tuple(boxes), (frame,))
    return edit_scene(scene, [AttachObject("b0", f"arm::{TOOLS[robot]}")]) if seed % 2 else scene


def answers(world: World, seed: int) -> list[Any]:
    """Return what a world says: verdicts, distances, frames, names, torques; all of it values."""
    group = world.group("arm")
    limits = world.limits(group)
    rng = np.random.default_rng(seed)
    qs = rng.uniform(
        np.maximum(limits.lower, -3), np.minimum(limits.upper, 3), (40, len(limits.lower))
    )
    oracle = world.collision_oracle(group, world.margins(0.02))
    probe = world.distance_probe(world.margins())
    full = world.embed(group, qs[:4])
    plan = planning.PlanningProblem(
        "arm", planning.JointGoal(qs[:1]), seed=seed, retime=planning.RetimeOptions(effort=True)
    )
    try:
        planned: Any = planning.plan(plan, world, deadline=no_hurry()).trajectory
    except planning.errors.WayproofError as failure:
        planned = failure.code
    return [
        scene_summary(world),
        oracle.are_free(qs),
        planning.check_configurations(world, "arm", qs[:6], 0.05),
        [probe.pairs_within(q, 0.2) for q in full],
        {frame: world.frame_poses(frame, full) for frame in scene_summary(world).frames},
        world.state,
        collision_fingerprint(world, group),
        planned,
    ]


@settings(max_examples=num_cases(4, 40))
@given(robot=st.sampled_from(sorted(TOOLS)), seed=st.integers(0, 2**20))
def test_a_copy_answers_as_what_was_built(robot: str, seed: int) -> None:
    scene = never_built(robot, seed)
    built = planning.load_world(scene)
    expected = answers(built, seed)
    copy = planning.load_world(scene)
    assert digest(answers(copy, seed)) == digest(expected)
    assert copy.drake.warnings == built.drake.warnings
    assert copy.drake.unchecked_reasons == built.drake.unchecked_reasons


def test_worlds_share_no_engine() -> None:
    scene = never_built("ur5e", 0)
    worlds = [planning.load_world(scene) for _ in range(3)]
    for other in worlds[1:]:
        assert not other.shares_engine_with(worlds[0])
        assert other.drake.scene_graph is not worlds[0].drake.scene_graph
        plants = {id(frame.GetParentPlant()) for frame in other.drake.frames.values()}
        assert plants == {id(other.drake.plant)}
    # One that is moved leaves the others where they were.
    before = digest(worlds[1].frame_poses("arm::tcp", worlds[1].state[None]))
    worlds[0].frame_poses("arm::tcp", worlds[0].state[None] + 0.3)
    assert digest(worlds[1].frame_poses("arm::tcp", worlds[1].state[None])) == before
    later = planning.load_world(scene)
    assert later.state.tolist() == worlds[0].state.tolist()


def test_a_copy_has_the_objects_of_its_scene() -> None:
    scene = never_built("ur5e", 2)
    planning.load_world(scene)
    other = replace(scene, objects=(replace(scene.objects[0], name="other"),))
    assert set(planning.load_world(other).drake.static_objects.rows) == {"other"}
