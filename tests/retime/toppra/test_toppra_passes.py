"""The two passes against toppra's own class, and against properties of every profile."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from toppra.algorithm import TOPPRA
from toppra.constraint import JointAccelerationConstraint, JointVelocityConstraint

from planning.errors import RetimingFailed
from planning.retime.toppra.toppra_passes import squared_speeds
from tests.retime.splines import smooth_spline

VELOCITY, ACCELERATION = 2.0, 10.0


def rows_at(path: object, grid: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return a, b and the bounds on x at the grid points, as toppra's own constraints have them."""
    first, second = path(grid, 1), path(grid, 2)
    a, b = first[:-1] / ACCELERATION, second[:-1] / ACCELERATION
    caps = (VELOCITY / np.abs(first).max(axis=1)) ** 2
    return np.concatenate([a, -a], axis=1), np.concatenate([b, -b], axis=1), caps


@pytest.mark.parametrize("seed", range(4))
def test_speeds_are_those_of_toppra_itself(seed: int) -> None:
    _, path = smooth_spline(seed)
    grid = np.linspace(0, 1, 201)
    limits = np.stack([-np.ones(7), np.ones(7)], axis=1)
    both = [
        JointVelocityConstraint(VELOCITY * limits),
        JointAccelerationConstraint(ACCELERATION * limits, discretization_scheme=0),
    ]
    solver = TOPPRA(both, path, gridpoints=grid, solver_wrapper="seidel")
    wanted = solver.compute_parameterization(0, 0)[1] ** 2
    a, b, caps = rows_at(path, grid)
    found = squared_speeds(grid, (a, b), caps)
    assert np.abs(found - wanted).max() < 1e-5 * wanted.max()


@given(seed=st.integers(0, 10_000))
def test_limits_are_kept_from_rest_to_rest(seed: int) -> None:
    rng = np.random.default_rng(seed)
    grid = np.concatenate([[0.0], np.cumsum(rng.uniform(0.01, 0.2, 20))])
    half = rng.normal(size=(2, 20, 4))
    a, b = (np.concatenate([part, -part], axis=1) for part in half)
    caps = rng.uniform(0.5, 5.0, 21)
    x = squared_speeds(grid, (a, b), caps)
    u = np.diff(x) / (2 * np.diff(grid))
    assert x[0] == 0
    assert x[-1] == 0
    assert (x[1:-1] > 0).all()
    assert (x <= caps * (1 + 1e-9)).all()
    assert (a * u[:, None] + b * x[:-1, None]).max() <= 1 + 1e-5


def test_a_line_takes_all_it_may_in_one_cell() -> None:
    grid = np.array([0.0, 1.0, 2.0, 3.0])
    a = np.tile([[0.5, -0.5]], (3, 1))
    x = squared_speeds(grid, (a, np.zeros_like(a)), np.full(4, 100.0))
    assert np.allclose(x, [0.0, 4.0, 4.0, 0.0], atol=1e-6)


def test_limits_that_cannot_be_kept_are_refused() -> None:
    grid = np.array([0.0, 1.0, 2.0, 3.0])
    rows = np.ones((3, 2)), np.zeros((3, 2))
    with pytest.raises(RetimingFailed, match="no velocity profile") as caught:
        squared_speeds(grid, rows, np.array([1.0, -1.0, 1.0, 1.0]))
    assert caught.value.evidence == {"method": "toppra", "num_grid_points": 4}
