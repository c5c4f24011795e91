"""Bounds on the path acceleration along a trajectory."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from planning.domain.curves.curve import TimedTrajectory
from planning.domain.robot.joints import Joint, JointLimits, JointType
from planning.execute.time_scaling import choose_path_acceleration, path_acceleration_bounds
from tests.profiles import num_cases

JOINTS = (Joint("body::base", JointType.PLANAR), Joint("arm::a", JointType.REVOLUTE))
BLOCKS = ((0, 1), (2,), (3,))


def cubic(seed: int) -> TimedTrajectory:
    coefficients = np.random.default_rng(seed).uniform(-1, 1, (1, 4, 4))
    return TimedTrajectory(JOINTS, np.array([0.0, 1.0]), np.zeros((1, 4)), coefficients)


def limits(acceleration: float) -> JointLimits:
    unbounded = np.full(4, np.inf)
    rates = np.full(3, acceleration)
    return JointLimits(-unbounded, unbounded, rates, rates, rates, rates, BLOCKS)


def peak(trajectory: TimedTrajectory, time: float, velocity: float, acceleration: float) -> float:
    """Return the largest norm of a block's acceleration at a path velocity and acceleration."""
    at = np.array([time])
    vdot = trajectory.accelerations(at)[0] * velocity**2
    vdot += trajectory.velocities(at)[0] * acceleration
    return max(float(np.linalg.norm(vdot[list(block)])) for block in BLOCKS)


@settings(max_examples=num_cases(6))
@given(st.integers(0, 10_000), st.floats(0, 1), st.floats(0, 1), st.floats(0, 1))
def test_the_bounds_are_where_a_limit_is_met(
    seed: int, time: float, velocity: float, fraction: float
) -> None:
    bound = 20.0  # such a cubic accelerates by 2 + 6 in a coordinate at most, sqrt(2) 8 in a block
    trajectory = cubic(seed)
    least, largest = path_acceleration_bounds(
        trajectory, limits(bound), np.array([time]), np.array([velocity])
    )
    assert least <= 0 <= largest
    for end in (least, largest):
        assert abs(peak(trajectory, time, velocity, end) - bound) < 1e-6 * bound
    between = least + fraction * (largest - least)
    assert peak(trajectory, time, velocity, between) <= bound * (1 + 1e-9)


def test_all_instants_count() -> None:
    trajectory, times = cubic(7), np.array([0.1, 0.9])
    both = path_acceleration_bounds(trajectory, limits(20.0), times, np.array([0.3, 1.0]))
    first = path_acceleration_bounds(trajectory, limits(20.0), times[:1], np.array([0.3]))
    second = path_acceleration_bounds(trajectory, limits(20.0), times[1:], np.array([1.0]))
    assert both == (max(first[0], second[0]), min(first[1], second[1]))


def test_a_trajectory_beyond_its_limits_may_go_on_as_it_is() -> None:
    trajectory = cubic(1)
    least, largest = path_acceleration_bounds(
        trajectory, limits(1e-3), np.linspace(0, 1, 5), np.ones(5)
    )
    assert least <= 1e-9
    assert largest >= -1e-9


def test_a_trajectory_at_rest_does_not_bound_the_path_acceleration() -> None:
    still = TimedTrajectory(JOINTS, np.array([0.0, 1.0]), np.zeros((1, 4)), np.zeros((1, 4, 4)))
    assert path_acceleration_bounds(still, limits(1.0), np.array([0.5]), np.ones(1)) == (
        -np.inf,
        np.inf,
    )


def test_the_path_velocity_reaches_the_target_within_the_bounds() -> None:
    assert choose_path_acceleration((-100.0, 100.0), 0.3, 0.0, 0.01) * 0.01 == -0.3
    assert choose_path_acceleration((-2.0, 100.0), 0.3, 0.0, 0.01) == -2.0
    assert choose_path_acceleration((-100.0, 5.0), 0.3, 1.0, 0.01) == 5.0
