"""Rounding errors are bounded, against exact arithmetic, and refused where they are large."""

from dataclasses import replace
from fractions import Fraction
from math import comb

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.geometry import Box
from pydrake.math import RigidTransform

from planning.certify.certifier import certify
from planning.certify.clearance.native_clearance import prover
from planning.certify.intervals import bernstein
from planning.certify.intervals.joint_deviation import Segments
from planning.certify.intervals.rounding import rounding_bounds
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.report.certificate import Check
from planning.domain.robot.joints import JointType
from planning.kernel.native import native
from planning.world.collision.margins import PairMargins
from planning.world.kernel.kernel_scene import kernel_scene
from tests.certify.chains import Builder, R, Robot
from tests.clocks import no_hurry
from tests.conftest import group_of

MARGINS = PairMargins(0.0, {}, {})


def powers_of(controls: np.ndarray) -> np.ndarray:
    """Return the power basis on [0, 1] of Bernstein coefficients, each rounded once."""
    degree, exact = len(controls) - 1, [Fraction(float(b)) for b in controls]
    return np.array([
        float(
            comb(degree, k)
            * sum(((-1) ** (k - i) * comb(k, i) * exact[i] for i in range(k + 1)), Fraction(0))
        )
        for k in range(degree + 1)
    ])


def exact_form(powers: np.ndarray, width: float) -> list[Fraction]:
    degree, w = len(powers) - 1, Fraction(width)
    scaled = [Fraction(float(c)) * w**k for k, c in enumerate(powers)]
    return [
        sum((Fraction(comb(i, k), comb(degree, k)) * scaled[k] for k in range(i + 1)), Fraction(0))
        for i in range(degree + 1)
    ]


def exact_value(powers: np.ndarray, t: float) -> Fraction:
    total = Fraction(0)
    for c in powers[::-1]:
        total = total * Fraction(t) + Fraction(float(c))
    return total


def wild(rng: np.random.Generator, degree: int) -> np.ndarray:
    """Return coefficients that cancel each other: within 1, at rest at both ends."""
    controls = rng.uniform(-1, 1, degree + 1)
    controls[:2], controls[-2:] = 0.0, controls[-1]
    return powers_of(controls)


@given(
    seed=st.integers(0, 9999),
    degree=st.integers(1, 40),
    width=st.sampled_from([1.0, 1.0 / 3.0, 7.0, 1e-3]),
    is_wild=st.booleans(),
)
def test_errors_of_forms_halves_and_values_are_within_their_bounds(
    seed: int, degree: int, width: float, *, is_wild: bool
) -> None:
    rng = np.random.default_rng(seed)
    unscaled = wild(rng, degree) if is_wild and degree > 3 else rng.normal(size=degree + 1)
    powers = unscaled / width ** np.arange(degree + 1)
    coefficients, widths = powers[None, :, None], np.array([width])
    form = bernstein.from_power(coefficients, widths)
    hidden = rounding_bounds(np.abs(form).max(axis=1), coefficients, widths)[0, 0]
    truth = exact_form(powers, width)
    off = [abs(float(Fraction(float(b)) - t)) for b, t in zip(form[0, :, 0], truth, strict=True)]
    assert max(off) <= hidden
    curve = TimedTrajectory(
        group_of(JointType.PRISMATIC).joints,
        np.array([0.0, width]),
        np.zeros((1, 1)),
        coefficients,
    )
    begin, step = 0.0, width
    while step > width * 2.0**-30:  # down to a random short interval, whose ends are values
        left, right = bernstein.halves(form)
        step /= 2
        form, begin = (left, begin) if rng.random() < 0.5 else (right, begin + step)
        t = begin if rng.random() < 0.5 else begin + step
        value = form[0, 0, 0] if t == begin else form[0, -1, 0]
        assert abs(float(Fraction(float(value)) - exact_value(powers, t))) <= hidden
        computed = curve.positions(np.array([t]))[0, 0]
        assert abs(float(Fraction(float(computed)) - exact_value(powers, t))) <= hidden


@given(st.integers(0, 9999), st.integers(1, 12))
def test_rounding_bounds_of_low_degree_are_small(seed: int, degree: int) -> None:
    powers = wild(np.random.default_rng(seed), max(degree, 4))[None, :, None]
    form = bernstein.from_power(powers, np.ones(1))
    largest = np.abs(form).max(axis=1)
    assert (rounding_bounds(largest, powers, np.ones(1)) <= 5e-9 * largest).all()


def arm() -> Robot:
    builder = Builder()
    builder.link(R, Box(0.1, 0.1, 0.1))
    builder.obstacle("far", Box(0.1, 0.1, 0.1), RigidTransform([3.0, 0.0, 0.0]))
    return builder.build()


def moving(robot: Robot, powers: np.ndarray) -> TimedTrajectory:
    return TimedTrajectory(
        robot.group.joints, np.array([0.0, 1.0]), np.zeros((1, 1)), powers[None, :, None]
    )


def checks_of(robot: Robot, motion: TimedTrajectory, limit: float) -> dict[str, Check]:
    request = robot.request(motion, MARGINS)
    limits = replace(request.limits, lower=np.array([-limit]), upper=np.array([limit]))
    certificate, _ = certify(robot.model, replace(request, limits=limits), no_hurry())
    return {check.name: check for check in certificate.checks}


@pytest.mark.usefixtures("implementation")
@pytest.mark.parametrize("degree", [15, 25, 30, 35])
def test_a_bound_on_positions_is_true_of_the_exact_polynomial_or_refused(degree: int) -> None:
    """At degree 35 rounding errors may reach half a radian."""
    robot, rng = arm(), np.random.default_rng(degree)
    for _ in range(8):
        powers = wild(rng, degree)
        checks = checks_of(robot, moving(robot, powers), 2.0)
        if "position" not in checks:
            assert not checks["form"].passed
            assert "rounding error" in checks["form"].where
            assert "robot::j0" in checks["form"].where
            assert str(degree) in checks["form"].where
            continue
        assert degree < 25
        worst = max(abs(exact_value(powers, t)) for t in np.linspace(0, 1, 65).tolist())
        assert float(worst) - 2.0 <= checks["position"].value


@pytest.mark.parametrize("degree", [15, 25, 30])
def test_segments_hold_the_exact_polynomial(degree: int) -> None:
    robot, rng = arm(), np.random.default_rng(degree)
    for _ in range(4):
        powers = wild(rng, degree)
        motion = moving(robot, powers)
        segments = Segments(motion)
        segment = segments.whole
        for _ in range(24):
            ends = [exact_value(powers, t) for t in (segment.begin, segment.end)]
            away = max(abs(end - Fraction(float(segment.center[0]))) for end in ends)
            assert away <= segment.max_rotation[0]
            segment = segments.halves(segment)[int(rng.integers(2))]


@pytest.mark.skipif(native() is None, reason="the native code is not built")
@pytest.mark.parametrize("degree", [15, 25, 30])
def test_the_kernel_includes_rounding(degree: int) -> None:
    """In the limit of short segments the bounds are those of rounding errors alone."""
    robot = arm()
    powers = wild(np.random.default_rng(degree), degree)
    motion = moving(robot, powers)
    proving = prover(
        kernel_scene(robot.model), robot.model, robot.request(motion, MARGINS), np.zeros(1)
    )
    size = float(np.abs(powers).sum())
    approach = proving.bounds([0, 1] * 20)[3][0, 0]
    # The lever arm of the box about its joint is half its diagonal across the axis.
    least = 2 * np.sin(degree * 2.0**-53 * size / 2) * 0.05 * np.sqrt(2)
    assert approach >= least > 0
