"""The native proof: its bounds hold on any robot, and its verdicts are those of the Python one."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from pydrake.geometry import Box, Cylinder, Sphere
from pydrake.math import RigidTransform

from planning.certify.certifier import CertifyRequest, certify
from planning.certify.clearance.clearance_check import check_clearance
from planning.certify.clearance.clearance_result import ClearanceResult
from planning.certify.clearance.collision_shapes import CollisionShapes, collision_shapes
from planning.certify.clearance.native_clearance import native_clearance, prover
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.request.deadline import Deadline
from planning.domain.robot.joints import JointType
from planning.domain.value import digest
from planning.kernel.gjk import separation
from planning.kernel.native import native
from planning.world.collision.margins import PairMargins
from planning.world.kernel.kernel_scene import KernelScene, kernel_scene_of
from tests.certify.chains import (
    FLOATING,
    PLANAR,
    Builder,
    P,
    R,
    Robot,
    random_pose,
    random_robot,
    random_shape,
    random_trajectory,
)
from tests.certify.conftest import quintic, request_for
from tests.certify.oracles import without_kernel
from tests.clocks import no_hurry
from tests.conftest import bundled_world
from tests.profiles import num_cases

pytestmark = pytest.mark.skipif(native() is None, reason="the native code is not built")


def scene_of(robot: Robot) -> KernelScene:
    scene = kernel_scene_of(robot.model)
    assert scene is not None
    return scene


def patient() -> Deadline:
    return no_hurry(60.0)


def natively(robot: Robot, request: CertifyRequest) -> ClearanceResult:
    return native_clearance(scene_of(robot), robot.model, request, patient())


def in_python(robot: Robot, request: CertifyRequest) -> ClearanceResult:
    return check_clearance(without_kernel(robot.model), request, patient())


def placed(robot: Robot, shapes: CollisionShapes, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return R_WG and p_WG of all shapes, by Drake."""
    plant: Any = robot.model.plant
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, robot.model.embed(robot.group, q, robot.state))
    bodies = {int(index): plant.get_body(index) for index in robot.model.body_names}
    poses = [
        plant.EvalBodyPoseInWorld(context, bodies[int(body)]).GetAsMatrix34()
        for body in shapes.bodies
    ]
    R_WG = np.array([x[:, :3] @ shapes.R_BG[i] for i, x in enumerate(poses)])
    p_wg = np.array([x[:, :3] @ shapes.p_bg[i] + x[:, 3] for i, x in enumerate(poses)])
    return R_WG, p_wg


def distance(
    shapes: CollisionShapes, at: tuple[np.ndarray, np.ndarray], a: int, b: int
) -> tuple[float, float]:
    """Return both bounds on a distance, by the Python search, and the distance of the centres."""
    R_WG, p_wg = at

    def support(n: np.ndarray) -> np.ndarray:
        return shapes.support_point(a, R_WG[a], p_wg[a], n) - shapes.support_point(
            b, R_WG[b], p_wg[b], -n
        )

    found = separation(support, p_wg[a] - p_wg[b], np.inf)
    return found.lower, found.upper


def check_bounds(robot: Robot, trajectory: TimedTrajectory, halvings: list[int]) -> None:
    """Compare the bounds on a segment with the distances at some instants in it."""
    request = robot.request(trajectory, PairMargins(0.0))
    scene, shapes = scene_of(robot), collision_shapes(robot.model)
    native_prover = prover(scene, robot.model, request, scene.pair_margins(request.margins))
    begin, end, middle, rows = native_prover.bounds(halvings)
    assert begin < middle < end
    at_middle = placed(robot, shapes, trajectory.positions(np.array([middle]))[0])
    for q in trajectory.positions(np.linspace(begin, end - 1e-9, 7)):
        at = placed(robot, shapes, q)
        for (id_a, id_b), (approach, lower, along) in zip(scene.pairs, rows, strict=True):
            a, b = shapes.rows[id_a], shapes.rows[id_b]
            nearest, farthest = distance(shapes, at, a, b)
            before, _ = distance(shapes, at_middle, a, b)
            if farthest > 0:
                assert max(lower, along) <= farthest + 1e-7
            assert max(lower, along) <= max(nearest, 0.0) + 1e-3
            if before > 0 and farthest > 0:
                assert before - farthest <= approach + 1e-7


@given(seed=st.integers(0, 100_000), halvings=st.lists(st.integers(0, 1), max_size=9))
@settings(max_examples=num_cases(6))
def test_no_pair_is_nearer_than_its_bounds(seed: int, halvings: list[int]) -> None:
    rng = np.random.default_rng(seed)
    robot = random_robot(rng, num_links=4, num_obstacles=2)
    check_bounds(robot, random_trajectory(rng, robot.group, 3, 0.3), halvings)


@given(seed=st.integers(0, 100_000), kind=st.sampled_from([P, R, PLANAR, FLOATING]))
@settings(max_examples=num_cases(6))
def test_no_pair_is_nearer_than_its_bounds_over_disjoint_pieces(seed: int, kind: JointType) -> None:
    rng = np.random.default_rng(seed)
    builder = Builder()
    builder.link(kind, Box(0.8, 0.05, 0.05))
    for i in range(3):
        builder.obstacle(f"thing{i}", random_shape(rng, 0.2), random_pose(rng, 0.5))
    robot = builder.build()
    whole = random_trajectory(rng, robot.group, 3, 0.1)
    # A body that is free to move shall turn only: how it shifts would hide how it turns.
    turns = np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0]) if kind is FLOATING else 1.0
    tears = rng.normal(0.0, 0.2, whole.coefficients[:, 0].shape) * turns
    origin = np.repeat(whole.bases[:1], 3, axis=0)
    if kind is FLOATING:
        origin[:, 4:] = 0.0
    check_bounds(
        robot,
        replace(
            whole,
            bases=whole.manifold.normalized(whole.manifold.plus(origin, tears)),
            coefficients=whole.coefficients * turns,
        ),
        [],
    )


@pytest.mark.parametrize("turned", [0.01, 0.1, 0.3])
def test_a_lever_that_swings_over_a_face_is_bounded_to_second_order(turned: float) -> None:
    builder = Builder()
    # A ball 1 m from the axis, z; the face is on the side of the axis, across the lever.
    builder.link(R, Sphere(0.05), x_bg=RigidTransform(np.array([1.0, 0.0, 0.0])))
    builder.obstacle("thing", Box(0.4, 4.0, 4.0), RigidTransform(np.array([0.4, 0.0, 0.0])))
    robot = builder.build()
    swing = quintic(robot.group, np.array([-turned]), np.array([turned]), 1.0)
    request = robot.request(swing, PairMargins(0.0))
    scene = scene_of(robot)
    native_prover = prover(scene, robot.model, request, scene.pair_margins(request.margins))
    ((_, lower, along),) = native_prover.bounds([])[3]
    nearest = np.cos(turned) - 0.05 - 0.6
    assert nearest - turned**4 <= along <= nearest
    assert lower == pytest.approx(1.0 - 0.05 - 0.6 - 2 * np.sin(turned / 2))


@given(seed=st.integers(0, 100_000))
@settings(max_examples=num_cases(6))
def test_the_bounds_close_in_on_the_distance(seed: int) -> None:
    rng = np.random.default_rng(seed)
    robot = random_robot(rng, num_links=4, num_obstacles=2)
    trajectory = random_trajectory(rng, robot.group, 2, 0.3)
    request = robot.request(trajectory, PairMargins(0.0))
    scene = scene_of(robot)
    native_prover = prover(scene, robot.model, request, scene.pair_margins(request.margins))
    # The direct bound halves with the segment, the other one's slack is quartered.
    coarse, fine = (native_prover.bounds([0] + [1] * count)[3] for count in (9, 12))
    assert (fine[:, 0] <= coarse[:, 0] / 4 + 1e-9).all()
    known = np.isfinite(fine[:, 2])
    assume(known.any())
    assert (fine[known, 2] >= fine[known, 1] - 1e-9).mean() > 0.9


@given(seed=st.integers(0, 100_000), margin=st.sampled_from([0.0, 0.01]))
@settings(max_examples=num_cases(6))
def test_both_proofs_agree_on_random_robots(seed: int, margin: float) -> None:
    rng = np.random.default_rng(seed)
    robot = random_robot(rng, num_links=3, num_obstacles=4)
    trajectory = random_trajectory(rng, robot.group, int(rng.integers(1, 4)), 0.25)
    request = robot.request(trajectory, PairMargins(margin))
    ours, theirs = natively(robot, request), in_python(robot, request)
    refused = [found.check for found in (ours, theirs) if not found.check.passed]
    if len(refused) == 1:
        # The verdicts may differ only where one of them is undecided.
        assert refused[0].resolution > 0
    for check in refused:
        assert check.value - check.resolution <= check.bound
    if not refused and np.isfinite(ours.nearest.distance):
        assert ours.nearest.distance - ours.check.resolution <= theirs.nearest.distance + 1e-6
        assert theirs.nearest.distance - theirs.check.resolution <= ours.nearest.distance + 1e-6


@given(seed=st.integers(0, 1000))
@settings(max_examples=num_cases(6))
def test_both_proofs_agree_on_an_arm(seed: int) -> None:
    world = bundled_world("ur5e_pickup")
    group = world.group("arm")
    q0 = world.positions(group)
    q1 = q0 + np.random.default_rng(seed).normal(0, 0.5, 6)
    request = request_for(world, "arm", quintic(group, q0, q1, 3.0))
    robot = Robot(world.drake, group, world.state)
    ours, theirs = natively(robot, request), in_python(robot, request)
    assert ours.check.passed == theirs.check.passed
    if ours.check.passed:
        assert ours.nearest.distance == pytest.approx(theirs.nearest.distance, abs=2e-3)
        assert ours.num_segments <= theirs.num_segments


def beside_a_wall(gap: float) -> tuple[Robot, CertifyRequest]:
    builder = Builder()
    builder.link(P, Box(0.1, 0.1, 0.1))
    builder.obstacle("wall", Box(0.1, 1.0, 4.0), RigidTransform(np.array([0.1 + gap, 0.0, 0.0])))
    robot = builder.build()
    along = quintic(robot.group, np.zeros(1), np.ones(1), 1.0)
    return robot, robot.request(along, PairMargins(0.0))


def test_to_slide_along_a_wall_takes_few_segments() -> None:
    robot, request = beside_a_wall(1e-5)
    found = natively(robot, request)
    assert found.check.passed
    assert found.num_segments < 10
    assert found.nearest.distance == pytest.approx(1e-5, abs=1e-9)


def test_every_run_gives_the_same_bytes() -> None:
    rng = np.random.default_rng(5)
    robot = random_robot(rng, num_links=3, num_obstacles=4)
    trajectory = random_trajectory(rng, robot.group, 3, 0.2)
    request = robot.request(trajectory, PairMargins(0.0))
    digests = {digest(certify(robot.model, request, patient())) for _ in range(3)}
    assert len(digests) == 1


def test_what_the_interruption_raises_ends_the_proof() -> None:
    builder = Builder()
    builder.link(FLOATING, Cylinder(0.1, 0.1))
    builder.obstacle("wall", Box(0.1, 1.0, 1.0), RigidTransform(np.array([0.1501, 0.0, 0.0])))
    robot = builder.build()
    turned = np.array([np.cos(1.0), 0.0, 0.0, np.sin(1.0), 0.0, 0.0, 0.0])
    request = robot.request(quintic(robot.group, np.eye(7)[0], turned, 1.0), PairMargins(0.0))
    scene = scene_of(robot)
    native_prover = prover(scene, robot.model, request, scene.pair_margins(request.margins))
    calls: list[int] = []

    def interrupt() -> None:
        calls.append(len(calls))
        if len(calls) == 3:
            message = "enough"
            raise RuntimeError(message)

    with pytest.raises(RuntimeError, match="enough"):
        native_prover.prove(interrupt)
    assert len(calls) == 3
    # And the same prover goes on to prove it.
    assert native_prover.prove(lambda: None).outcome.name == "PROVEN"


def test_margins_of_all_pairs_at_once_are_those_of_each() -> None:
    world = bundled_world("panda_shelf")
    scene = kernel_scene_of(world.drake)
    assert scene is not None
    a, b = scene.bodies[-1]
    margins = PairMargins(0.03, {(min(a, b), max(a, b)): 0.07, ("no", "pair"): 1.0})
    assert scene.pair_margins(margins).tolist() == [margins.of(*pair) for pair in scene.bodies]


def test_a_scene_is_read_once() -> None:
    world = bundled_world("maze_2d")
    assert kernel_scene_of(world.drake) is kernel_scene_of(world.drake)


def test_malformed_arrays_are_refused() -> None:
    robot, request = beside_a_wall(0.1)
    scene = scene_of(robot)
    margins = scene.pair_margins(request.margins)
    for changes in (
        {"breaks": np.array([0.0, 0.5, 1.0])},
        {"bases": np.zeros((1, 2))},
        {"coefficients": np.zeros((1, 6, 2))},
    ):
        broken = replace(request, trajectory=replace(request.trajectory, **changes))
        with pytest.raises(ValueError, match=r"bases|breaks|coefficients|break"):
            prover(scene, robot.model, broken, margins)
    with pytest.raises(ValueError, match="margin"):
        prover(scene, robot.model, request, margins[:0])
