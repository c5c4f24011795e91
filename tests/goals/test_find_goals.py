"""Goal configurations: they reach, they are free, they are distinct, and the funnel adds up."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planning.domain.geometry.pose import Pose
from planning.domain.request.options import IkOptions
from planning.domain.robot.joints import JointType
from planning.domain.robot.manifold import Manifold
from planning.errors import GoalUnreachable
from planning.goals.ranking import full_turn_equivalents
from planning.world.world import World
from tests.conftest import group_of, limits_of
from tests.goals.conftest import ENGINES, ask, at, world_by
from tests.profiles import num_cases, only_campaign


@ENGINES
@given(seed=st.integers(0, 500))
@settings(max_examples=num_cases(3))
def test_every_solution_reaches_and_is_free_in_limits_and_distinct(engine: str, seed: int) -> None:
    world = world_by("ur5e_pickup", engine)
    group = world.group("arm")
    rng = np.random.default_rng(seed)
    limits = world.limits(group)
    q = free_configuration(world, rng)
    target = world.frame_pose("arm::tcp", world.embed(group, q))
    found = ask(world, "arm", at(target), IkOptions(max_trials=100), seed)
    assert len(found.positions)
    for row in found.positions:
        reached = world.frame_pose("arm::tcp", world.embed(group, row))
        assert max(reached.distance(target)) < 2e-6
        assert not world.violations(group, row, world.margins())
    assert (found.positions >= limits.lower).all()
    assert (found.positions <= limits.upper).all()
    gaps = np.abs(found.positions[:, None] - found.positions[None]).max(axis=2)
    assert gaps[~np.eye(len(gaps), dtype=bool)].min(initial=1.0) > 1e-4
    distances = Manifold(group.joints).distance(found.positions, world.positions(group)[None])
    assert (np.diff(distances) >= -1e-9).all()


def free_configuration(world: World, rng: np.random.Generator) -> np.ndarray:
    """Return a configuration of the arm that hits nothing: its pose is a goal that can be met."""
    group = world.group("arm")
    while True:
        q = rng.uniform(-np.pi, np.pi, group.num_positions)
        if not world.violations(group, q, world.margins()):
            return q


@ENGINES
def test_all_eight_branches_of_a_ur_are_found(engine: str) -> None:
    world = world_by("ur5e_pickup", engine)
    found = ask(world, "arm", at(Pose.from_parts([0.45, 0.25, 0.45], rpy=[np.pi, 0, 0.3])))
    assert found.funnel.distinct == 8


def test_whole_turns_are_offered_within_limits() -> None:
    group = group_of(JointType.REVOLUTE, JointType.REVOLUTE, JointType.CONTINUOUS)
    limits = limits_of(group)
    lower, upper = np.array([-2 * np.pi, -1, -np.inf]), np.array([2 * np.pi, 1, np.inf])
    limits = replace(limits, lower=lower, upper=upper)
    rows, _ = full_turn_equivalents(group, limits, np.array([[1.0, 0.5, 0.2]]))
    assert sorted(rows[:, 0]) == pytest.approx([1.0 - 2 * np.pi, 1.0])
    assert set(rows[:, 1]) == {0.5}
    assert set(rows[:, 2]) == {0.2}


@ENGINES
def test_a_free_axis_is_free_and_the_others_are_not(engine: str) -> None:
    world = world_by("ur5e_pickup", engine)
    group = world.group("arm")
    target = Pose.from_parts([0.45, 0.25, 0.4], rpy=[np.pi, 0, 0])
    found = ask(world, "arm", at(target, rotation=np.array([0.0, 0.0, np.pi])), IkOptions(20, 80))
    turns = []
    for row in found.positions:
        reached = world.frame_pose("arm::tcp", world.embed(group, row))
        error = target.inverse @ reached
        assert np.abs(error.position).max() < 2e-6
        assert error.matrix[2, 2] == pytest.approx(1.0, abs=1e-9)
        turns.append(np.arctan2(error.matrix[1, 0], error.matrix[0, 0]))
    assert np.ptp(turns) > 0.5


@ENGINES
def test_position_tolerance_is_a_box_in_the_targets_axes(engine: str) -> None:
    world = world_by("ur5e_pickup", engine)
    group = world.group("arm")
    box = np.array([0.05, 0.0, 0.0])
    target = Pose.from_parts([0.45, 0.2, 0.4], rpy=[np.pi, 0, 0.7])
    found = ask(world, "arm", at(target, position=box), IkOptions(20, 60))
    for row in found.positions:
        reached = world.frame_pose("arm::tcp", world.embed(group, row))
        error = (target.inverse @ reached).position
        assert (np.abs(error) <= box + 2e-6).all()


@ENGINES
def test_rejections_are_tallied_by_pair_and_the_funnel_narrows(engine: str) -> None:
    world = world_by("ur5e_pickup", engine)
    funnel = ask(world, "arm", at(Pose.identity(), "pick"), IkOptions(max_trials=150)).funnel
    counts = [
        funnel.num_samples,
        funnel.converged,
        funnel.within_limits,
        funnel.collision_free,
        funnel.distinct,
    ]
    assert counts == sorted(counts, reverse=True)
    rejected = funnel.within_limits - funnel.collision_free
    assert sum(t.count for t in funnel.rejected_by) == min(rejected, 5)
    assert all(0 < t.min_depth <= t.max_depth for t in funnel.rejected_by)
    assert any("table" in t.bodies for t in funnel.rejected_by)


@pytest.mark.campaign
@pytest.mark.parametrize(
    "engine",
    ["kernel", pytest.param("drake", marks=only_campaign("test_nearest.py asks Drake as well"))],
)
def test_the_nearest_pose_is_not_beaten_by_random_tries(engine: str) -> None:
    world = world_by("ur5e_pickup", engine)
    group = world.group("arm")
    target = Pose.from_parts([1.3, 0.3, 0.4])
    with pytest.raises(GoalUnreachable) as refusal:
        ask(world, "arm", at(target), IkOptions(5, 20))
    near = refusal.value.evidence["nearest"]
    cost = near["translation_error"] ** 2 + (0.1 * near["rotation_error"]) ** 2
    limits = world.limits(group)
    rng = np.random.default_rng(1)
    for q in rng.uniform(limits.lower, limits.upper, (400, 6)):
        shift, turn = world.frame_pose("arm::tcp", world.embed(group, q)).distance(target)
        assert shift**2 + (0.1 * turn) ** 2 >= cost - 1e-3


@ENGINES
@pytest.mark.parametrize(("scene", "name"), [("maze_2d", "body"), ("window_3d", "body")])
def test_free_bodies_have_goals_too(engine: str, scene: str, name: str) -> None:
    world = world_by(scene, engine)
    group = world.group(name)
    frame = "exit" if scene == "maze_2d" else "beyond"
    found = ask(world, name, at(Pose.identity(), frame), IkOptions(10, 40))
    wanted = world.frame_pose(frame, world.state)
    reached = world.frame_pose("body::body", world.embed(group, found.positions[0]))
    assert max(reached.distance(wanted)) < 2e-6
    assert found.funnel.distinct == 1
