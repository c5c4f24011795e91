"""What stands outside of Drake's model: every answer is that of a model which has everything."""

from typing import Any

import numpy as np
import pytest

import planning
from planning import scene_summary
from planning.certify.clearance.clearance_check import quick_clearance
from planning.certify.clearance.clearance_reserve import robustness
from planning.certify.clearance.drake_clearance import DrakeProof
from planning.certify.clearance.nearest_points import nearest_points
from planning.domain.geometry.pose import Pose
from planning.domain.request.constraint import DistanceBand
from planning.domain.robot.joints import JointGroup
from planning.errors import PlanningFailure, SceneInvalid, UnknownName
from planning.kernel.native import native
from planning.world.collision.collision_check import DrakeCollisionOracle
from planning.world.collision.collision_pairs import collision_pairs_of
from planning.world.collision.near_static import NearStatic
from planning.world.constraints.body_pairs import banded_pairs
from planning.world.kernel.kernel_scene import kernel_scene_of
from planning.world.mechanics.simulation import Simulation
from planning.world.replay.replay_writer import replay_html
from planning.world.world import World
from tests.certify.conftest import quintic, request_for
from tests.clocks import no_hurry
from tests.conftest import bundled_world
from tests.profiles import num_cases, rng_of, seeds

pytestmark = [
    pytest.mark.campaign,
    pytest.mark.skipif(native() is None, reason="without the kernel Drake has everything"),
]

KINDS = ("box", "sphere", "cylinder", "capsule", "ellipsoid", "convex")
MARGINS = (0.0, 0.01, 0.1)
# Drake's distance of a pair differs by so much with which of both it takes first [m].
ORDER = 1e-5


def shape(kind: str, rng: np.random.Generator) -> dict[str, Any]:
    a, b, c = rng.uniform(0.03, 0.25, 3).tolist()
    match kind:
        case "box" | "ellipsoid":
            return {kind: [a, b, c]}
        case "sphere":
            return {kind: a}
        case "cylinder" | "capsule":
            return {kind: {"radius": a, "length": b}}
        case _:
            return {kind: {"points": rng.uniform(-0.15, 0.15, (12, 3)).tolist()}}


def pose(rng: np.random.Generator) -> dict[str, Any]:
    away = rng.normal(size=3)
    away *= rng.uniform(0.35, 1.0) / np.linalg.norm(away)
    return {"position": away.tolist(), "rpy": rng.uniform(-3, 3, 3).tolist()}


def document(rng: np.random.Generator, count: int = 14) -> dict[str, Any]:
    """Return an arm among objects, one of them held, frames on some, pairs that may touch."""
    things = [
        {"name": f"t{i}", "shape": shape(rng.choice(KINDS), rng), "pose": pose(rng)}
        for i in range(count)
    ]
    held = {"name": "held", "shape": {"box": [0.05, 0.04, 0.1]}, "pose": {"position": [0, 0, 0.1]}}
    held["attached"] = {"frame": "arm::tool0"}
    if rng.random() < 0.5:
        held["attached"]["touch"] = ["arm::wrist_3_link", "arm::tool0", "t3"]
    return {
        "name": "among",
        "robots": [{"name": "arm", "model": "ur5e", "positions": rng.uniform(-2, 2, 6).tolist()}],
        "objects": [held, *things],
        "frames": [
            {"name": "on_it", "parent": "on_t1", "pose": pose(rng)},
            {"name": "on_t1", "parent": "t1", "pose": pose(rng)},
            {"name": "on_tool", "parent": "arm::tool0", "pose": pose(rng)},
            {"name": "on_that", "parent": "on_tool", "pose": pose(rng)},
        ],
        "allowed_collisions": [["t0", "arm::forearm_link"], ["t2", "held"], ["t1", "t2"]],
        "margins": [{"bodies": ["t1", "arm::wrist_1_link"], "margin": 0.05}],
    }


def both(text: dict[str, Any]) -> tuple[World, World]:
    """Return a scene with its objects outside of Drake's model, and inside."""
    scene = planning.parse_scene(text)
    apart = planning.load_world(scene)
    whole = planning.load_world(scene, all_in_drake=True)
    assert len(apart.drake.static_objects) == sum(thing.attached is None for thing in scene.objects)
    assert not len(whole.drake.static_objects)
    return apart, whole


def configurations(world: World, group: JointGroup, count: int, seed: int) -> np.ndarray:
    limits = world.limits(group)
    return rng_of(seed).uniform(limits.lower, limits.upper, (count, len(limits.lower)))


@pytest.fixture(scope="module", params=seeds(2, 40))
def pair(request: pytest.FixtureRequest) -> tuple[World, World]:
    return both(document(rng_of(request.param)))


def test_names_pairs_and_frames_are_the_same(pair: tuple[World, World]) -> None:
    apart, whole = pair
    assert scene_summary(apart) == scene_summary(whole)
    names = [sorted(map(sorted, collision_pairs_of(world.drake).pair_names)) for world in pair]
    assert names[0] == names[1]
    full = whole.embed(whole.group("arm"), configurations(whole, whole.group("arm"), 5, 1))
    for frame in scene_summary(whole).frames:
        theirs = whole.frame_poses(frame, full)
        assert apart.frame_poses(frame, full).tobytes() == theirs.tobytes()
        assert apart.frame_pose(frame, full[0]) == whole.frame_pose(frame, full[0])


@pytest.mark.parametrize("margin", MARGINS)
def test_verdicts_are_the_same_by_the_kernel_and_by_drake(
    pair: tuple[World, World], margin: float
) -> None:
    apart, whole = pair
    group = whole.group("arm")
    qs = configurations(whole, group, num_cases(150, 2_000), 2)
    expected = whole.collision_oracle(group, whole.margins(margin)).are_free(qs)
    assert 0 < expected.mean() < 1
    kernel = apart.collision_oracle(group, apart.margins(margin))
    np.testing.assert_array_equal(kernel.are_free(qs), expected)
    drake = DrakeCollisionOracle(apart.drake, group, apart.state, apart.margins(margin))
    some = slice(None, 40)
    np.testing.assert_array_equal(drake.are_free(qs[some]), expected[some])
    assert [drake.is_free(q) for q in qs[some]] == expected[some].tolist()


@pytest.mark.parametrize("reach", [0.0, 0.02, 0.3])
def test_distances_are_the_same(pair: tuple[World, World], reach: float) -> None:
    apart, whole = pair
    group, margins = whole.group("arm"), whole.margins(0.02)
    probes = [world.distance_probe(margins) for world in pair]
    for q in configurations(whole, group, num_cases(4, 200), 3):
        full = whole.embed(group, q)
        near, expected = (probe.pairs_within(full, reach) for probe in probes)
        assert {p.bodies for p in near} == {p.bodies for p in expected}
        lengths = {p.bodies: p.distance for p in expected}
        assert all(abs(p.distance - lengths[p.bodies]) < ORDER for p in near)
        found = [p.bodies for p in apart.violations(group, q, margins)]
        assert found == [p.bodies for p in whole.violations(group, q, margins)]
        verdicts = [planning.check_configurations(world, "arm", q[None], 0.02)[0] for world in pair]
        assert verdicts[0].valid == verdicts[1].valid
        assert verdicts[0].nearest.bodies == verdicts[1].nearest.bodies
        assert abs(verdicts[0].nearest.distance - verdicts[1].nearest.distance) < ORDER


def test_what_is_shown_to_drake_in_parts_is_the_same(
    pair: tuple[World, World], monkeypatch: pytest.MonkeyPatch
) -> None:
    _, whole = pair
    monkeypatch.setattr("planning.world.collision.near_static.MAX_REGISTERED", 3)
    group, margins = whole.group("arm"), whole.margins()
    probe, expected = (world.distance_probe(margins) for world in pair)
    for q in configurations(whole, group, 4, 4):
        full = whole.embed(group, q)
        near = {p.bodies: p.distance for p in probe.pairs_within(full, 5.0)}
        far = {p.bodies: p.distance for p in expected.pairs_within(full, 5.0)}
        assert near.keys() == far.keys()
        assert all(abs(near[bodies] - far[bodies]) < ORDER for bodies in far)


def motion(world: World, seed: int) -> planning.MotionPlan:
    q = configurations(world, world.group("arm"), 40, seed)
    oracle = world.collision_oracle(world.group("arm"), world.margins())
    free = q[oracle.are_free(q)]
    goal = planning.JointGoal(free[1:2])
    problem = planning.PlanningProblem("arm", goal, start=free[0], seed=seed)
    return planning.plan(problem, world, deadline=no_hurry())


def test_plans_and_certificates_are_the_same_to_the_bit(pair: tuple[World, World]) -> None:
    ours, theirs = (motion(world, 5) for world in pair)
    assert ours.trajectory == theirs.trajectory
    assert ours.certificate == theirs.certificate


def straight(world: World, seed: int) -> tuple[Any, Any]:
    """Return the demand that a straight motion be proven, by Drake or otherwise."""
    group = world.group("arm")
    oracle = world.collision_oracle(group, world.margins())
    for start in configurations(world, group, 400, seed):
        end = start + 0.15
        if oracle.is_free(start) and oracle.is_motion_free(start, end - start, 0.005):
            trajectory = quintic(group, start, end, 1.0)
            return group, request_for(world, "arm", trajectory)
    message = "no straight motion of 0.15 rad is free"
    raise AssertionError(message)


def test_drakes_own_proof_and_robustness_are_the_same(pair: tuple[World, World]) -> None:
    apart, whole = pair
    _, request = straight(whole, 6)
    ours, theirs = (
        DrakeProof(world.drake, request, no_hurry(), 2_000).run() for world in (apart, whole)
    )
    assert ours.check.passed == theirs.check.passed
    assert ours.nearest.bodies == theirs.nearest.bodies
    assert abs(ours.nearest.distance - theirs.nearest.distance) < ORDER
    spare, expected = (robustness(world.drake, request, no_hurry()) for world in (apart, whole))
    assert spare.obstacle_pair == expected.obstacle_pair
    assert spare.obstacle_displacement == pytest.approx(expected.obstacle_displacement, rel=0.02)


def test_drakes_proof_refuses_what_runs_into_what_stands(pair: tuple[World, World]) -> None:
    _, whole = pair
    group, margins = whole.group("arm"), whole.margins()
    oracle = whole.collision_oracle(group, whole.margins())
    qs = configurations(whole, group, 400, 7)
    start = next(q for q in qs if oracle.is_free(q))
    end = next(
        q
        for q in qs
        for near in whole.violations(group, q, margins)
        if not {"t3", "t4", "t5"}.isdisjoint(near.bodies)
    )
    request = request_for(whole, "arm", quintic(group, start, end, 1.0))
    for world in pair:
        assert not DrakeProof(world.drake, request, no_hurry(), 2_000).run().check.passed


def test_nearest_points_are_on_both_shapes(pair: tuple[World, World]) -> None:
    apart, whole = pair
    _, request = straight(whole, 6)
    points = []
    for world in (apart, whole):
        spot = quick_clearance(world.drake, request, no_hurry()).nearest
        points.append(nearest_points(world.drake, request, spot)[0])
        assert abs(np.linalg.norm(points[-1][0] - points[-1][1]) - spot.distance) < 1e-3
    np.testing.assert_allclose(points[0], points[1], atol=1e-3)


def test_bands_speak_of_what_stands(pair: tuple[World, World]) -> None:
    apart, whole = pair
    group = whole.group("arm")
    for bodies, to in ((None, None), (("arm::wrist_3_link",), ("t4", "t5")), (("t6",), None)):
        band = DistanceBand(bodies, to, 0.0, 0.4)
        assert banded_pairs(apart, group, band, "b") == banded_pairs(whole, group, band, "b")


def test_inverse_kinematics_says_the_same_of_goals_that_collide() -> None:
    """A goal inside an object: what is nearest and free is found among what stands."""
    pair = both(document(rng_of(1), count=5))
    inside = next(t.pose for t in pair[1].scene.objects if t.name == "t3")
    exact = np.zeros(3)
    goal = planning.PoseGoal((planning.PoseTarget(inside, "world"),), "", exact, exact)
    failures = []
    for world in pair:
        with pytest.raises(PlanningFailure) as refused:
            planning.solve_ik(world, "arm", goal, deadline=no_hurry(), seed=1)
        failures.append(refused.value)
    assert [failure.code for failure in failures] == [failures[0].code] * 2
    assert failures[0].evidence["funnel"] == failures[1].evidence["funnel"]


@pytest.mark.parametrize("name", ["t1", "on_t1", "on_it", "arm::tool0", "on_that"])
def test_frames_are_where_drake_has_them_and_move_alike(name: str) -> None:
    found = []
    for world in both(document(rng_of(3))):
        frame, plant = world.drake.frame(name), world.drake.plant
        context = plant.CreateDefaultContext()
        plant.SetPositions(context, world.state)
        jacobian = frame.velocity_jacobian(plant, context)
        in_world = plant.get_body(frame.body).body_frame().CalcPoseInWorld(context)
        pose = frame.pose(context).GetAsMatrix4()
        np.testing.assert_allclose(in_world.multiply(frame.pose_in_body).GetAsMatrix4(), pose)
        found.append((pose, jacobian))
        assert jacobian.any() == ("t1" not in name and name != "on_it")
    np.testing.assert_allclose(found[0][0], found[1][0], atol=1e-12)
    np.testing.assert_allclose(found[0][1], found[1][1], atol=1e-12)


@pytest.mark.parametrize("seed", seeds(3))
def test_a_half_space_changes_no_distance_of_others(seed: int) -> None:
    text = document(rng_of(seed), count=6)
    floor = {"name": "floor", "shape": {"half_space": {}}, "pose": {"position": [0, 0, -0.1]}}
    scenes = [text, {**text, "objects": [*text["objects"], floor]}]
    worlds = [planning.load_world(planning.parse_scene(scene)) for scene in scenes]
    probes = [world.distance_probe(world.margins()) for world in worlds]
    group, bodies = worlds[0].group("arm"), set()
    for q in rng_of(seed).uniform(-2, 2, (20, 6)):
        alone, beside = (
            {pair.bodies: pair.distance for pair in probe.pairs_within(world.embed(group, q), 0.4)}
            for probe, world in zip(probes, worlds, strict=True)
        )
        assert {pair: d for pair, d in beside.items() if "floor" not in pair} == alone
        bodies |= {name for pair in beside for name in pair}
    assert {"floor", "t0"} <= bodies


def test_an_unknown_frame_is_told_with_the_nearest() -> None:
    apart, _ = both(document(rng_of(3)))
    with pytest.raises(UnknownName, match="did you mean 't1'"):
        apart.validate_frame("T1")


def test_replays_show_what_stands() -> None:
    apart, _ = both(document(rng_of(4), count=5))
    group = apart.group("arm")
    q = apart.positions(group)
    page = replay_html(apart, group, quintic(group, q, q + 0.1, 0.2))
    assert page


def test_an_execution_that_touches_what_stands_ends() -> None:
    """A box right under the tool: the simulated arm is let down onto it."""
    world = bundled_world("ur5e_pickup")
    group = world.group("arm")
    tip = world.frame_pose("arm::tool0", world.state).position
    box = {"name": "under", "shape": {"box": [0.3, 0.3, 0.02]}}
    box["pose"] = {"position": (tip - [0, 0, 0.35]).tolist()}
    text = {"name": "t", "robots": [{"name": "arm", "model": "ur5e", "positions": "home"}]}
    ends, down = [], np.array([0.0, 0.5, 0.0, 0.0, 0.0, 0.0])
    for whole in (False, True):
        scene = planning.parse_scene({**text, "objects": [box]})
        placed = planning.load_world(scene, all_in_drake=whole)
        start = placed.positions(group)
        simulation = Simulation(placed, group, start)
        touched, time = (), 0.0
        while not touched and time < 3.0:
            time += 0.02
            simulation.command(start + time * down, down, np.zeros(6))
            touched = simulation.advance_to(time)
        ends.append((touched[0].bodies, time))
    assert ends[0][0] == ends[1][0]
    assert "under" in ends[0][0]
    assert abs(ends[0][1] - ends[1][1]) <= 0.021


def test_too_many_pairs_and_too_many_objects_for_drake_are_refused(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scene = planning.parse_scene(document(rng_of(8)))
    monkeypatch.setattr("planning.world.collision.collision_pairs.MAX_PAIRS", 20)
    with pytest.raises(SceneInvalid, match="the limit is 20") as refused:
        planning.load_world(scene)
    assert refused.value.evidence["bound"] == 20
    monkeypatch.setattr("planning.world.loading.load_world.MAX_OBJECTS_FOR_DRAKE", 5)
    with pytest.raises(SceneInvalid, match="15 objects exceed the limit of 5") as refused:
        planning.load_world(scene, kernel=False)
    assert refused.value.evidence == {"path": "objects", "count": 15, "bound": 5}


def test_names_are_taken_once_and_shapes_that_do_not_load_are_named() -> None:
    text = document(rng_of(9))
    for change, path in (
        ({"objects": [*text["objects"], text["objects"][0]]}, "objects.15.name"),
        ({"frames": [{"name": "t0"}]}, "frames.0.name"),
        ({"frames": [{"name": "f", "parent": "t99"}]}, "frames.0.parent"),
        ({"allowed_collisions": [["t0", "t99"]]}, "allowed_collisions.0"),
        ({"margins": [{"bodies": ["t0", "t99"], "margin": 0.1}]}, "margins.0.bodies"),
    ):
        scene = planning.parse_scene({**text, **change})
        faults = []
        for whole in (False, True):
            with pytest.raises(SceneInvalid) as refused:
                planning.load_world(scene, all_in_drake=whole)
            faults.append(refused.value)
        assert faults[0].detail == faults[1].detail
        assert faults[0].evidence["path"] == path == faults[1].evidence["path"]


def test_a_chain_of_frames_is_as_long_as_a_scene_may_have() -> None:
    """The scene's bound: 10,000, on a link, with a thing held at the end of them."""
    count = 10_000
    frames = [
        {
            "name": f"f{i}",
            "parent": f"f{i - 1}" if i else "arm::tool0",
            "pose": {"position": [1e-4, 0, 0]},
        }
        for i in range(count)
    ]
    held = {"name": "lid", "shape": {"sphere": 0.01}, "attached": {"frame": f"f{count - 1}"}}
    text = {"name": "chain", "robots": [{"name": "arm", "model": "ur5e"}]}
    world = planning.load_world(
        planning.parse_scene({**text, "objects": [held], "frames": frames[::-1]})
    )
    tool, end = (world.frame_pose(name, world.state) for name in ("arm::tool0", f"f{count - 1}"))
    expected = tool @ Pose.from_parts((1.0, 0.0, 0.0))
    assert max(end.distance(expected)) < 1e-6
    assert max(world.frame_pose("lid", world.state).distance(expected)) < 1e-6


@pytest.mark.parametrize("distance", [0.0, 0.05, 0.3, 2.0])
def test_no_object_that_is_near_is_left_out(distance: float) -> None:
    """Rows of objects by the kernel's kinematics are those by Drake's bounding balls, or more."""
    world = bundled_world("panda_shelf")
    group, model = world.groups[0], world.drake
    limits, rng = world.limits(group), rng_of(3)
    scene, near_static = kernel_scene_of(model), NearStatic.shared(model)
    assert scene is not None
    for _ in range(num_cases(10)):
        full = world.embed(group, rng.uniform(limits.lower, limits.upper))
        near_static.set_positions(full)
        gaps = near_static._ball_gaps()[0].min(axis=0)
        rows = scene.near_objects(full, distance)
        assert set(np.flatnonzero(gaps <= distance)) <= set(rows.tolist())
        assert set(rows.tolist()) <= set(np.flatnonzero(gaps <= distance + 1e-6))
