"""Inverse kinematics under path constraints."""

from functools import partial
from typing import Any

import numpy as np
import pytest

import planning
from planning.domain.geometry.pose import Pose
from planning.domain.goals.funnel import Funnel, funnel_evidence, rejections
from planning.domain.goals.goal import GoalPredicate, PoseGoal, PoseTarget, RegionGoal
from planning.domain.goals.goal_configurations import GoalConfigurations
from planning.domain.request.constraint import (
    KeepIn,
    LockedJoints,
    OrientationCone,
    PathConstraint,
    PathPredicate,
    PlacedBox,
    TightLimits,
)
from planning.domain.request.options import IkOptions
from planning.errors import GoalInCollision, GoalViolatesConstraint
from planning.world.world import World
from tests.clocks import after_looks, no_hurry
from tests.goals.conftest import ENGINES, EXACT, at, world_by

GOAL = PoseGoal((PoseTarget(Pose.identity(), "upper"),), "", EXACT, EXACT)
UP = np.array([0.0, 0.0, 1.0])


def solve(world: World, *constraints: PathConstraint, **arguments: Any) -> GoalConfigurations:
    goal = arguments.pop("goal", GOAL)
    deadline = arguments.pop("deadline", None) or no_hurry(60)
    name = world.groups[0].name
    return planning.solve_ik(
        world, name, goal, deadline=deadline, constraints=constraints, **arguments
    )


def adds_up(funnel: Funnel) -> bool:
    return funnel.num_samples == funnel.distinct + sum(one.count for one in rejections(funnel))


@ENGINES
@pytest.mark.parametrize("joint", [0, 2, 4])
def test_locked_joints_stay_where_they_are_locked(engine: str, joint: int) -> None:
    world = world_by("panda_shelf", engine)
    group = world.group("panda")
    start = world.positions(group)
    found = solve(world, LockedJoints((group.joints[joint].name,)), options=IkOptions(20, 60))
    assert np.abs(found.positions[:, joint] - start[joint]).max() == 0.0
    reached = world.frame_poses(group.tool_frames[0], world.embed(group, found.positions))
    wanted = world.frame_pose("upper", world.state)
    assert all(max(Pose.from_matrix(x).distance(wanted)) < 2e-6 for x in reached)
    assert adds_up(found.funnel)


@ENGINES
def test_tightened_limits_are_kept(engine: str) -> None:
    world, options = world_by("panda_shelf", engine), IkOptions(20, 60)
    group = world.group("panda")
    free = solve(world, options=options).positions[:, 4]
    middle = float(np.median(free))
    rule = TightLimits({group.joints[4].name: (middle - 0.1, middle + 0.1)})
    kept = solve(world, rule, options=options)
    assert np.abs(free - middle).max() > 0.1
    assert np.abs(kept.positions[:, 4] - middle).max() <= 0.1 + 1e-9


def test_what_breaks_a_constraint_is_counted_and_made_up_for() -> None:
    world = world_by("panda_shelf", "kernel")
    group = world.group("panda")
    start = world.positions(group)
    options = IkOptions(max_configurations=6, max_trials=2000)
    rule = PathPredicate(lambda q: bool(q[4] >= start[4] - 0.5), 0.01, "half")
    usual, kept = solve(world, options=options), solve(world, rule, options=options)
    assert not (usual.positions[:, 4] >= start[4] - 0.5).all()
    assert (kept.positions[:, 4] >= start[4] - 0.5).all()
    assert kept.funnel.distinct >= options.max_configurations == len(kept.positions)
    assert kept.funnel.num_samples_violating > 0
    assert adds_up(kept.funnel)
    assert "violate a path constraint" in funnel_evidence(kept.funnel)["summary"]


def test_a_region_is_reached_where_a_cone_allows() -> None:
    world = world_by("panda_shelf", "kernel")
    group = world.group("panda")
    frame = group.tool_frames[0]
    target = Pose.from_parts(world.frame_pose("upper", world.state).position)
    goal = RegionGoal((PoseTarget(target),), "", np.full(3, 0.05), np.full(3, np.inf))
    wanted = world.frame_pose("upper", world.state).matrix[:3, :3]
    cone = OrientationCone(frame, wanted.T @ UP, UP, 0.6)
    options = IkOptions(max_configurations=10, max_trials=3000)
    found = solve(world, cone, goal=goal, options=options)
    reached = world.frame_poses(frame, world.embed(group, found.positions))
    axes = reached[:, :3, :3] @ wanted.T @ UP
    assert np.arccos(np.clip(axes @ UP, -1, 1)).max() <= 0.6 + 1e-9
    assert len(found.positions) == 10


def test_what_no_configuration_keeps_is_named() -> None:
    world = world_by("panda_shelf", "kernel")
    frame = world.group("panda").tool_frames[0]
    here = world.frame_pose(frame, world.state).position
    box = PlacedBox(np.full(3, 0.05), Pose.from_parts(here))
    with pytest.raises(GoalViolatesConstraint) as refusal:
        solve(world, KeepIn(frame, box))
    (entry,) = refusal.value.evidence["violations"]
    assert entry["constraint"].startswith("constraint 0: keep_in")
    assert entry["count"] > 1


def test_a_predicate_goal_says_what_its_configurations_violate() -> None:
    """Some collide as well, and all that do not break the rule."""
    world = world_by("ur5e_pickup", "kernel")
    rule = PathPredicate(lambda q: bool(q[2] == start[2]), 0.01, "here")
    start = world.positions(world.group("arm"))
    options = IkOptions(max_trials=200)
    with pytest.raises(GoalViolatesConstraint) as refusal:
        solve(world, rule, goal=GoalPredicate(lambda q: bool(q[2] != start[2])), options=options)
    (entry,) = refusal.value.evidence["violations"]
    assert entry["count"] > 1


def test_a_goal_that_fails_without_constraints_fails_as_it_does_without() -> None:
    world = world_by("ur5e_pickup", "kernel")
    goal = at(Pose.from_parts([0.45, 0.25, 0.0], rpy=[np.pi, 0, 0.3]))
    options, soon = IkOptions(5, 60), partial(after_looks, 20)
    with pytest.raises(GoalInCollision) as plain:
        solve(world, goal=goal, options=options, deadline=soon())
    with pytest.raises(GoalInCollision) as ruled:
        solve(world, TightLimits({}), goal=goal, options=options, deadline=soon())
    assert ruled.value.evidence.keys() == plain.value.evidence.keys()


def test_the_nearest_pose_and_the_relaxations_keep_the_constraints() -> None:
    world = world_by("ur5e_pickup", "kernel")
    group = world.group("arm")
    goal = at(Pose.from_parts([0.5, -0.2, -0.03], rpy=[np.pi, 0, 0]))
    box = PlacedBox(np.array([2.0, 2.0, 0.4]), Pose.from_parts([0.0, 0.0, 0.3]))
    rules = (KeepIn("arm::tcp", box), TightLimits({"arm::elbow_joint": (0.2, 3.0)}))
    with pytest.raises(GoalInCollision) as refusal:
        solve(world, *rules, goal=goal)
    told = refusal.value.evidence
    relaxation = told["relaxation"]
    found = [told["nearest"], relaxation["position"], relaxation["rotation"], relaxation]
    rows = [one["positions"] for one in found if one is not None and one["positions"] is not None]
    assert len(rows) >= 2
    for q in rows:
        tip = world.frame_pose("arm::tcp", world.embed(group, np.array(q))).position
        assert 0.2 - 1e-6 <= q[2] <= 3.0
        assert 0.1 - 1e-6 <= tip[2] <= 0.5
