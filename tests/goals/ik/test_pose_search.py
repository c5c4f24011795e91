"""IK by the kernel and by Drake: different numbers, solutions of the same quality."""

import itertools
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import planning
from planning.domain.geometry.pose import Pose
from planning.domain.goals.funnel import Funnel
from planning.domain.goals.goal import JointGoal, PoseGoal, PoseTarget
from planning.domain.request.deadline import Deadline
from planning.domain.request.options import IkOptions
from planning.errors import Canceled, DeadlineExceeded, GoalInCollision, GoalUnreachable
from planning.goals.find_goals import GoalQuery, find_goals
from planning.goals.ik.pose_solvers import KernelPoseSolver
from planning.goals.start_validation import validate_start
from planning.world.world import World
from tests.clocks import no_hurry
from tests.goals.conftest import ENGINES, EXACT, ask, at, with_engine, world_by

DOWN = Pose.from_parts([0.45, 0.25, 0.45], rpy=[np.pi, 0, 0.3])


def assert_narrows(funnel: Funnel) -> None:
    counts = [
        funnel.num_samples,
        funnel.converged,
        funnel.within_limits,
        funnel.collision_free,
        funnel.distinct,
    ]
    assert counts == sorted(counts, reverse=True)


@ENGINES
def test_the_same_question_has_the_same_answer(engine: str) -> None:
    world = world_by("panda_shelf", engine)
    group = world.groups[0]
    target = world.frame_pose(group.tool_frames[0], world.state)
    first, again = (ask(world, group.name, at(target), IkOptions(10, 30)) for _ in range(2))
    assert first == again
    assert ask(world, group.name, at(target), IkOptions(10, 30), seed=1) != first


def test_options_end_the_search() -> None:
    world = world_by("panda_shelf", "kernel")
    group = world.groups[0]
    target = world.frame_pose(group.tool_frames[0], world.state)
    most = ask(world, group.name, at(target), IkOptions(max_configurations=110, max_trials=900))
    assert len(most.positions) == most.funnel.distinct == 110
    assert_narrows(most.funnel)
    fewer = IkOptions(max_configurations=110, max_trials=most.funnel.num_samples - 20)
    assert ask(world, group.name, at(target), fewer).funnel.distinct < 110
    short = ask(world, group.name, at(target), IkOptions(max_trials=7))
    assert short.funnel.num_samples == 7


@ENGINES
def test_every_target_is_tried_and_named(engine: str) -> None:
    world = world_by("ur5e_pickup", engine)
    group = world.group("arm")
    poses = [Pose.from_parts([0.45, y, 0.45], rpy=[np.pi, 0, 0.3]) for y in (0.25, -9.0, 0.1)]
    goal = PoseGoal(tuple(PoseTarget(pose) for pose in poses), "", EXACT, EXACT)
    found = ask(world, "arm", goal, IkOptions(max_trials=90))
    assert set(found.target_indices) == {0, 2}
    for q, index in zip(found.positions, found.target_indices, strict=True):
        reached = world.frame_pose("arm::tcp", world.embed(group, q))
        assert max(reached.distance(poses[index])) < 2e-6


@ENGINES
def test_a_goal_inside_the_table_says_that_it_collides(engine: str) -> None:
    world = world_by("ur5e_pickup", engine)
    inside = Pose.from_parts([0.45, 0.25, 0.0], rpy=[np.pi, 0, 0.3])
    with pytest.raises(GoalInCollision) as refusal:
        ask(world, "arm", at(inside), IkOptions(max_trials=10), looks=150)
    funnel = refusal.value.evidence["funnel"]
    assert funnel["collision_free"] == 0
    assert sum(entry["count"] for entry in funnel["rejected_by"]) == funnel["within_limits"] > 0


@ENGINES
def test_out_of_reach_says_what_is_nearest(engine: str) -> None:
    world = world_by("panda_shelf", engine)
    with pytest.raises(GoalUnreachable) as refusal:
        ask(world, world.groups[0].name, at(Pose.from_parts([3.0, 0, 0.5])), IkOptions(5, 40))
    assert refusal.value.evidence["funnel"]["tried"] == 40
    assert refusal.value.evidence["funnel"]["converged"] == 0
    assert 1.5 < refusal.value.evidence["nearest"]["translation_error"] < 3.0


@ENGINES
def test_time_and_patience_of_others_end_it(engine: str) -> None:
    world = world_by("panda_shelf", engine)
    group = world.groups[0]
    goal = at(world.frame_pose(group.tool_frames[0], world.state))
    query = GoalQuery(group, goal, world.positions(group), world.margins(), IkOptions())
    rng = np.random.default_rng(0)
    with pytest.raises(DeadlineExceeded):
        find_goals(world, query, rng, no_hurry(0.0))
    with pytest.raises(Canceled):
        find_goals(world, query, rng, no_hurry(9.0, lambda: True))


@pytest.mark.parametrize("wanted", [1, 3, 8])
def test_few_configurations_are_the_nearest_whole_turns_included(wanted: int) -> None:
    world = world_by("ur5e_pickup", "kernel")
    group, goal = world.group("arm"), at(Pose.identity(), "pick")
    few = ask(world, "arm", goal, IkOptions(max_configurations=wanted))
    every = ask(world, "arm", goal, IkOptions(10_000, 2000), seed=1)
    start = world.positions(group)
    distances = np.linalg.norm(few.positions - start, axis=1)
    all_of_them = np.linalg.norm(every.positions - start, axis=1)
    np.testing.assert_allclose(distances, all_of_them[:wanted], atol=1e-5)


def test_a_time_limit_for_goals_alone_tells_the_funnel() -> None:
    """Time goes by with every look at the clock, so it runs out after some of the trials."""
    world = world_by("ur5e_pickup", "kernel")
    inside = at(Pose.from_parts([0.45, 0.25, 0.0], rpy=[np.pi, 0, 0.3]))
    options = IkOptions(100, 100_000, allowed_time=3.0)
    group = world.group("arm")
    query = GoalQuery(group, inside, world.positions(group), world.margins(), options)
    ticks = itertools.count()
    deadline = Deadline.after(1000.0, lambda: float(next(ticks)))
    with pytest.raises(DeadlineExceeded, match="3 s ran out") as refusal:
        find_goals(world, query, np.random.default_rng(0), deadline)
    evidence = refusal.value.evidence
    assert (evidence["allowed"], evidence["max_trials"]) == (3.0, 100_000)
    assert 0 < evidence["funnel"]["tried"] < 2000
    assert evidence["cut_short"]
    assert evidence["funnel"]["rejected_by"]


def test_how_many_seeds_are_taken_at_once_does_not_matter(monkeypatch: Any) -> None:
    world = world_by("ur5e_pickup", "kernel")
    answers = []
    for at_once in (1, 7, 320):
        monkeypatch.setattr(KernelPoseSolver, "batch_size", at_once)
        answers.append(ask(world, "arm", at(DOWN), IkOptions(6, 200)))
    assert answers[0] == answers[1] == answers[2]


def test_what_drake_refutes_is_asked_of_drake(monkeypatch: Any) -> None:
    world = world_by("ur5e_pickup", "kernel")

    def claim(_: object, seeds: np.ndarray, *_rest: object) -> tuple[np.ndarray, np.ndarray]:
        return np.ones(len(seeds), dtype=bool), np.array(seeds)

    monkeypatch.setattr(KernelPoseSolver, "solve", claim)
    found = ask(world, "arm", at(DOWN), IkOptions(4, 60))
    expected = ask(world_by("ur5e_pickup", "drake"), "arm", at(DOWN), IkOptions(4, 60))
    assert found == expected


@ENGINES
def test_frames_that_follow_are_led_there(engine: str, tmp_path: Path) -> None:
    """The second slider goes twice as far as the first, plus 0.1 m."""
    world = with_engine(follower_world(tmp_path), engine)
    group = world.groups[0]
    assert [joint.name for joint in group.joints] == ["slide::lead"]
    target = Pose.from_parts([0.1 + 3 * 0.25, 0.0, 0.0])
    goal = replace(at(target, rotation=np.full(3, np.pi)), frame="slide::tool")
    found = ask(world, group.name, goal, IkOptions(5, 20))
    assert found.positions[0] == pytest.approx([0.25], abs=1e-8)
    far = replace(goal, targets=(PoseTarget(Pose.from_parts([9.0, 0.0, 0.0])),))
    with pytest.raises(GoalUnreachable) as refusal:
        ask(world, group.name, far, IkOptions(5, 20))
    nearest = refusal.value.evidence["nearest"]
    assert nearest["position"][0] == pytest.approx(0.1 + 3 * 0.5, abs=1e-3)


@ENGINES
def test_what_is_free_needs_no_distances(engine: str, monkeypatch: Any) -> None:
    world = world_by("panda_shelf", engine)
    group = world.groups[0]
    q = world.positions(group)

    def refuse(*_: object) -> None:
        pytest.fail("distances were measured though nothing is wrong")

    monkeypatch.setattr(World, "violations", refuse)
    start, _ = validate_start(world, group, q, world.margins())
    query = GoalQuery(group, JointGoal(q[None]), start, world.margins(), IkOptions())
    deadline = no_hurry(9.0)
    found = find_goals(world, query, np.random.default_rng(0), deadline)
    np.testing.assert_array_equal(found.positions, q[None])


SLIDERS = """<robot name="slide"><link name="base"/><link name="a"/><link name="tool"/>
<joint name="lead" type="prismatic"><parent link="base"/><child link="a"/><axis xyz="1 0 0"/>
<limit lower="-0.5" upper="0.5" effort="1" velocity="1"/></joint>
<joint name="follow" type="prismatic"><parent link="a"/><child link="tool"/><axis xyz="1 0 0"/>
<limit lower="-2" upper="2" effort="1" velocity="1"/>
<mimic joint="lead" multiplier="2" offset="0.1"/></joint></robot>"""


def follower_world(folder: Path) -> World:
    home = folder / "slide"
    home.mkdir()
    (home / "slide.urdf").write_text(SLIDERS)
    (home / "robot.yaml").write_text(
        "name: slide\nfile: slide.urdf\nbase: base\ndefault_group: all\n"
        "groups: {all: {joints: [lead], tool_frames: [tool]}}\n"
        "limits: {lead: {velocity: 1.0, acceleration: 1.0}}\n"
    )
    scene = planning.parse_scene({"name": "s", "robots": [{"name": "slide", "model": "slide"}]})
    return planning.load_world(scene, planning.ModelLibrary((folder,), allow_paths=False))
