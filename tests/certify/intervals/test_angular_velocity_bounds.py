"""Angular rates of large rotations, or about a slowly moving axis, are never underestimated."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import planning
from planning.certify.intervals.angular_velocity_bounds import angular_velocity_bounds
from planning.certify.intervals.axis_drift import axis_drift
from planning.domain.geometry import rotation
from tests.clocks import no_hurry
from tests.profiles import num_cases

FLOATING = """<robot name="m"><link name="base"/><link name="a">
<collision><geometry><box size="0.02 0.02 0.02"/></geometry></collision></link>
<joint name="j" type="floating"><parent link="base"/><child link="a"/></joint></robot>"""


def angular_rates(tangent: np.ndarray, t: np.ndarray) -> list[np.ndarray]:
    """Return omega and its first three derivatives from quaternions alone, by differences.

    Args:
        tangent: Power basis of delta, shape (k, 3).
        t: Evenly spaced instants.
    """
    step = t[1] - t[0]
    turned = rotation.exp((t[:, None] ** np.arange(len(tangent))) @ tangent)
    omega = rotation.log(rotation.multiply(rotation.conjugate(turned[:-1]), turned[1:])) / step
    found = [omega]
    for _ in range(3):
        found.append(np.gradient(found[-1], step, axis=0)[2:-2])
    return found


def largest(tangent: np.ndarray, t: np.ndarray, order: int) -> float:
    power = np.array(tangent)
    for _ in range(order):
        power = power[1:] * np.arange(1, len(power))[:, None]
    return float(np.linalg.norm((t[:, None] ** np.arange(len(power))) @ power, axis=1).max())


@given(seed=st.integers(0, 10_000), size=st.floats(0.1, 30.0))
@settings(max_examples=num_cases(6))
def test_sizes_alone_bound_all_derivatives(seed: int, size: float) -> None:
    rng = np.random.default_rng(seed)
    tangent = rng.normal(0.0, 1.0, (5, 3))
    tangent[0] *= size
    t = np.linspace(0.0, 1.0, 4001)
    sizes = np.array([[largest(tangent, t, order)] for order in range(1, 5)])
    bounds = angular_velocity_bounds(sizes)[:, 0]
    for bound, rates in zip(bounds, angular_rates(tangent, t), strict=True):
        assert np.linalg.norm(rates, axis=1).max() <= bound * (1 + 1e-3)


@given(seed=st.integers(0, 10_000), across=st.sampled_from([0.0, 1e-9, 1e-4, 1e-2]))
@settings(max_examples=num_cases(6))
def test_axis_drift_bounds_the_difference_to_tangent_rates(seed: int, across: float) -> None:
    rng = np.random.default_rng(seed)
    axis = rotation.matrix(rotation.exp(rng.normal(size=(1, 3)))[0])[:, 0]
    tangent = rng.normal(0.0, 1.0, 5)[:, None] * axis + across * rng.normal(size=(5, 3))
    width = 10.0 ** rng.uniform(-2, 2)
    coefficients = (tangent / width ** np.arange(5)[:, None])[None]
    t = np.linspace(0.0, 1.0, 4001)
    for order, rates in enumerate(angular_rates(tangent, t)[:3], start=1):
        found = float(axis_drift(coefficients, np.array([width]), order)[0]) * width**order
        power = tangent
        for _ in range(order):
            power = power[1:] * np.arange(1, len(power))[:, None]
        middles = t[:-1] + (t[1] - t[0]) / 2
        inner = slice(2 * (order - 1), len(middles) - 2 * (order - 1))
        own = (middles[inner, None] ** np.arange(len(power))) @ power
        missed = np.linalg.norm(rates - own, axis=1).max()
        assert missed <= found + 1e-4 * np.abs(own).max()
        if across == 0.0:
            assert found < 1e-9


def slow_turn(joints: tuple, duration: float, begin: float, size: float) -> object:
    """Return a rotation whose axis moves by tiny coefficients over a long piece."""
    rate = np.polynomial.polynomial.polymul([0.0] * 6 + [1.0], [1.0, -2.0, 1.0])
    turn = np.polynomial.polynomial.polyint(rate)
    turn = turn / turn.sum() * size
    turn[0] -= size / 2
    coefficients = np.zeros((1, len(turn), 6))
    coefficients[0, :, 1] = turn / duration ** np.arange(len(turn))
    coefficients[0, 0, 0] = begin
    bases = np.array([[1.0, 0, 0, 0, 0, 0, 0]])
    return planning.TimedTrajectory(joints, np.array([0.0, duration]), bases, coefficients)


@pytest.mark.parametrize(("duration", "size"), [(1000.0, 12.0), (1000.0, 60.0), (60.0, 12.0)])
@pytest.mark.parametrize("method", ["toppra", "ruckig"])
def test_the_axis_drift_of_a_long_piece_is_detected(
    tmp_path: Path, duration: float, size: float, method: str
) -> None:
    """Coefficients of a long piece are tiny though its rotation is large (7.8 times the limit)."""
    file = tmp_path / "body.urdf"
    file.write_text(FLOATING)
    robot = {"name": "r", "model": str(file), "positions": [1, 0, 0, 0, 0, 0, 0]}
    world = planning.load_world(planning.parse_scene({"name": "s", "robots": [robot]}))
    group = world.group("r")
    motion = slow_turn(group.joints, duration, 3.0, size)
    t = np.linspace(0.0, duration, 40001)
    truth = angular_rates(motion.coefficients[0][:, :3], t)
    limits = world.limits(group)
    certificate, _ = planning.certify_trajectory(
        world, "r", motion, deadline=no_hurry(), options=planning.RetimeOptions(method=method)
    )
    names = ["velocity", "acceleration"] + ["jerk"] * (method == "ruckig")
    for name, rates in zip(names, truth, strict=False):
        (check,) = [c for c in certificate.checks if c.name == name]
        limit = float(getattr(limits, name)[0])
        assert check.value >= np.linalg.norm(rates, axis=1).max() / limit * (1 - 1e-3)
