"""The first unproven instant of a clearance proof, which need not be the worst one."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.geometry import Box, Sphere
from pydrake.math import RigidTransform

from planning.certify.certifier import certify
from planning.certify.clearance.clearance_check import quick_clearance
from planning.certify.clearance.first_unproven import with_first_unproven
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.report.certificate import Certificate
from planning.domain.request.deadline import Deadline
from planning.world.collision.margins import PairMargins
from tests.certify.chains import Builder, P, Robot, random_robot, random_trajectory
from tests.certify.conftest import quintic
from tests.clocks import after_looks, no_hurry
from tests.profiles import num_cases

pytestmark = pytest.mark.usefixtures("implementation")


def patient() -> Deadline:
    return no_hurry(30.0)


def located(
    robot: Robot, trajectory: TimedTrajectory, margin: float = 0.0, deadline: Any = None
) -> Certificate:
    request = robot.request(trajectory, PairMargins(margin))
    certificate, _ = certify(robot.model, request, patient())
    return with_first_unproven(robot.model, request, certificate, deadline or patient())


def gauntlet() -> Robot:
    """Return a ball on a rail along z, with a rod that it grazes and then a block in its way."""
    builder = Builder()
    builder.link(P, Sphere(0.05))
    builder.obstacle("rod", Sphere(0.05), RigidTransform(np.array([0.09, 0.0, 0.3])))
    builder.obstacle("block", Box(0.4, 0.4, 0.4), RigidTransform(np.array([0.0, 0.0, 1.0])))
    return builder.build()


def when(motion: TimedTrajectory, position: float) -> float:
    """Return the instant at which a rising motion of one joint reaches a height."""
    times = np.linspace(0.0, motion.duration, 400_001)
    return float(np.interp(position, motion.positions(times)[:, 0], times))


@pytest.mark.parametrize("margin", [0.0, 0.03])
def test_it_is_the_first_contact_not_the_deepest(margin: float) -> None:
    robot = gauntlet()
    motion = quintic(robot.group, np.zeros(1), np.ones(1), 4.0)
    certificate = located(robot, motion, margin)
    touching = 0.3 - np.sqrt((0.1 + margin) ** 2 - 0.09**2)
    first = certificate.first_unproven
    assert certificate.proven_until <= when(motion, touching) <= certificate.proven_until + 1.1e-4
    assert set(first.bodies) == {"robot::link0", "rod"}
    assert first.distance == pytest.approx(margin, abs=1e-4)
    assert np.linalg.norm(first.points[0] - first.points[1]) == pytest.approx(margin, abs=1e-4)
    assert set(certificate.pair) == {"robot::link0", "block"}
    assert certificate.min_clearance < -0.1


@given(seed=st.integers(0, 100_000))
@settings(max_examples=num_cases(3))
def test_the_motion_is_proven_until_then_and_not_after(seed: int) -> None:
    rng = np.random.default_rng(seed)
    robot = random_robot(rng, num_links=1, num_obstacles=2)
    trajectory = random_trajectory(rng, robot.group, 1, 0.4)
    certificate = located(robot, trajectory)
    until = certificate.proven_until
    if not any(check.name == "clearance" for check in certificate.failed):
        assert until == trajectory.duration
        assert certificate.first_unproven is None
        return
    assert 0 <= until < trajectory.duration
    for end, passes in ((0.999 * until, True), (min(until + 2e-4, trajectory.duration), False)):
        if end > 1e-6:
            request = robot.request(trajectory.until(end), PairMargins(0.0))
            assert quick_clearance(robot.model, request, patient()).check.passed == passes


def test_a_motion_that_begins_in_contact_is_proven_until_time_zero() -> None:
    robot = gauntlet()
    certificate = located(robot, quintic(robot.group, np.array([1.0]), np.zeros(1), 1.0))
    assert certificate.proven_until == 0
    assert set(certificate.first_unproven.bodies) == {"robot::link0", "block"}


def test_at_the_deadline_the_time_proven_so_far_is_reported() -> None:
    robot = gauntlet()
    motion = quintic(robot.group, np.zeros(1), np.ones(1), 4.0)
    exact = located(robot, motion)
    early = located(robot, motion, deadline=after_looks(4))
    assert 0 <= early.proven_until < exact.proven_until - 1e-3


@given(at=st.floats(1e-3, 1.0), seed=st.integers(0, 1000))
@settings(max_examples=num_cases(6))
def test_a_motion_until_an_instant_is_its_beginning(at: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    robot = random_robot(rng, num_links=2, num_obstacles=0)
    whole = random_trajectory(rng, robot.group, 3, 0.5)
    part = whole.until(at * whole.duration)
    assert part.duration == at * whole.duration
    times = np.linspace(0.0, part.duration, 20)
    np.testing.assert_allclose(part.positions(times), whole.positions(times), atol=1e-12)
    np.testing.assert_allclose(part.velocities(times), whole.velocities(times), atol=1e-9)
