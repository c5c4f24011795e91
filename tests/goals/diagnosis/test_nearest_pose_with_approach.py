"""The nearest pose to one without approach has an approach; suggested relaxations suffice."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

import planning
from planning.domain.geometry.pose import Pose
from planning.domain.goals.goal import PoseGoal
from planning.domain.request.options import IkOptions, PoseMetric
from planning.domain.request.problem import PlanningProblem
from planning.errors import ApproachBlocked
from planning.goals.find_goals import GoalQuery
from planning.goals.ik.pose_solvers import kernel_pose_solver
from planning.goals.lines.approach_checker import ApproachChecker
from planning.goals.start_validation import within_limits
from planning.goals.targets.tool_target import ToolTarget
from planning.kernel.native import native
from planning.world.world import World
from tests.clocks import no_hurry
from tests.goals.conftest import EXACT, TRIES, ask, at, world_by
from tests.goals.diagnosis.test_nearest_pose import cost_of, nearer_tries
from tests.profiles import only_campaign

NAME = "ur5e_pickup"
PICK = Pose.from_parts([0.5, 0.3, 0.0955], rpy=[np.pi, 0.0, 0.0])
# From beside the can, and up and away through it.
WAYS = (((0.0, 0.15, -0.05), None), ((0.0, 0.0, -0.1), (0.0, -0.1, -0.02)))
type Way = tuple[float, ...] | None


def asking(approach: Way, retreat: Way, pose: Pose = PICK, **tolerances: Any) -> PoseGoal:
    ways = [None if way is None else np.array(way) for way in (approach, retreat)]
    return replace(at(pose, **tolerances), approach=ways[0], retreat=ways[1])


@cache
def blocked(approach: Way, retreat: Way) -> ApproachBlocked:
    """Return what is said of a goal, asking once only."""
    with pytest.raises(ApproachBlocked) as refusal:
        ask(world_by(NAME, "kernel"), "arm", asking(approach, retreat))
    return refusal.value


def have_lines(world: World, goal: PoseGoal, rows: np.ndarray, poses: list[Pose]) -> np.ndarray:
    """Return whether each row has the goal's lines, were the goal at each of some poses."""
    group = world.group("arm")
    query = GoalQuery(group, goal, world.positions(group), world.margins(), IkOptions())
    targets = [ToolTarget("arm::tcp", pose, EXACT, EXACT) for pose in poses]
    checker = ApproachChecker(world, query, goal, targets, no_hurry())
    return checker.check(rows, np.arange(len(rows)))


@pytest.mark.parametrize(("approach", "retreat"), WAYS)
def test_a_goal_moved_to_the_nearest_pose_is_solved(approach: Way, retreat: Way) -> None:
    world = world_by(NAME, "kernel")
    near = blocked(approach, retreat).evidence["nearest"]
    q = np.array(near["positions"])
    reached = world.frame_pose("arm::tcp", world.embed(world.group("arm"), q))
    assert reached.distance(PICK) == pytest.approx(
        (near["translation_error"], near["rotation_error"]), abs=1e-9
    )
    moved = Pose.from_parts(near["goal"]["position"], near["goal"]["quaternion"])
    assert max(moved.distance(reached)) < 1e-9
    goal = asking(approach, retreat, moved)
    assert have_lines(world, goal, q[None], [moved]).all()
    assert len(ask(world, "arm", goal).positions)


@pytest.mark.parametrize(("approach", "retreat"), WAYS)
def test_no_try_finds_a_nearer_pose_with_lines(approach: Way, retreat: Way) -> None:
    if native() is None:
        pytest.skip("so many tries take the kernel")
    world = world_by(NAME, "kernel")
    group, limits = world.group("arm"), world.limits(world.group("arm"))
    near = blocked(approach, retreat).evidence["nearest"]
    told = Pose.from_parts(near["position"], near["quaternion"])
    cost = cost_of(told, PICK, PoseMetric())
    tries = nearer_tries(PICK, 0.995 * cost, PoseMetric(), seed=1)
    solver = kernel_pose_solver(
        world, group, [ToolTarget("arm::tcp", pose, EXACT, EXACT) for pose in tries]
    )
    seeds = np.random.default_rng(2).uniform(limits.lower, limits.upper, (TRIES, 6))
    seeds[::2] = near["positions"]
    converged, rows = solver.solve(seeds, np.arange(TRIES), TRIES)
    good = np.flatnonzero(converged & within_limits(limits, rows))
    good = good[world.collision_oracle(group, world.margins()).are_free(rows[good])]
    assert len(good) > TRIES // 20
    poses = [tries[i] for i in good]
    assert not have_lines(world, asking(approach, retreat), rows[good], poses).any()


@pytest.mark.parametrize(("approach", "retreat"), WAYS)
def test_what_binds_is_what_stops_the_line_a_little_nearer(approach: Way, retreat: Way) -> None:
    failure = blocked(approach, retreat)
    near = failure.evidence["nearest"]
    assert near["binding"] in {"approach", "retreat"}
    assert (near["line"]["leg"], near["line"]["reason"]) == (near["binding"], "collision")
    assert 0 <= near["line"]["fraction"] < 1
    assert "can" in near["line"]["bodies"]
    assert f"blocked by the {near['binding']}: " in failure.detail


@cache
def world_without(name: str) -> World:
    scene = planning.read_scene(planning.bundled_folder("scenes") / f"{NAME}.scene.yaml")
    others = tuple(one for one in scene.objects if one.name != name)
    frames = tuple(one for one in scene.frames if one.parent != name)
    return planning.load_world(replace(scene, objects=others, frames=frames))


@pytest.mark.parametrize(("approach", "retreat"), WAYS)
def test_without_the_body_that_is_told_it_is_solved(approach: Way, retreat: Way) -> None:
    removal = blocked(approach, retreat).evidence["relaxation"]["remove"]
    found = ask(world_without(removal["body"]), "arm", asking(approach, retreat))
    q = np.array(removal["positions"])
    turned = np.remainder(found.positions - q + np.pi, 2 * np.pi) - np.pi
    assert np.abs(turned).max(axis=1).min() < 1e-3


@pytest.mark.campaign
@only_campaign("to know that no body would do takes 20 s")
def test_no_body_is_told_where_none_is_in_the_way() -> None:
    with pytest.raises(ApproachBlocked) as refusal:
        ask(world_by(NAME, "kernel"), "arm", asking((0.0, 0.0, -0.9), None))
    relaxation = refusal.value.evidence["relaxation"]
    assert not relaxation["cut_short"]
    assert relaxation["remove"] is None


@pytest.mark.parametrize(("approach", "retreat"), WAYS)
def test_the_tolerance_that_is_told_would_do(approach: Way, retreat: Way) -> None:
    """The lines count in the axes of the goal, which stays where it is."""
    world = world_by(NAME, "kernel")
    evidence = blocked(approach, retreat).evidence
    told, goal = evidence["relaxation"]["position"], asking(approach, retreat)
    q = np.array(told["positions"])
    reached = world.frame_pose("arm::tcp", world.embed(world.group("arm"), q))
    shift, turn = reached.distance(PICK)
    assert shift == pytest.approx(told["error"], abs=1e-9)
    assert turn < 2e-6
    assert have_lines(world, goal, q[None], [PICK]).all()
    assert evidence["relaxation"]["rotation"] is None
    tolerance = evidence["relaxation"]["tolerance"]
    if tolerance is not None:
        q = np.array(evidence["nearest"]["positions"])
        assert have_lines(world, goal, q[None], [PICK]).all()


@only_campaign("4 s")
def test_lines_count_where_the_pose_itself_collides() -> None:
    """The nearest free pose to one inside the table cannot be left downwards either."""
    world = world_by(NAME, "kernel")
    pose = Pose.from_parts([0.45, 0.25, 0.0], rpy=[np.pi, 0, 0.3])
    goal = asking(None, (0.0, 0.0, 0.05), pose)
    with pytest.raises(planning.errors.GoalInCollision) as refusal:
        ask(world, "arm", goal, IkOptions(5, 60))
    near = refusal.value.evidence["nearest"]
    moved = Pose.from_parts(near["goal"]["position"], near["goal"]["quaternion"])
    assert near["translation_error"] > 0.045
    assert have_lines(world, goal, np.array([near["positions"]]), [moved]).all()


def test_plans_say_the_same() -> None:
    approach, retreat = WAYS[0]
    world = world_by(NAME, "kernel")
    goal = asking(approach, retreat)
    with pytest.raises(ApproachBlocked) as refusal:
        planning.plan(PlanningProblem("arm", goal), world, deadline=no_hurry())
    said, known = refusal.value.evidence, blocked(approach, retreat).evidence
    assert said["nearest"] == known["nearest"]
    assert said["relaxation"] == known["relaxation"]
