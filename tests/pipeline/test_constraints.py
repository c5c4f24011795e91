"""plan() under path constraints: satisfied between samples, by an independent check with Drake."""

from functools import cache

import numpy as np
import pytest

import planning
from planning.domain.geometry.pose import Pose
from planning.domain.goals.goal import ConfigurationGoal, Goal, JointGoal, PoseGoal, PoseTarget
from planning.domain.report.certificate import Check
from planning.domain.report.motion_plan import MotionPlan
from planning.domain.request.constraint import (
    DistanceBand,
    KeepIn,
    KeepOut,
    LockedJoints,
    OrientationCone,
    PathConstraint,
    PathPredicate,
    PlacedBox,
    PositionBand,
    TightLimits,
)
from planning.domain.request.options import RefineOptions, RetimeOptions, SearchOptions
from planning.domain.request.problem import PlanningProblem
from planning.errors import (
    DeadlineExceeded,
    GoalViolatesConstraint,
    ProblemInvalid,
    StartViolatesConstraint,
    UnknownName,
)
from planning.world.world import World
from tests.clocks import after_looks, no_hurry
from tests.conftest import bundled_world
from tests.profiles import num_cases

EMPTY = "robots: [{name: panda, model: panda, positions: home}]"
PILLAR = """
robots: [{name: panda, model: panda, positions: home}]
objects:
  - {name: pillar, shape: {box: [0.08, 0.08, 0.9]}, pose: {position: [0.5, 0.0, 0.45]}}
"""
TOOL = "panda::panda_hand_tcp"
DOWN = np.array([0.0, 0.0, -1.0])
CORNERS = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
LOOSE = np.array([0.0, 0.0, 4.0])


@cache
def empty() -> World:
    return planning.load_world(planning.parse_scene(EMPTY))


@cache
def pillar() -> World:
    return planning.load_world(planning.parse_scene(PILLAR))


def hand_at(x: float, y: float, z: float) -> PoseGoal:
    """Return the goal that the hand points down at a place, turned as it likes."""
    target = PoseTarget(Pose.from_parts([x, y, z], [0, 1, 0, 0]))
    return PoseGoal((target,), TOOL, np.zeros(3), LOOSE)


@cache
def beside_the_pillar() -> np.ndarray:
    until = no_hurry(10.0)
    return planning.solve_ik(
        pillar(), "panda", hand_at(0.45, -0.35, 0.4), deadline=until
    ).positions[0]


def solve(
    world: World, group: str, goal: Goal, *constraints: PathConstraint, **options: object
) -> MotionPlan:
    settings = {"search": SearchOptions(allowed_planning_time=20.0), **options}
    problem = PlanningProblem(group, goal, constraints=constraints, **settings)
    found = planning.plan(problem, world, deadline=no_hurry(20.0))
    assert found.certificate.proven
    return found


def checks_of(found: MotionPlan) -> list[Check]:
    return [check for check in found.certificate.checks if check.name.startswith("constraint ")]


def dense(found: MotionPlan) -> np.ndarray:
    """Return configurations ten times as near as the search looked at them."""
    count = max(1000, int(found.stages.search.length / (found.stages.search.resolution / 10)))
    return found.trajectory.positions(np.linspace(0.0, found.trajectory.duration, count))


def flat_distances(world: World, qs: np.ndarray) -> np.ndarray:
    """Return the distances of the L from the walls, shape (n,): corners from sides; none crosses.

    Drake's own distances of boxes are sometimes too large (ADR 6).
    """
    cosine, sine = np.cos(qs[:, 2]), np.sin(qs[:, 2])
    turns = np.array([[cosine, -sine], [sine, cosine]]).transpose(2, 0, 1)
    places = qs[:, None, :2]
    smallest = np.full(len(qs), np.inf)
    for center, size in (((0.025, -0.025), (0.2, 0.05)), ((-0.05, 0.02), (0.05, 0.14))):
        corners = np.array(center) + CORNERS * np.array(size) / 2
        placed = places + corners @ turns.transpose(0, 2, 1)
        for wall in world.scene.objects:
            half = wall.shape.size[:2] / 2
            middle = wall.pose.position[:2]
            out = np.maximum(np.abs(placed - middle) - half, 0.0)
            back = (middle + CORNERS * half - places) @ turns - np.array(center)
            into = np.maximum(np.abs(back) - np.array(size) / 2, 0.0)
            for gaps in (out, into):
                smallest = np.minimum(smallest, np.linalg.norm(gaps, axis=2).min(axis=1))
    return smallest


def test_a_band_is_kept_between_samples() -> None:
    world = bundled_world("maze_2d_band")
    found = solve(
        world, "body", ConfigurationGoal("exit"), DistanceBand(None, None, 0.01, 0.05), seed=2
    )
    (check,) = checks_of(found)
    assert check.name == "constraint 0: distance_band"
    assert check.passed
    nearest = flat_distances(world, dense(found))
    assert nearest.min() >= 0.01 - 2e-6
    assert nearest.max() <= 0.05 + 2e-6
    assert found.stages.refine.improved
    # What is told is the end of the band that the motion comes closest to.
    ends = {0.01: float(nearest.min()), 0.05: float(nearest.max())}
    assert check.bound == min(ends, key=lambda bound: abs(ends[bound] - bound))
    assert check.value == pytest.approx(ends[check.bound], abs=2e-3)


@pytest.mark.campaign
@pytest.mark.parametrize("tolerance", [0.4, 0.06][: num_cases(1, 2)])
def test_a_cup_is_kept_upright_around_a_pillar(tolerance: float) -> None:
    world = pillar()
    cone = OrientationCone(TOOL, np.array([0.0, 0.0, 2.0]), DOWN, tolerance)
    goal = hand_at(0.4, 0.4, 0.6)
    found = solve(world, "panda", goal, cone, start=beside_the_pillar(), seed=5)
    plain = solve(
        world,
        "panda",
        goal,
        cone,
        start=beside_the_pillar(),
        seed=5,
        refine=RefineOptions("none"),
    )
    assert found.stages.refine.improved
    assert found.trajectory.duration < 0.95 * plain.trajectory.duration
    poses = world.frame_poses(TOOL, world.embed(world.group("panda"), dense(found)))
    angles = np.arccos(np.clip(poses[:, :3, 2] @ DOWN, -1.0, 1.0))
    (check,) = checks_of(found)
    assert angles.max() <= tolerance + 2e-6
    assert check.value - 1e-6 <= angles.max() <= check.value + check.resolution + 1e-6


def test_without_the_cone_the_cup_is_not_upright() -> None:
    """Else the test above would show nothing."""
    world = pillar()
    found = solve(
        world,
        "panda",
        hand_at(0.4, 0.4, 0.6),
        start=beside_the_pillar(),
        refine=RefineOptions("none"),
        seed=2,
    )
    poses = world.frame_poses(TOOL, world.embed(world.group("panda"), dense(found)))
    assert np.arccos(poses[:, :3, 2] @ DOWN).max() > 0.4
    assert not checks_of(found)


def test_a_plane_and_a_box_are_kept_together() -> None:
    world = pillar()
    start = beside_the_pillar()
    group = world.group("panda")
    plane = PlacedBox(np.array([np.inf, np.inf, 0.06]), Pose.from_parts([0.0, 0.0, 0.4]))
    block = PlacedBox(
        np.array([0.3, 0.2, 0.3]), Pose.from_parts([0.55, -0.05, 0.4], rpy=[0, 0, 0.3])
    )
    constraints = (PositionBand(TOOL, plane), KeepOut(TOOL, block))
    found = solve(world, "panda", hand_at(0.4, 0.35, 0.4), *constraints, start=start, seed=1)
    poses = world.frame_poses(TOOL, world.embed(group, dense(found)))
    assert np.abs(poses[:, 2, 3] - 0.4).max() <= 0.03 + 2e-6
    x_wb = block.pose.matrix
    local = (poses[:, :3, 3] - x_wb[:3, 3]) @ x_wb[:3, :3]
    assert (np.abs(local) - block.size / 2).max(axis=1).min() >= -2e-6
    assert [check.name for check in checks_of(found)] == [
        "constraint 0: position",
        "constraint 1: keep_out",
    ]


def test_locked_joints_do_not_move_and_limits_are_kept() -> None:
    world = empty()
    group = world.group("panda")
    start = world.positions(group)
    goal = start + np.array([1.2, -0.4, 0.0, 0.3, 0.0, 0.5, 0.4])
    names = [joint.name for joint in group.joints]
    constraints = (
        LockedJoints((names[2], names[4])),
        TightLimits({names[1]: (start[1] - 0.45, start[1] + 0.02)}),
    )
    found = solve(world, "panda", JointGoal(goal[None]), *constraints)
    qs = dense(found)
    assert np.abs(qs[:, [2, 4]] - start[[2, 4]]).max() <= 1e-9
    assert qs[:, 1].max() <= start[1] + 0.02 + 1e-6
    assert all(check.passed for check in checks_of(found))


def test_a_goal_that_moves_a_locked_joint_is_refused() -> None:
    world = empty()
    start = world.positions(world.group("panda"))
    with pytest.raises(GoalViolatesConstraint) as caught:
        solve(world, "panda", JointGoal(start[None] + 0.1), LockedJoints(("panda::panda_joint1",)))
    (entry,) = caught.value.evidence["violations"]
    assert entry["count"] == 1
    assert entry["least"]["value"] == pytest.approx(0.1)
    assert caught.value.detail == (
        "the goal configuration violates constraint 0 (locked_joints) by 0.1 rad or m at "
        "panda::panda_joint1 (0.1 rad or m, bound 1e-06 rad or m); the nearest feasible "
        "configuration is 0.1 away (panda::panda_joint1 by -0.1), blocked by "
        "constraint 0: locked_joints"
    )


def test_goals_that_all_violate_are_told_with_every_constraint() -> None:
    world = bundled_world("maze_2d")
    start = world.positions(world.group("body"))
    rows = start + np.array([[0.01, 0.0, 0.0], [0.02, 0.0, 0.0]])
    never = PathPredicate(lambda q: bool(q[0] <= start[0]), 0.05, "is_left")
    box = PlacedBox(np.array([0.03, 1.0, 1.0]), Pose.from_parts([*start[:2], 0.0]))
    with pytest.raises(GoalViolatesConstraint) as caught:
        solve(world, "body", JointGoal(rows), never, KeepIn("body::body", box))
    assert caught.value.detail == (
        "all 2 goal configurations violate path constraints: "
        "2 violate constraint 0 (predicate is_left), which is false; "
        "1 violate constraint 1 (keep_in), at least by 0.005 m (0.005 m, bound 0 m); "
        "the nearest feasible configuration is 0.01 away (body::base_joint.x by -0.01), "
        "blocked by constraint 0: predicate is_left"
    )


def test_a_start_that_violates_is_refused_with_what_was_measured() -> None:
    world = bundled_world("maze_2d")
    band = DistanceBand(None, None, 0.01, 0.05)
    with pytest.raises(StartViolatesConstraint) as caught:
        solve(world, "body", ConfigurationGoal("exit"), TightLimits({}), band)
    (violation,) = caught.value.evidence["violations"]
    assert violation["constraint"] == "constraint 1: distance_band"
    assert violation["value"] == pytest.approx(0.075, abs=1e-5)
    assert violation["bound"] == 0.05
    assert "violates constraint 1 (distance_band) by 0.025 m (0.075 m, bound" in caught.value.detail


def test_goals_that_violate_are_dropped_and_counted() -> None:
    world = bundled_world("maze_2d")
    start = world.positions(world.group("body"))
    rows = start + np.array([[0.0, 0.02, 0.0], [-0.15, 0.0, 0.0]])
    box = PlacedBox(np.array([0.2, 0.3, 1.0]), Pose.from_parts([*start[:2], 0.0]))
    found = solve(world, "body", JointGoal(rows), KeepIn("body::body", box))
    assert found.goal_index == 0
    assert found.stages.goals.funnel.num_goals_violating == 1


def test_a_predicate_is_kept_and_said_to_be_sampled() -> None:
    world = bundled_world("maze_2d")
    start = world.positions(world.group("body"))
    asked: list[np.ndarray] = []

    def goes_round(q: np.ndarray) -> bool:
        asked.append(q)
        return bool(np.linalg.norm(q[:2] - start[:2] + [0.07, 0.0]) > 0.04)

    goal = JointGoal(start[None] - np.array([[0.15, 0.0, 0.0]]))
    found = solve(world, "body", goal, PathPredicate(goes_round, 0.002, "around"))
    (check,) = checks_of(found)
    assert (check.value, check.resolution, check.where) == (
        0.0,
        0.002,
        "sampled every 0.002 rad or m",
    )
    assert not found.stages.search.direct
    gaps = np.linalg.norm(dense(found)[:, :2] - start[:2] + [0.07, 0.0], axis=1)
    assert gaps.min() > 0.04 - 0.002
    assert len(asked) > 100


def test_what_cannot_be_kept_is_not_found() -> None:
    world = bundled_world("maze_2d")
    start = world.positions(world.group("body"))
    box = PlacedBox(np.array([0.02, 10.0, 10.0]), Pose.from_parts([start[0] - 0.07, 0.0, 0.0]))
    goal = JointGoal(start[None] - np.array([[0.15, 0.0, 0.0]]))
    search = SearchOptions(allowed_planning_time=20.0, planner="RRT")
    problem = PlanningProblem(
        "body", goal, search=search, constraints=(KeepOut("body::body", box),)
    )
    with pytest.raises(DeadlineExceeded) as caught:
        planning.plan(problem, world, deadline=after_looks(500))
    assert caught.value.evidence["during"] == "search"
    assert caught.value.evidence["num_goals"] == 1
    assert caught.value.evidence["num_states_checked"] > 100


def test_under_jerk_limits_as_well() -> None:
    world = bundled_world("maze_2d_band")
    start = np.array([0.36, -0.42, 0.0])
    goal = JointGoal(start[None] + np.array([[-0.2, 0.0, 0.0]]))
    band = DistanceBand(("body::body",), ("south", "lower_wall", "east", "lower_spur"), 0.01, 0.05)
    found = solve(world, "body", goal, band, start=start, retime=RetimeOptions(method="ruckig"))
    assert checks_of(found)[0].passed


NONSENSE = [
    (DistanceBand(None, None, 0.05, 0.01), ProblemInvalid, "min < max"),
    (
        DistanceBand(("south",), ("north",), 0.0, 0.01),
        ProblemInvalid,
        "no pair of these bodies",
    ),
    (DistanceBand(("sout",), None, 0.0, 0.01), UnknownName, "did you mean 'south'"),
    (KeepIn("exitt", PlacedBox(np.ones(3))), UnknownName, "'exit'"),
    (KeepIn("exit", PlacedBox(np.array([1.0, 0.0, 1.0]))), ProblemInvalid, "longer than 0"),
    (KeepOut("exit", PlacedBox(np.array([1.0, np.inf, 1.0]))), ProblemInvalid, "finite"),
    (OrientationCone("exit", np.zeros(3), DOWN, 0.1), ProblemInvalid, "axis"),
    (OrientationCone("exit", DOWN, DOWN, 0.0), ProblemInvalid, "tolerance"),
    (LockedJoints(("base_joint",)), UnknownName, "body::base_joint"),
    (TightLimits({"body::base_joint.x": (0.2, 0.1)}), ProblemInvalid, "lower limit"),
    (TightLimits({"body::base_joint.y": (-0.45, -0.45)}), StartViolatesConstraint, "joint_limits"),
    (PathPredicate(bool, 0.0), ProblemInvalid, "resolution"),
]


@pytest.mark.parametrize(("constraint", "error", "words"), NONSENSE)
def test_what_cannot_be_meant_is_refused(
    constraint: PathConstraint, error: type[Exception], words: str
) -> None:
    with pytest.raises(error, match=words):
        solve(bundled_world("maze_2d"), "body", ConfigurationGoal("exit"), constraint)
