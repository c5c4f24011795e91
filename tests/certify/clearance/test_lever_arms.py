"""No point moves farther per joint displacement than its lever arm, at any configuration."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.geometry import Sphere
from pydrake.math import RigidTransform

from planning.certify.clearance.collision_shapes import collision_shapes
from planning.certify.clearance.lever_arms import lever_arms_of
from planning.certify.request import CertifyRequest
from planning.certify.samples.deviation import Deviations
from planning.domain.robot.joints import JointType
from planning.world.collision.margins import PairMargins
from tests.certify.chains import FLOATING, Builder, P, R, Robot, random_robot, random_trajectory
from tests.certify.clearance.test_motion_bounds import poses
from tests.profiles import num_cases


def request_of(robot: Robot, reach: float, rng: np.random.Generator) -> CertifyRequest:
    request = robot.request(random_trajectory(rng, robot.group, 2, 0.3), PairMargins(0.0))
    far = np.full(robot.group.num_positions, reach)
    return replace(request, limits=replace(request.limits, lower=-far, upper=far))


@given(seed=st.integers(0, 100_000))
@settings(max_examples=num_cases(8))
def test_no_pair_approaches_by_more_than_its_lever_arms_allow(seed: int) -> None:
    rng = np.random.default_rng(seed)
    robot = random_robot(rng, num_links=4, num_obstacles=1)
    levers = lever_arms_of(robot.model, request_of(robot, 2.0, rng))
    if any(joint.type is FLOATING for joint in robot.group.joints):
        assert np.isinf(levers).any()
        return
    shapes = collision_shapes(robot.model)
    for _ in range(6):
        q = rng.uniform(-1.9, 1.9, robot.group.num_positions)
        step = rng.normal(0.0, 10.0 ** rng.uniform(-6, -1), len(q))
        centers = []
        for place in (q, q + step):
            rotations, positions = poses(robot, place)
            own = np.einsum("sij,sj->si", rotations[shapes.bodies], shapes.centers)
            centers.append(own + positions[shapes.bodies])
        gaps = [np.linalg.norm(c[:, None] - c[None], axis=2) for c in centers]
        moved = np.abs(step) > 0
        allowed = float((levers[moved] * np.abs(step)[moved]).sum())
        assert float(np.abs(gaps[1] - gaps[0]).max()) <= allowed + 1e-12


def test_the_lever_of_an_arm_is_its_length() -> None:
    builder = Builder()
    ahead = RigidTransform(np.array([0.4, 0.0, 0.0]))
    builder.link(R, Sphere(0.05))
    builder.link(P, Sphere(0.05), 0, ahead, axis=np.array([1.0, 0.0, 0.0]))
    builder.link(R, Sphere(0.1), 1, ahead, x_bg=RigidTransform(np.array([0.3, 0.0, 0.0])))
    request = request_of(robot := builder.build(), 0.2, np.random.default_rng(0))
    levers = lever_arms_of(robot.model, request)
    # 0.4 ahead, at most 0.4 from one limit of the slide to the other, 0.4 and 0.3 more, a radius.
    assert levers == pytest.approx([0.4 + 0.4 + 0.4 + 0.3 + 0.1, 1.0, 0.3 + 0.1])


@given(seed=st.integers(0, 100_000))
@settings(max_examples=num_cases(8))
def test_deviations_bound_those_at_dense_samples(seed: int) -> None:
    rng = np.random.default_rng(seed)
    builder = Builder()
    for kind in (R, P, JointType.PLANAR):
        builder.link(kind, Sphere(0.1))
    robot = builder.build()
    one = random_trajectory(rng, robot.group, 3, 0.5)
    other = random_trajectory(rng, robot.group, 2, 0.5).time_scaled(1.0)
    other = other.time_scaled(one.duration / other.duration)
    rows = Deviations(one, other.breaks).of(other)
    bound = rows.max(axis=0)
    times = np.linspace(0, one.duration * (1 - 1e-12), 3001)
    apart = one.manifold.minus(one.positions(times), other.positions(times))
    seen = np.abs(apart).max(axis=0)
    wraps = np.array(one.manifold.wraps)
    assert (seen[~wraps] <= bound[~wraps] + 1e-9).all()
    assert (seen[wraps] <= np.maximum(bound[wraps], np.pi) + 1e-9).all()
    assert (bound[~wraps] <= 40 * seen[~wraps] + 1e-9).all()
    # Each row holds on its own interval.
    begins = np.union1d(one.breaks, other.breaks)[:-1]
    here = rows[np.searchsorted(begins, times, side="right") - 1]
    assert (np.abs(apart[:, ~wraps]) <= here[:, ~wraps] + 1e-9).all()
    same = Deviations(one, other.breaks).of(one).max(axis=0)
    assert same.max() <= 1e-12
