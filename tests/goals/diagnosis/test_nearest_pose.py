"""The nearest pose is feasible; suggested relaxations suffice."""

import re
from dataclasses import replace
from functools import cache
from itertools import product
from typing import Any

import numpy as np
import pytest

import planning
from planning.domain.geometry import rotation
from planning.domain.geometry.pose import Pose
from planning.domain.goals.goal import PoseGoal, PoseTarget, RegionGoal
from planning.domain.request.options import IkOptions, PoseMetric
from planning.errors import GoalInCollision, GoalUnreachable, WayproofError
from planning.goals.find_goals import find_goals
from planning.goals.goal_query import GoalQuery
from planning.goals.ik.pose_solvers import kernel_pose_solver
from planning.goals.start_validation import within_limits
from planning.goals.targets.tool_target import ToolTarget
from planning.kernel.native import native
from planning.world.world import World
from tests.clocks import after_looks, no_hurry
from tests.goals.conftest import EXACT, TRIES, ask, at, world_by
from tests.profiles import num_cases, pairs

NAME = "ur5e_pickup"
PLAIN = PoseMetric()
# In the table, in the box, beyond reach, and where a wrist cannot turn.
PLACES = ((0.45, 0.25, 0.0), (0.5, 0.02, 0.2), (1.0, 0.3, 0.4), (0.0, 0.0, 0.5))


# By another metric three places in a campaign only.
METRED = [
    *product(PLACES, [PLAIN]),
    *product(PLACES[::-1], [PoseMetric(1.0, 0.5)]),
]
# The first is asked by other tests too; of a tilted tool the tolerances have other axes.
BY_ENGINE = [
    ("kernel", PLACES[0], 0.0),
    ("drake", PLACES[1], 0.1),
    # In a campaign only:
    ("kernel", PLACES[0], 0.1),
    ("kernel", PLACES[1], 0.1),
    ("drake", PLACES[0], 0.1),
]


def refused(world: World, goal: PoseGoal | RegionGoal, **options: Any) -> dict[str, Any]:
    with pytest.raises((GoalInCollision, GoalUnreachable)) as refusal:
        ask(world, "arm", goal, IkOptions(5, 60, **options))
    return refusal.value.evidence


def refused_at(
    place: tuple[float, ...], metric: PoseMetric = PLAIN, engine: str = "kernel", tilt: float = 0.0
) -> dict[str, Any]:
    """Return what is said of a pose that looks down at a place, asking once only."""
    return _refused_at(place, metric, engine, tilt)


@cache
def _refused_at(*case: Any) -> dict[str, Any]:
    place, metric, engine, tilt = case
    return refused(world_by(NAME, engine), at(looking_down(place, tilt)), pose_metric=metric)


def looking_down(place: tuple[float, ...], tilt: float = 0.0) -> Pose:
    return Pose.from_parts(place, rpy=[np.pi, tilt, 0.3])


def cost_of(pose: Pose, target: Pose, metric: PoseMetric) -> float:
    shift, turn = pose.distance(target)
    return float(np.hypot(metric.translation * shift, metric.rotation * turn))


def nearer_tries(target: Pose, cost: float, metric: PoseMetric, seed: int) -> list[Pose]:
    """Return 2,000 poses that are nearer than a cost."""
    rng = np.random.default_rng(seed)
    aside = rng.normal(size=(TRIES, 6))
    aside *= (cost * rng.uniform(size=TRIES) ** (1 / 6) / np.linalg.norm(aside, axis=1))[:, None]
    turned = rotation.multiply(target.quaternion, rotation.exp(aside[:, 3:] / metric.rotation))
    shifted = target.position + aside[:, :3] / metric.translation
    return [Pose(*parts) for parts in zip(shifted, turned, strict=True)]


@pytest.mark.campaign
@pytest.mark.parametrize(("place", "metric"), METRED[: num_cases(3, 8)])
def test_the_nearest_pose_is_feasible_and_no_try_finds_a_nearer_one(
    place: tuple[float, ...], metric: PoseMetric
) -> None:
    if native() is None:
        pytest.skip("so many tries take the kernel")
    world = world_by(NAME, "kernel")
    group, margins = world.group("arm"), world.margins()
    target = looking_down(place)
    near = refused_at(place, metric)["nearest"]
    q, limits = np.array(near["positions"]), world.limits(group)
    assert within_limits(limits, q[None])[0]
    assert not world.violations(group, q, margins)
    reached = world.frame_pose("arm::tcp", world.embed(group, q))
    told = Pose.from_parts(near["position"], near["quaternion"])
    assert max(reached.distance(told)) < 1e-9
    assert reached.distance(target) == pytest.approx(
        (near["translation_error"], near["rotation_error"]), abs=1e-9
    )
    cost = cost_of(reached, target, metric)
    tries = nearer_tries(target, 0.995 * cost, metric, seed=1)
    solver = kernel_pose_solver(
        world, group, [ToolTarget("arm::tcp", pose, EXACT, EXACT) for pose in tries]
    )
    seeds = np.random.default_rng(2).uniform(limits.lower, limits.upper, (TRIES, 6))
    seeds[::2] = q
    converged, rows = solver.solve(seeds, np.arange(TRIES), TRIES)
    converged &= within_limits(limits, rows)
    free = world.collision_oracle(group, margins).are_free(rows[converged])
    assert not free.any()


@pytest.mark.campaign
@pytest.mark.parametrize(("engine", "place", "tilt"), BY_ENGINE[: num_cases(2, 5)])
def test_what_would_do_does(engine: str, place: tuple[float, ...], tilt: float) -> None:
    """The nearest pose is within the tolerance that is told, and nothing else is in the way."""
    world = world_by(NAME, engine)
    group, margins = world.group("arm"), world.margins()
    pose = looking_down(place, tilt)
    evidence = refused_at(place, PLAIN, engine, tilt)
    near, relaxation = evidence["nearest"], evidence["relaxation"]
    tolerance = [np.array(relaxation["tolerance"][name]) for name in ("position", "rotation")]
    reached = Pose.from_parts(near["position"], near["quaternion"])
    assert ToolTarget("arm::tcp", pose, *tolerance).is_met_by(reached)
    q = np.array(relaxation["positions"])
    there = world.frame_pose("arm::tcp", world.embed(group, q))
    assert max(there.distance(pose)) < 2e-6
    hit = world.violations(group, q, margins)
    assert [list(pair.bodies) for pair in hit] == [one["bodies"] for one in relaxation["obstacles"]]


@pytest.mark.parametrize(("place", "kind"), pairs(PLACES[:3], ["position", "rotation"]))
def test_what_would_do_alone_does_and_nothing_nearer(place: tuple[float, ...], kind: str) -> None:
    world = world_by(NAME, "kernel")
    group, target = world.group("arm"), looking_down(place)
    evidence = refused_at(place)
    near, told = evidence["nearest"], evidence["relaxation"][kind]
    # Out of the table, or back into reach, no turn helps.
    if told is None:
        assert kind == "rotation"
        return
    q = np.array(told["positions"])
    assert not world.violations(group, q, world.margins())
    reached = world.frame_pose("arm::tcp", world.embed(group, q))
    shift, turn = reached.distance(target)
    error, rest = (shift, turn) if kind == "position" else (turn, shift)
    assert error == pytest.approx(told["error"], abs=1e-9)
    assert rest < 2e-6
    cost = np.hypot(near["translation_error"], 0.1 * near["rotation_error"])
    assert cost_of(reached, target, PLAIN) >= 0.995 * cost
    tries = alone_tries(target, 0.97 * error, kind)
    solver = kernel_pose_solver(
        world, group, [ToolTarget("arm::tcp", pose, EXACT, EXACT) for pose in tries]
    )
    limits = world.limits(group)
    seeds = np.random.default_rng(2).uniform(limits.lower, limits.upper, (TRIES, 6))
    seeds[::2] = q
    converged, rows = solver.solve(seeds, np.arange(TRIES), TRIES)
    converged &= within_limits(limits, rows)
    assert not world.collision_oracle(group, world.margins()).are_free(rows[converged]).any()


def alone_tries(target: Pose, radius: float, kind: str) -> list[Pose]:
    """Return 2,000 poses that are only shifted by less than a radius, or only turned."""
    rng = np.random.default_rng(5)
    aside = rng.normal(size=(TRIES, 3))
    aside *= (radius * rng.uniform(size=TRIES) ** (1 / 3) / np.linalg.norm(aside, axis=1))[:, None]
    if kind == "position":
        return [Pose(target.position + row, target.quaternion) for row in aside]
    return [
        Pose(target.position, rotation.multiply(target.quaternion, rotation.exp(row)))
        for row in aside
    ]


@pytest.mark.parametrize("place", PLACES)
def test_a_goal_with_the_tolerance_that_is_told_is_solvable(place: tuple[float, ...]) -> None:
    world = world_by(NAME, "kernel")
    pose = looking_down(place)
    told = refused_at(place)["relaxation"]["tolerance"]
    wide = at(pose, "world", 1.02 * np.array(told["rotation"]) + 1e-3, np.array(told["position"]))
    wide = replace(wide, position_tolerance=1.02 * wide.position_tolerance + 1e-3)
    assert len(ask(world, "arm", wide, IkOptions(1, 3000)).positions)


def test_allowing_the_pairs_that_are_told_makes_it_solvable() -> None:
    path = planning.bundled_folder("scenes") / f"{NAME}.scene.yaml"
    scene = planning.read_scene(path)
    goal = at(looking_down(PLACES[0]))
    obstacles = refused_at(PLACES[0])["relaxation"]["obstacles"]
    pairs = tuple((one["bodies"][0], one["bodies"][1]) for one in obstacles)
    relaxed = replace(scene, allowed_collisions=scene.allowed_collisions + pairs)
    found = ask(planning.load_world(relaxed), "arm", goal, IkOptions(5, 200))
    assert len(found.positions)


def test_what_binds_is_named() -> None:
    world = world_by(NAME, "kernel")
    table = refused_at(PLACES[0])["nearest"]
    assert table["binding"] == "collision"
    assert ["arm::left_finger", "table"] in table["pairs"]
    assert table["translation_error"] == pytest.approx(0.01, abs=1e-4)
    # Straight up out of the box; gradients alone end at its side, with the gripper tilted.
    box = refused(world, at(Pose.from_parts(PLACES[1], rpy=[np.pi, 0, 0])))["nearest"]
    assert box["translation_error"] == pytest.approx(0.0705, abs=2e-4)
    high = refused(world, at(Pose.from_parts([0.4, 0.0, 1.6])))["nearest"]
    assert (high["binding"], high["pairs"], high["joints"]) == ("reach", [], [])


@cache
def without_box() -> World:
    scene = planning.read_scene(planning.bundled_folder("scenes") / f"{NAME}.scene.yaml")
    others = tuple(one for one in scene.objects if one.name != "box")
    return planning.load_world(replace(scene, objects=others))


@pytest.mark.parametrize("place", [(2.5, 1.0, 0.3), (1.2, 0.0, 0.05)])
def test_what_is_out_of_reach_is_blamed_on_an_obstacle_only_if_that_costs(
    place: tuple[float, ...],
) -> None:
    """The arm leans on the box both times; only the second goal is nearer without it."""
    goal = at(Pose.from_parts(place, rpy=[np.pi, 0, 0]))
    near = refused(world_by(NAME, "kernel"), goal)["nearest"]
    alone = refused(without_box(), goal)["nearest"]
    with_it, without = (
        np.hypot(one["translation_error"], 0.1 * one["rotation_error"]) for one in (near, alone)
    )
    assert alone["binding"] == "reach"
    assert near["binding"] == ("collision" if without < 0.99 * with_it else "reach")
    assert bool(near["pairs"]) == (near["binding"] == "collision")


def test_margins_are_kept_by_the_nearest_pose() -> None:
    world = world_by(NAME, "kernel")
    group = world.group("arm")
    goal = at(looking_down(PLACES[0]))
    with pytest.raises(GoalInCollision) as refusal:
        planning.solve_ik(
            world, "arm", goal, deadline=no_hurry(), options=IkOptions(5, 60), margin=0.02
        )
    near = refusal.value.evidence["nearest"]
    assert not world.violations(group, np.array(near["positions"]), world.margins(0.02))
    # 10 mm out of the table, 20 mm above it, and a little aside of the can.
    assert 0.03 <= near["translation_error"] < 0.032


def test_of_many_poses_the_nearest_is_named() -> None:
    world = world_by(NAME, "kernel")
    targets = tuple(PoseTarget(Pose.from_parts([x, 0.3, 0.4])) for x in np.linspace(4.0, 1.2, 12))
    near = refused(world, PoseGoal(targets, "", EXACT, EXACT))["nearest"]
    assert near["pose_index"] == 11


def test_free_bodies_have_nearest_poses_too() -> None:
    world = world_by("window_3d", "kernel")
    (group,) = world.groups
    inside = world.frame_pose(world.scene.objects[0].name, world.state)
    with pytest.raises((GoalInCollision, GoalUnreachable)) as refusal:
        ask(world, group.name, at(inside), IkOptions(5, 20))
    near = refusal.value.evidence["nearest"]
    assert not world.violations(group, np.array(near["positions"]), world.margins())


def refused_after(looks: int) -> WayproofError:
    """Return what is said of a goal in the box when time runs out after so many looks at it."""
    world = world_by(NAME, "kernel")
    group, goal = world.group("arm"), at(looking_down(PLACES[1]))
    query = GoalQuery(group, goal, world.positions(group), world.margins(), IkOptions(5, 60))
    with pytest.raises(
        GoalInCollision, match=r"collide: .+; the shallowest collision is .+-box"
    ) as refusal:
        find_goals(world, query, np.random.default_rng(0), after_looks(looks))
    return refusal.value


@pytest.mark.campaign
def test_what_time_cuts_short_says_so_and_not_what_binds() -> None:
    """Time goes by with every look at the clock: in every place it may run out."""
    settled = refused_at(PLACES[1])["nearest"]
    assert not settled["cut_short"]
    are_cut: list[bool] = []
    for looks in (*np.linspace(4, 90, num_cases(2, 87)).astype(int), 10_000):
        refusal = refused_after(int(looks))
        nearest, relaxation = refusal.evidence["nearest"], refusal.evidence["relaxation"]
        are_cut.append(nearest["cut_short"])
        if are_cut[-1]:
            assert nearest["binding"] is None
            assert relaxation["cut_short"]
            assert not re.search("(blocked|limited) by", refusal.detail)
            assert nearest["translation_error"] > settled["translation_error"] - 1e-4
        else:
            assert nearest == settled
            assert re.search(", (blocked|limited) by ", refusal.detail)
    assert not relaxation["cut_short"]
    # More time never leaves less done.
    assert are_cut == sorted(are_cut, reverse=True)
    assert are_cut[0]
    assert not are_cut[-1]
