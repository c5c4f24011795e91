"""The nearest pose satisfies path constraints; suggested relaxations suffice."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

import planning
from planning.domain.geometry.pose import Pose
from planning.domain.goals.goal import PoseGoal, PoseTarget, RegionGoal, RelativeGoal
from planning.domain.goals.goal_configurations import GoalConfigurations
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
)
from planning.domain.request.deadline import Deadline
from planning.domain.request.options import IkOptions, PoseMetric
from planning.domain.request.problem import PlanningProblem
from planning.errors import GoalViolatesConstraint, PlanningFailure
from planning.goals.ik.pose_solvers import kernel_pose_solver
from planning.goals.start_validation import within_limits
from planning.goals.targets.tool_target import ToolTarget
from planning.kernel.native import native
from planning.world.constraints.path_constraints import PathConstraints
from planning.world.world import World
from tests.clocks import after_looks, no_hurry
from tests.goals.conftest import EXACT, TRIES, at, world_by
from tests.goals.diagnosis.test_nearest_pose import cost_of, nearer_tries
from tests.profiles import num_cases

NAME, UP = "ur5e_pickup", np.array([0.0, 0.0, 1.0])
HIGH = Pose.from_parts([0.38, 0.3, 0.45], rpy=[np.pi, 0.0, 0.3])
TILTED = Pose.from_parts([0.35, 0.3, 0.4], rpy=[np.pi + 0.5, 0.0, 0.3])
UPRIGHT = OrientationCone("arm::tcp", UP, -UP, 0.1)
LOW = KeepIn("arm::tcp", PlacedBox(np.array([2.0, 2.0, 0.6]), Pose.from_parts([0, 0, 0.1])))
OUT = KeepOut("arm::tcp", PlacedBox(np.full(3, 0.3), Pose.from_parts([0.35, 0.3, 0.4])))
PLANE = PositionBand(
    "arm::tcp", PlacedBox(np.array([np.inf, np.inf, 0.002]), Pose.from_parts([0, 0, 0.4]))
)
FAR = DistanceBand(("arm::left_finger",), ("box",), 0.2, np.inf)
# A pose, what it breaks, and how far off the nearest is by the geometry of it [m, rad].
CASES: dict[str, tuple[Pose, tuple[PathConstraint, ...], tuple[float, float] | None]] = {
    "cone": (TILTED, (UPRIGHT,), (0.0, 0.4)),
    "low": (HIGH, (LOW,), (0.05, 0.0)),
    "out": (HIGH, (OUT,), (0.1, 0.0)),
    "plane": (HIGH, (PLANE,), (0.049, 0.0)),
    "both": (Pose(HIGH.position, TILTED.quaternion), (UPRIGHT, LOW), (0.05, 0.4)),
    "locked": (HIGH, (LockedJoints(("arm::wrist_1_joint",)),), None),
    "band": (Pose.from_parts([0.5, 0.2, 0.3], rpy=[np.pi, 0, 0]), (FAR,), None),
    "predicate": (HIGH, (PathPredicate(lambda q: bool(np.sin(q[0]) ** 2 > 0.8), 0.01),), None),
}
EVERY = pytest.mark.parametrize("case", CASES)


def solved(
    goal: Any,
    rules: tuple[PathConstraint, ...],
    trials: int = 600,
    until: Deadline | None = None,
) -> GoalConfigurations:
    world, until = world_by(NAME, "kernel"), until or no_hurry()
    options = IkOptions(30, trials)
    return planning.solve_ik(world, "arm", goal, deadline=until, constraints=rules, options=options)


def refused(
    goal: Any, rules: tuple[PathConstraint, ...], until: Deadline | None = None
) -> PlanningFailure:
    with pytest.raises(PlanningFailure) as refusal:
        solved(goal, rules, 100, until)
    return refusal.value


@cache
def refused_in(case: str) -> PlanningFailure:
    pose, rules, _ = CASES[case]
    return refused(at(pose), rules)


def place_of(told: dict[str, Any]) -> Pose:
    return Pose.from_parts(told["position"], told["quaternion"])


def rules_of(world: World, case: str) -> PathConstraints:
    group = world.group("arm")
    return PathConstraints.compiled(world, group, CASES[case][1], world.positions(group))


@EVERY
def test_the_nearest_pose_keeps_the_rules_and_no_try_finds_a_nearer_one(case: str) -> None:
    if native() is None:
        pytest.skip("so many tries take the kernel")
    world, target = world_by(NAME, "kernel"), CASES[case][0]
    group, limits = world.group("arm"), world.limits(world.group("arm"))
    near, rules = refused_in(case).evidence["nearest"], rules_of(world, case)
    q = np.array(near["positions"])
    assert within_limits(limits, q[None])[0]
    assert not world.violations(group, q, world.margins())
    assert not rules.violations(q)
    reached = world.frame_pose("arm::tcp", world.embed(group, q))
    assert max(reached.distance(place_of(near))) < 1e-9
    errors = near["translation_error"], near["rotation_error"]
    assert reached.distance(target) == pytest.approx(errors, abs=1e-9)
    cost = cost_of(reached, target, PoseMetric())
    tries = nearer_tries(target, 0.995 * cost, PoseMetric(), seed=1)
    solver = kernel_pose_solver(
        world, group, [ToolTarget("arm::tcp", pose, EXACT, EXACT) for pose in tries]
    )
    seeds = np.random.default_rng(2).uniform(limits.lower, limits.upper, (TRIES, 6))
    seeds[::2] = q
    converged, rows = solver.solve(seeds, np.arange(TRIES), TRIES)
    good = rows[converged & within_limits(limits, rows)]
    good = good[world.collision_oracle(group, world.margins()).are_free(good)]
    assert len(good) > TRIES // 20
    assert not rules.are_satisfied(good).any()


@pytest.mark.parametrize("case", [name for name, (_, _, errors) in CASES.items() if errors])
def test_where_geometry_says_how_near_it_is_as_near(case: str) -> None:
    near, errors = refused_in(case).evidence["nearest"], CASES[case][2]
    assert errors is not None
    found = np.hypot(near["translation_error"], 0.1 * near["rotation_error"])
    assert found == pytest.approx(np.hypot(errors[0], 0.1 * errors[1]), rel=3e-3)


@EVERY
def test_what_binds_is_the_rule(case: str) -> None:
    failure = refused_in(case)
    near = failure.evidence["nearest"]
    assert near["binding"] == "path_constraint"
    assert near["line"] is None
    assert set(near["constraints"]) <= {rule.label for rule in rules_of_case(case)}
    assert near["constraints"][0] in failure.detail


def rules_of_case(case: str) -> Any:
    return rules_of(world_by(NAME, "kernel"), case).constraints


@EVERY
def test_a_goal_moved_to_the_nearest_pose_is_solved(case: str) -> None:
    near, rules = refused_in(case).evidence["nearest"], CASES[case][1]
    assert len(solved(at(place_of(near["goal"])), rules).positions)


@EVERY
def test_each_constraint_that_is_told_would_do_if_it_were_dropped(case: str) -> None:
    pose, rules, _ = CASES[case]
    relaxation = refused_in(case).evidence["relaxation"]
    told = {entry["constraint"] for entry in relaxation.get("constraints", ())}
    # Of two that are broken none does by itself.
    assert len(told) == (1 if len(rules) == 1 else 0)
    if told:
        assert len(solved(at(pose), ()).positions)


def widened(constraint: PathConstraint, value: float) -> PathConstraint:
    match constraint:
        case OrientationCone():
            return replace(constraint, tolerance=value)
        case KeepIn() | PositionBand():
            return replace(constraint, box=replace(constraint.box, size=grown(constraint, value)))
        case KeepOut():
            return replace(constraint, box=replace(constraint.box, size=grown(constraint, -value)))
        case DistanceBand():
            return replace(constraint, min=value)
        case _:
            raise AssertionError


def grown(constraint: KeepIn | KeepOut | PositionBand, by: float) -> np.ndarray:
    return constraint.box.size + 2 * by


@pytest.mark.parametrize("case", ["cone", "band", "low", "out", "plane"][: num_cases(2, 5)])
def test_a_constraint_that_gives_way_as_told_would_do_and_no_less(case: str) -> None:
    pose, rules, _ = CASES[case]
    (told,) = refused_in(case).evidence["relaxation"]["constraints"]
    found = solved(at(pose), (widened(rules[0], told["value"]),))
    assert len(found.positions)
    less = told["value"] + 0.02 * (told["bound"] - told["value"])
    refused(at(pose), (widened(rules[0], less),), after_looks(30))


def test_other_goals_of_a_tool_have_nearest_poses_too() -> None:
    """A region is left at its border, and a shift ends where the rule does."""
    region = RegionGoal((PoseTarget(HIGH),), "", np.array([0.02, 0.02, 0.02]), np.full(3, np.pi))
    near = refused(region, (LOW,)).evidence["nearest"]
    assert near["translation_error"] == pytest.approx(0.03, rel=3e-3)
    world = world_by(NAME, "kernel")
    here = world.frame_pose("arm::tcp", world.state)
    ceiling = PlacedBox(np.array([3, 3, 0.1]), Pose.from_parts([0, 0, here.position[2]]))
    up = RelativeGoal(Pose.from_parts([0.0, 0.0, 0.09]), reference="world")
    near = refused(up, (KeepIn("arm::tcp", ceiling),)).evidence["nearest"]
    assert near["translation_error"] == pytest.approx(0.04, rel=3e-3)


def test_a_rule_that_only_the_approach_breaks_binds() -> None:
    pose = Pose.from_parts([0.38, 0.3, 0.33], rpy=[np.pi, 0.0, 0.3])
    goal: PoseGoal = replace(at(pose), approach=np.array([0.0, 0.0, -0.1]))
    failure = refused(goal, (LOW,))
    assert isinstance(failure, GoalViolatesConstraint)
    near = failure.evidence["nearest"]
    assert near["constraints"] == ["constraint 0: keep_in"]
    assert near["translation_error"] <= 0.0305
    moved = replace(goal, targets=(PoseTarget(place_of(near["goal"])),))
    assert len(solved(moved, (LOW,)).positions)
    (told,) = failure.evidence["relaxation"]["constraints"]
    assert told["value"] == pytest.approx(0.03, abs=1e-3)


def test_plans_say_the_same() -> None:
    pose, rules, _ = CASES["both"]
    world = world_by(NAME, "kernel")
    problem = PlanningProblem("arm", at(pose), ik=IkOptions(30, 100), constraints=rules)
    with pytest.raises(GoalViolatesConstraint) as refusal:
        planning.plan(problem, world, deadline=no_hurry())
    said, known = refusal.value.evidence, refused_in("both").evidence
    assert said["nearest"] == known["nearest"]
    assert said["relaxation"] == known["relaxation"]
