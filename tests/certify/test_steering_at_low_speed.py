"""The steering check holds at any speed, however low."""

import numpy as np
import pytest

import planning
from planning.certify.steering_check import CURVATURE_TOLERANCE, SLIP_TOLERANCE, steering_checks
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.report.certificate import Check
from planning.world.world import World
from tests.certify.conftest import request_for
from tests.certify.test_rounded_rates import growing, slopes, value
from tests.clocks import no_hurry
from tests.drivers import assert_driven

DURATIONS = (1.0, 1e3, 2e6, 2e9)


@pytest.fixture(scope="module")
def world() -> World:
    scene = {"name": "s", "robots": [{"name": "c", "model": "car"}]}
    return planning.load_world(planning.parse_scene(scene))


def driven(world: World, duration: float, *ends: float) -> TimedTrajectory:
    """Return a quintic from rest at the origin to rest at x, y and yaw."""
    powers = np.zeros((1, 6, 3))
    for power, factor in ((3, 10.0), (4, -15.0), (5, 6.0)):
        powers[0, power] = factor * np.array(ends) / duration**power
    joints = world.group("c").joints
    return TimedTrajectory(joints, np.array([0.0, duration]), np.zeros((1, 3)), powers)


def steering(world: World, motion: TimedTrajectory) -> Check:
    certificate, _ = planning.certify_trajectory(world, "c", motion, deadline=no_hurry())
    return next(check for check in certificate.checks if check.name.startswith("steering"))


@pytest.mark.parametrize("duration", DURATIONS)
@pytest.mark.parametrize(
    ("ends", "where"),
    [
        ((0.0, 0.0, 0.5), "curvature"),
        ((0.0, 0.0, 1e-4), "curvature"),
        ((0.0, 1.0, 0.0), "sideways"),
        ((0.0, 1e-4, 0.0), "sideways"),
        ((1.0, 3 * SLIP_TOLERANCE, 0.0), "sideways"),
    ],
)
def test_motions_that_a_car_cannot_drive_are_refused_at_any_speed(
    world: World, duration: float, ends: tuple[float, ...], where: str
) -> None:
    check = steering(world, driven(world, duration, *ends))
    assert not check.passed
    assert check.where == where
    assert check.value > check.bound


@pytest.mark.parametrize("duration", DURATIONS)
@pytest.mark.parametrize(
    "ends", [(1.0, 0.0, 0.0), (-3.0, 0.0, 0.0), (1.0, 0.3 * SLIP_TOLERANCE, 0.0)]
)
def test_motions_that_a_car_can_drive_are_proven_at_any_speed(
    world: World, duration: float, ends: tuple[float, ...]
) -> None:
    check = steering(world, driven(world, duration, *ends))
    assert check.passed
    assert 0 <= check.value <= check.bound <= 1 + CURVATURE_TOLERANCE


@pytest.mark.parametrize("slowness", [1.0, 1e3, 1e6])
def test_a_planned_drive_is_proven_however_slowed(world: World, slowness: float) -> None:
    goal = planning.JointGoal(np.array([[0.6, 0.4, 1.2]]))
    found = planning.plan(planning.PlanningProblem("c", goal, seed=1), world, deadline=no_hurry())
    slow = found.trajectory.time_scaled(slowness)
    assert steering(world, slow).passed
    radius = world.group("c").steering["c::base_joint"].turning_radius
    assert_driven(found.trajectory, radius, reverse=True, at=(0, 0))
    # A yaw change of a thousandth more than was driven: too tight where it is tightest.
    tighter = np.array(slow.coefficients)
    tighter[:, :, 2] *= 1.002
    bases = np.array(slow.bases)
    bases[:, 2] *= 1.002
    broken = TimedTrajectory(slow.joints, slow.breaks, bases, tighter)
    assert not steering(world, broken).passed


def test_a_drive_slower_than_its_rounding_error_is_not_proven(world: World) -> None:
    """Straight on, with cancelling terms: the rounding error exceeds the neglected speed."""
    powers = growing(np.random.default_rng(3), 30, 1.0)
    joints = world.group("c").joints
    coefficients = powers[None, :, None] * np.array([1.0, 0.0, 0.0])
    motion = TimedTrajectory(joints, np.array([0.0, 1.0]), np.zeros((1, 3)), coefficients)
    times = np.linspace(0.5, 1.0, 20)
    seen = motion.tangents(times, 1)[:, 0]
    true = [value(slopes(powers), t) for t in times.tolist()]
    assert np.abs(seen - true).max() > 1e-9
    (check,) = steering_checks(request_for(world, "c", motion))
    assert not check.passed
    assert check.where == "unproven"
