"""Bounds on the speed at a cell's ends: safe in between, and not much too low."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planning.domain.curves.curve import derivative
from planning.domain.curves.path import JointPath
from planning.domain.robot.joints import JointType
from planning.retime.blend import blend_corners
from planning.retime.jerk.velocity_bounds import cell_velocity_bounds
from planning.retime.polynomials import norms, to_bernstein
from tests.conftest import group_of, random_waypoints

VELOCITY = np.array([0.7])
SHARES = np.linspace(0.0, 1.0, 501)


def fastest_seen(coefficients: np.ndarray, caps: np.ndarray) -> float:
    """Return the largest |r'| sdot on [0, 1] if both ends are as fast as they may be."""
    powers = SHARES[:, None] ** np.arange(len(coefficients))
    x = caps[0] + (caps[1] - caps[0]) * SHARES
    return float((np.linalg.norm(powers @ coefficients, axis=1) * np.sqrt(x)).max())


@given(seed=st.integers(0, 10_000), degree=st.integers(0, 3), dims=st.integers(1, 3))
def test_no_speed_in_between_exceeds_the_limit(seed: int, degree: int, dims: int) -> None:
    slopes = np.random.default_rng(seed).normal(size=(1, degree + 1, dims))
    sizes = norms(to_bernstein(slopes, np.ones(1)))[:, :, None]
    caps = cell_velocity_bounds(sizes, VELOCITY)
    assert fastest_seen(slopes[0], caps[0]) <= VELOCITY[0] * (1 + 1e-12)


@pytest.mark.parametrize("ratio", [1.0, 1.2, 2.0, 4.0])
def test_linear_slopes_use_the_limit_up(ratio: float) -> None:
    slopes = np.array([[1.0], [ratio - 1.0]])
    caps = cell_velocity_bounds(np.array([[[1.0], [ratio]]]), VELOCITY)
    assert fastest_seen(slopes, caps[0]) == pytest.approx(VELOCITY[0], rel=1e-4)
    # Both ends are slowed by the same factor, not the flatter one to what the steeper one needs.
    assert np.sqrt(caps[0, 0]) == pytest.approx(ratio * np.sqrt(caps[0, 1]), rel=1e-12)


def test_an_end_at_rest_in_the_parameter_does_no_harm() -> None:
    caps = cell_velocity_bounds(
        np.array([[[0.0], [2.0]], [[2.0], [0.0]], [[0.0], [0.0]]]), VELOCITY
    )
    assert np.allclose(caps[:2], (VELOCITY[0] / 2) ** 2)
    assert np.isinf(caps[2]).all()


def test_a_joint_that_turns_back_bounds_the_speed_at_both_ends() -> None:
    # r' from -1 to 1: the norms at both ends are alike, and it is slower in between.
    assert np.allclose(cell_velocity_bounds(np.array([[[1.0], [1.0]]]), VELOCITY), VELOCITY[0] ** 2)


def test_of_several_blocks_the_slowest_counts() -> None:
    group = group_of(*[JointType.REVOLUTE] * 3)
    curve = blend_corners(JointPath(group, random_waypoints(group, 2, 4)), 0.1)
    slopes = to_bernstein(derivative(curve.coefficients, 1), np.diff(curve.breaks))
    limits = np.array([0.5, 1.0, 2.0])
    alone = [cell_velocity_bounds(np.abs(slopes[:, :, [i]]), limits[[i]]) for i in range(3)]
    assert np.array_equal(cell_velocity_bounds(np.abs(slopes), limits), np.min(alone, axis=0))
