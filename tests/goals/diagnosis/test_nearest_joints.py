"""The nearest configuration to an infeasible one is feasible; suggested relaxations suffice."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import planning
from planning.domain.geometry.pose import Pose
from planning.domain.goals.goal import ConfigurationGoal, JointGoal
from planning.domain.request.constraint import (
    DistanceBand,
    KeepIn,
    LockedJoints,
    OrientationCone,
    PathConstraint,
    PathPredicate,
    PlacedBox,
    TightLimits,
)
from planning.domain.request.options import IkOptions
from planning.domain.request.problem import PlanningProblem
from planning.domain.robot.joints import JointGroup
from planning.domain.robot.manifold import Manifold
from planning.domain.scene.scene import Scene
from planning.errors import (
    GoalInCollision,
    GoalOutOfLimits,
    GoalTooNear,
    GoalViolatesConstraint,
    PlanningFailure,
)
from planning.world.constraints.path_constraints import PathConstraints
from planning.world.world import World
from tests.clocks import no_hurry
from tests.conftest import bundled_world
from tests.goals.conftest import ENGINES, TRIES, world_by
from tests.profiles import num_cases

PICKUP, BAND = "ur5e_pickup", "maze_2d_band"
SCENES = pytest.mark.parametrize("name", [PICKUP, "panda_shelf", "window_3d", "maze_2d"])
# Leaning on the table, inside the box, and folded into itself.
PLACES = (
    (0.0, -0.2, 0.3, -1.57, -1.57, 0.0),
    (3.451, -2.062, -1.314, 1.805, 4.712, 1.88),
    (0.0, -1.5708, 2.9, -2.5, -1.57, 0.0),
)


def until() -> planning.Deadline:
    return no_hurry(60.0)


def refused(
    world: World, goal: JointGoal | ConfigurationGoal, *rules: PathConstraint, **more: Any
) -> PlanningFailure:
    kinds = GoalInCollision, GoalOutOfLimits, GoalTooNear, GoalViolatesConstraint
    with pytest.raises(kinds) as refusal:
        planning.solve_ik(
            world, world.groups[0].name, goal, deadline=until(), constraints=rules, **more
        )
    return refusal.value


def to(*rows: Any) -> JointGoal:
    return JointGoal(np.array(rows, dtype=float))


def moved(q: np.ndarray, joint: int, by: float) -> np.ndarray:
    return q + by * (np.arange(len(q)) == joint)


@cache
def refused_at(place: tuple[float, ...]) -> dict[str, Any]:
    return refused(world_by(PICKUP, "kernel"), to(place)).evidence


def drawn(world: World, group: JointGroup, rng: np.random.Generator) -> np.ndarray:
    """Return a configuration within limits, free or not."""
    manifold, limits = Manifold(group.joints), world.limits(group)
    anywhere = manifold.plus(world.positions(group), rng.normal(size=manifold.num_velocities))
    lower, upper = np.maximum(limits.lower, -3.0), np.minimum(limits.upper, 3.0)
    bounded = np.isfinite(limits.lower)
    bounded &= np.isfinite(limits.upper)
    lower, upper = np.where(bounded, lower, 0.0), np.where(bounded, upper, 1.0)
    return manifold.normalized(np.where(bounded, rng.uniform(lower, upper), anywhere))


def colliding(world: World, group: JointGroup, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    for _ in range(1000):
        q = drawn(world, group, rng)
        if world.violations(group, q, world.margins()):
            return q
    raise AssertionError


def feasible(
    world: World, group: JointGroup, rows: np.ndarray, rules: PathConstraints | None = None
) -> np.ndarray:
    limits = world.limits(group)
    kept = ((rows >= limits.lower) & (rows <= limits.upper)).all(axis=1)
    kept[kept] = world.collision_oracle(group, world.margins()).are_free(rows[kept])
    if rules is not None:
        kept[kept] = rules.are_satisfied(rows[kept])
    return kept


def nearer(group: JointGroup, q: np.ndarray, distance: float, weights: Any = 1.0) -> np.ndarray:
    """Return 2,000 configurations that are nearer to q than a distance."""
    manifold, rng = Manifold(group.joints), np.random.default_rng(8)
    aside = rng.normal(size=(TRIES, manifold.num_velocities))
    radii = distance * rng.uniform(size=TRIES) ** (1 / manifold.num_velocities)
    return manifold.plus(
        q, aside * (radii / np.linalg.norm(aside, axis=1))[:, None] / np.asarray(weights)
    )


@SCENES
@settings(max_examples=num_cases(3))
@given(st.integers(0, 10_000))
def test_the_nearest_is_feasible_and_no_try_finds_a_nearer_one(name: str, seed: int) -> None:
    world = bundled_world(name)
    group = world.groups[0]
    q = colliding(world, group, seed)
    near = refused(world, to(q)).evidence["nearest"]
    there = np.array(near["positions"])
    limits, manifold = world.limits(group), Manifold(group.joints)
    assert ((limits.lower <= there) & (there <= limits.upper)).all()
    assert not world.violations(group, there, world.margins())
    assert near["distance"] == pytest.approx(manifold.distance(there, q), abs=1e-12)
    assert list(near["differences"]) == list(group.velocity_names)
    assert list(near["differences"].values()) == pytest.approx(manifold.minus(there, q))
    assert near["binding"] == "collision"
    assert near["pairs"]
    assert not feasible(world, group, nearer(group, q, 0.995 * near["distance"])).any()


@ENGINES
def test_with_or_without_the_kernel_it_is_as_near(engine: str) -> None:
    for place in PLACES:
        told = refused(world_by(PICKUP, engine), to(place)).evidence["nearest"]
        assert told["distance"] <= 1.01 * refused_at(place)["nearest"]["distance"]


@pytest.mark.parametrize("place", PLACES)
def test_weights_say_what_is_near(place: tuple[float, ...]) -> None:
    world = bundled_world(PICKUP)
    group = world.group("arm")
    heavy = "arm::shoulder_lift_joint"
    options = IkOptions(joint_weights={heavy: 10.0})
    near = refused(world, to(place), options=options).evidence["nearest"]
    weights = np.array([1.0, 10.0, 1.0, 1.0, 1.0, 1.0])
    there = np.array(near["positions"])
    assert near["distance"] == pytest.approx(np.linalg.norm(weights * (there - place)))
    plain = refused_at(place)["nearest"]
    assert abs(near["differences"][heavy]) <= abs(plain["differences"][heavy]) + 1e-6
    tries = nearer(group, np.array(place), 0.995 * near["distance"], weights)
    assert not feasible(world, group, tries).any()


def test_joints_that_weigh_nothing_go_where_they_like() -> None:
    """With nothing but the wrist to count, the arm need not move its wrist at all."""
    world = bundled_world(PICKUP)
    joints = [joint.name for joint in world.group("arm").joints]
    options = IkOptions(joint_weights=dict.fromkeys(joints[:3], 0.0))
    near = refused(world, to(PLACES[0]), options=options).evidence["nearest"]
    assert near["distance"] < 1e-3


def test_the_same_seed_gives_the_same_answer() -> None:
    world = bundled_world("panda_shelf")
    q = colliding(world, world.groups[0], 3)
    first, second = (refused(world, to(q)).evidence for _ in range(2))
    assert first == second


def test_what_is_out_of_limits_goes_to_the_limit() -> None:
    world = bundled_world(PICKUP)
    group = world.group("arm")
    start, limits = world.positions(group), world.limits(group)
    failure = refused(world, to(moved(start, 5, 9.0)))
    near, relaxation = failure.evidence["nearest"], failure.evidence["relaxation"]
    assert near["positions"] == [*start[:5], limits.upper[5]]
    assert (near["binding"], near["joints"]) == ("limits", ["arm::wrist_3_joint"])
    assert "blocked by the limit of arm::wrist_3_joint" in failure.detail
    assert relaxation["limits"] == failure.evidence["joints"]
    (entry,) = relaxation["limits"]
    assert entry["violation"] == pytest.approx(near["distance"])
    assert (relaxation["obstacles"], relaxation["remove"]) == ([], [])


def test_limits_and_bodies_bind_together() -> None:
    world = bundled_world(PICKUP)
    near = refused(world, to([*PLACES[0][:5], 9.0])).evidence["nearest"]
    assert near["binding"] == "collision"
    assert near["joints"] == ["arm::wrist_3_joint"]


@pytest.mark.parametrize("place", PLACES)
def test_without_the_bodies_that_are_told_it_is_free(place: tuple[float, ...]) -> None:
    scene = planning.read_scene(planning.bundled_folder("scenes") / f"{PICKUP}.scene.yaml")
    relaxation = refused_at(place)["relaxation"]
    told = relaxation["remove"]
    if told is None:
        moving = {name for pair in relaxation["obstacles"] for name in pair["bodies"]}
        assert sum(name.startswith("arm::") for name in moving) >= 2
        return
    assert collisions_without(scene, set(told), place) == []
    for name in told:
        assert collisions_without(scene, set(told) - {name}, place)


def collisions_without(scene: Scene, gone: set[str], place: tuple[float, ...]) -> list[Any]:
    kept = tuple(one for one in scene.objects if one.name not in gone)
    allowed = tuple(pair for pair in scene.allowed_collisions if not gone & set(pair))
    world = planning.load_world(replace(scene, objects=kept, allowed_collisions=allowed))
    return list(world.violations(world.group("arm"), np.array(place), world.margins()))


def test_the_margin_that_is_told_does() -> None:
    """Over the table, free, but nearer to it than what is asked for."""
    world = bundled_world(PICKUP)
    group = world.group("arm")
    free = np.array(refused_at(PLACES[0])["nearest"]["positions"])
    high = moved(free, 1, -0.03)
    told = refused(world, to(high), margin=0.1).evidence["relaxation"]["margin"]
    assert 0.0 < told < 0.1
    found = planning.solve_ik(world, "arm", to(high), deadline=until(), margin=told)
    assert len(found.positions) == 1
    assert not world.collision_oracle(group, world.margins(1.12 * told)).is_free(high)
    assert refused_at(PLACES[0])["relaxation"]["margin"] is None


def test_of_many_the_nearest_and_the_least_wrong_are_told() -> None:
    world = bundled_world(PICKUP)
    start = world.positions(world.group("arm"))
    bad = to(PLACES[0], moved(start, 5, 5 * np.pi), moved(start, 5, 6.3))
    evidence = refused(world, to(*bad.positions[1:])).evidence
    assert evidence["nearest"]["goal_index"] == 1
    assert refused(world, bad).evidence["relaxation"]["goal_index"] in {0, 1, 2}
    near = refused(world, bad).evidence["nearest"]
    assert near["goal_index"] == 2


def test_of_very_many_some_are_looked_at() -> None:
    world = bundled_world(PICKUP)
    rows = np.array(PLACES[0]) + np.linspace(0.0, 0.01, 200)[:, None]
    near = refused(world, to(*rows)).evidence["nearest"]
    assert near["distance"] < refused_at(PLACES[0])["nearest"]["distance"] + 1e-6


def rules_of(world: World) -> dict[str, PathConstraint]:
    group = world.group("arm")
    tool, start = group.tool_frames[0], world.positions(group)
    at = world.frame_pose(tool, world.state)
    middle = Pose.from_parts(at.position, [1, 0, 0, 0])
    return {
        "keep_in": KeepIn(tool, PlacedBox(np.full(3, 0.4), middle)),
        "orientation": OrientationCone(tool, np.array([0.0, 0.0, 1.0]), at.matrix[:3, 2], 0.2),
        "locked_joints": LockedJoints((group.joints[0].name,)),
        "joint_limits": TightLimits({group.joints[1].name: (start[1] - 0.1, start[1] + 0.1)}),
        "predicate": PathPredicate(lambda q: bool(q[2] - q[1] > 2.8), 0.01),
    }


@pytest.mark.parametrize("kind", list(rules_of(bundled_world(PICKUP))))
def test_path_constraints_are_kept_and_named(kind: str) -> None:
    world = bundled_world(PICKUP)
    group, rule = world.group("arm"), rules_of(world)[kind]
    start = world.positions(group)
    away = np.array([-0.8, 0.11, -0.44, 0.01, 0.02, -0.8])
    failure = refused(world, to(start + away), rule)
    assert isinstance(failure, GoalViolatesConstraint)
    near, relaxation = failure.evidence["nearest"], failure.evidence["relaxation"]
    rules = PathConstraints.compiled(world, group, (rule,), start)
    assert feasible(world, group, np.array([near["positions"]]), rules).all()
    assert near["constraints"] == [f"constraint 0: {kind}"]
    assert near["binding"] == "path_constraint"
    assert [entry["constraint"] for entry in relaxation["constraints"]] == near["constraints"]
    tries = nearer(group, start + away, 0.99 * near["distance"])
    assert not feasible(world, group, tries, rules).any()
    goal = to(near["positions"])
    found = planning.solve_ik(world, "arm", goal, deadline=until(), constraints=(rule,))
    assert len(found.positions) == 1
    if kind == "joint_limits":
        problem = PlanningProblem("arm", goal, constraints=(rule,))
        assert planning.plan(problem, world, deadline=until()).certificate.proven


def test_the_band_is_kept_too() -> None:
    world = bundled_world(BAND)
    group = world.groups[0]
    band = DistanceBand(None, None, 0.01, 0.05)
    rules = PathConstraints.compiled(world, group, (band,), world.positions(group))
    rng = np.random.default_rng(4)
    for _ in range(3):
        q = drawn(world, group, rng)
        if feasible(world, group, q[None], rules)[0]:
            continue
        near = refused(world, to(q), band).evidence["nearest"]
        assert feasible(world, group, np.array([near["positions"]]), rules).all()
        tries = nearer(group, q, 0.99 * near["distance"])
        assert not feasible(world, group, tries, rules).any()


@pytest.mark.parametrize("place", PLACES[:2])
def test_a_plan_to_the_nearest_succeeds(place: tuple[float, ...]) -> None:
    world = bundled_world(PICKUP)
    near = refused_at(place)["nearest"]
    problem = PlanningProblem("arm", to(near["positions"]))
    assert planning.plan(problem, world, deadline=until()).certificate.proven


def test_no_time_means_no_nearest_but_what_is_wrong_is_told() -> None:
    world = bundled_world(PICKUP)
    over = no_hurry(0.0)
    with pytest.raises(GoalInCollision) as refusal:
        planning.solve_ik(world, "arm", to(PLACES[1]), deadline=over)
    assert refusal.value.evidence["relaxation"]["obstacles"]
