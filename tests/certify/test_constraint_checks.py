"""Path constraints on the whole interval: what is proven is true, and what is broken is refused."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from planning.certify.certifier import certify
from planning.certify.constraint_checks import constraint_checks
from planning.certify.request import CertifyRequest
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.geometry.pose import Pose
from planning.domain.report.certificate import Check
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
from planning.world.world import World
from tests.certify.conftest import quintic, request_for, world_from
from tests.clocks import no_hurry
from tests.conftest import bundled_world
from tests.profiles import num_cases

TCP = "arm::tcp"
UP = np.array([0.0, 0.0, 1.0])
BALL = """
robots: [{name: body, model: planar_l, positions: [-0.3, 0.0, 0.0]}]
objects:
  - {name: ball, shape: {sphere: 0.05}, pose: {position: [0.0, 0.3, 0.03]}}
"""


def checked(world: World, request: CertifyRequest, *constraints: PathConstraint) -> list[Check]:
    changed = replace(request, constraints=constraints)
    return constraint_checks(world.drake, changed, no_hurry(30.0))


def swing(seed: int) -> tuple[World, CertifyRequest]:
    """Return a random motion of the UR5e; whether it collides does not matter here."""
    world = bundled_world("ur5e_pickup")
    rng = np.random.default_rng(seed)
    q0 = world.positions(world.group("arm"))
    q1 = q0 + rng.normal(0.0, 0.6, 6)
    return world, request_for(world, "arm", quintic(world.group("arm"), q0, q1, 2.0))


def poses_along(world: World, request: CertifyRequest) -> np.ndarray:
    times = np.linspace(0.0, request.trajectory.duration, 1500)
    qs = request.trajectory.positions(times)
    return world.frame_poses(TCP, world.embed(request.group, qs))


def box(size: np.ndarray, pose: Pose) -> PlacedBox:
    return PlacedBox(size, pose)


def angle_case(poses: np.ndarray, rng: np.random.Generator) -> tuple[float, Callable]:
    axis, direction = rng.normal(size=3), rng.normal(size=3)
    units = axis / np.linalg.norm(axis), direction / np.linalg.norm(direction)
    angles = np.arccos(np.clip(poses[:, :3, :3] @ units[0] @ units[1], -1, 1))
    return float(angles.max()), lambda worst: OrientationCone(TCP, axis, direction, worst)


def inside_case(poses: np.ndarray, rng: np.random.Generator) -> tuple[float, Callable]:
    middle = Pose.from_parts(poses[0, :3, 3] + rng.normal(0, 0.1, 3), rpy=rng.normal(size=3))
    local = (poses[:, :3, 3] - middle.position) @ middle.matrix[:3, :3]
    free = np.array([np.inf, 0.0, 0.0])
    worst = float(np.abs(local[:, 1:]).max())
    return worst, lambda half: PositionBand(TCP, box(free + 2 * half, middle))


def outside_case(poses: np.ndarray, rng: np.random.Generator) -> tuple[float, Callable]:
    middle = Pose.from_parts(poses[700, :3, 3] + rng.normal(0, 0.15, 3), rpy=rng.normal(size=3))
    local = (poses[:, :3, 3] - middle.position) @ middle.matrix[:3, :3]
    nearest = float(np.abs(local).max(axis=1).min())
    return -nearest, lambda half: KeepOut(TCP, box(np.full(3, -2 * half), middle))


CASES = [angle_case, inside_case, outside_case]


@pytest.mark.parametrize("case", CASES)
@settings(max_examples=num_cases(4))
@given(seed=st.integers(0, 10_000))
def test_the_verdict_changes_at_the_worst_value(case: Callable, seed: int) -> None:
    world, request = swing(seed)
    worst, constraint = case(poses_along(world, request), np.random.default_rng(seed))
    assume(2e-3 < abs(worst) < 3.0)
    loose, tight = constraint(worst + 1e-3), constraint(worst - 1e-3)
    (kept,) = checked(world, request, loose)
    (broken,) = checked(world, request, tight)
    assert kept.passed
    assert not broken.passed
    assert kept.resolution >= 0
    assert kept.value + kept.resolution <= kept.bound + 2e-6
    assert broken.value > broken.bound
    # Value plus resolution bounds the worst value: for boxes the excess of 1e-3.
    beyond = worst if case is angle_case else 1e-3
    assert beyond <= broken.value + broken.resolution + 1e-9 < np.inf


@settings(max_examples=num_cases(2))
@given(seed=st.integers(0, 10_000))
def test_the_verdict_of_a_band_changes_at_the_worst_distances(seed: int) -> None:
    world = world_from(BALL)
    rng = np.random.default_rng(seed)
    group = world.group("body")
    q0 = np.array([-0.2, rng.uniform(-0.2, 0.05), rng.uniform(-3, 3)])
    q1 = np.array([0.2, rng.uniform(-0.2, 0.05), q0[2] + rng.normal(0, 0.8)])
    request = request_for(world, "body", quintic(group, q0, q1, 2.0))
    distances = np.array([
        ball_distance(q) for q in request.trajectory.positions(np.linspace(0, 2, 1500))
    ])
    low, high = float(distances.min()), float(distances.max())
    assume(low > 5e-3)
    bands = [
        DistanceBand(None, None, low - 1e-3, high + 1e-3),
        DistanceBand(None, ("ball",), low + 1e-3, high + 1e-3),
        DistanceBand(("ball",), None, low - 1e-3, high - 1e-3),
        DistanceBand(None, None, low - 1e-3, np.inf),
    ]
    checks = checked(world, request, *bands)
    assert [check.passed for check in checks] == [True, False, False, True]
    assert checks[1].value == pytest.approx(low, abs=1.1e-3)
    assert -np.inf < checks[1].value - checks[1].resolution <= low + 1e-9
    assert high <= checks[2].value + checks[2].resolution + 1e-9 < np.inf
    assert set(checks[1].where.split("-")) == {"ball", "body::body"}


def ball_distance(q: np.ndarray) -> float:
    """Return the distance of the L from the ball: a loop of its own, without Drake."""
    cosine, sine = np.cos(q[2]), np.sin(q[2])
    flat = np.array([[cosine, sine], [-sine, cosine]]) @ (np.array([0.0, 0.3]) - q[:2])
    gaps = []
    for center, size in (((0.025, -0.025), (0.2, 0.05)), ((-0.05, 0.02), (0.05, 0.14))):
        out = np.maximum(np.abs(flat - np.array(center)) - np.array(size) / 2, 0.0)
        gaps.append(np.hypot(*out) - 0.05)
    return float(min(gaps))


def test_a_violation_between_samples_is_refused() -> None:
    """A bump of 4 ms and 0.02 rad in a joint that stands still at every 10 ms."""
    world, request = swing(1)
    still = request.trajectory.start
    bump = np.zeros((4, 5, 6))
    # 16 u^2 (1 - u)^2 for u in [0, 1], 4 ms long
    for power, factor in ((2, 16.0), (3, -32.0), (4, 16.0)):
        bump[1, power, 3] = 0.02 * factor / 0.004**power
    trajectory = TimedTrajectory(
        request.group.joints, np.array([0.0, 0.503, 0.507, 0.8, 1.0]), np.tile(still, (4, 1)), bump
    )
    changed = replace(request, trajectory=trajectory)
    sampled = trajectory.positions(trajectory.sample_times(0.01))
    assert np.abs(sampled - still).max() < 1e-12
    pose = world.frame_pose(TCP, world.embed(request.group, still))
    axis = pose.matrix[:3, 2]
    constraints = (
        OrientationCone(TCP, UP, axis, 0.015),
        KeepIn(TCP, PlacedBox(np.full(3, 0.002), Pose.from_parts(pose.position))),
        LockedJoints((request.group.joints[3].name,)),
        TightLimits({request.group.position_names[3]: (still[3] - 0.015, still[3] + 0.015)}),
        PathPredicate(lambda q: abs(q[3] - still[3]) < 0.015, 0.001),
        LockedJoints((request.group.joints[2].name,)),
    )
    checks = checked(world, changed, *constraints)
    assert [check.passed for check in checks] == [False] * 5 + [True]
    assert all(0.503 <= check.time <= 0.507 for check in checks[:5])
    certificate, _ = certify(
        world.drake,
        replace(changed, constraints=constraints[:1]),
        no_hurry(30.0),
    )
    assert not certificate.proven
    assert "constraint 0: orientation" in {check.name for check in certificate.failed}


def test_a_moving_reference_frame_is_placed_by_the_start() -> None:
    world, request = swing(2)
    away = OrientationCone(TCP, UP, UP, 0.01, reference=TCP)
    here = KeepIn(TCP, PlacedBox(np.full(3, 0.01), reference=TCP))
    still = quintic(request.group, request.start, request.start, 1.0)
    assert all(
        check.passed for check in checked(world, replace(request, trajectory=still), away, here)
    )
    assert not any(check.passed for check in checked(world, request, away, here))


def test_constraints_hold_for_floating_bodies_too() -> None:
    world = bundled_world("window_3d")
    group = world.group("body")
    q0 = world.positions(group)
    request = request_for(world, "body", quintic(group, q0, q0.copy(), 1.0))
    q1 = np.array(q0)
    q1[4:] += [0.0, 0.1, 0.0]
    moved = request_for(world, "body", quintic(group, q0, q1, 1.0))
    lock = LockedJoints((group.joints[0].name,))
    (still,) = checked(world, request, lock)
    (shifted,) = checked(world, moved, lock)
    assert still.passed
    assert shifted.value == pytest.approx(0.1)
    low, high, name = q0[5] - 0.01, q0[5] + 0.1, group.position_names[5]
    wide, narrow = TightLimits({name: (low, high)}), TightLimits({name: (low, high - 0.01)})
    assert [check.passed for check in checked(world, moved, wide, narrow)] == [True, False]
