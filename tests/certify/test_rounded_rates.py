"""Rounding errors count in rates of frames, of rotations in space, and in torques.

Polynomials are evaluated exactly; only what is left, sines and cross products, is rounded.
"""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from pydrake.geometry import Sphere
from pydrake.math import RigidTransform

from planning.certify.certifier import CertifyRequest
from planning.certify.frames.frame_derivative_bounds import direction_bounds, origin_bounds
from planning.certify.frames.frame_poses import FramePoses
from planning.certify.frames.frame_states import FrameStates
from planning.certify.frames.tool_checks import tool_checks
from planning.certify.intervals.angular_rates import angular_peak
from planning.certify.torque.links import links_of
from planning.certify.torque.taylor_torques import torque_series
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.geometry import rotation
from planning.domain.request.motion_limits import ToolLimit
from planning.domain.robot.joints import JointType
from planning.world.collision.margins import PairMargins
from planning.world.drake_model import DrakeModel
from tests.certify.chains import Builder, Robot
from tests.certify.intervals.test_rounding import exact_value, powers_of
from tests.clocks import no_hurry
from tests.profiles import seeds

MARGINS = PairMargins(0.0, {}, {})
ARM = 0.7
GRAVITY = np.array([0.0, 0.0, -9.81])


def growing(rng: np.random.Generator, degree: int, size: float) -> np.ndarray:
    """Return coefficients that cancel each other, of a polynomial that is fastest at its end."""
    rates = np.sort(rng.uniform(0, 1, degree)) * np.linspace(0, 1, degree) ** 2
    rates[-1] = 1.2
    return size * powers_of(np.concatenate([[0.0], np.cumsum(rates)]) / degree)


def slopes(powers: np.ndarray) -> list[Fraction]:
    """Return the powers of the derivative, without rounding."""
    return [k * Fraction(float(c)) for k, c in enumerate(powers)][1:]


def value(powers: list[Fraction], t: float) -> float:
    total = Fraction(0)
    for c in powers[::-1]:
        total = total * Fraction(t) + c
    return float(total)


def pendulum() -> tuple[Robot, DrakeModel]:
    """Return one turning joint, and the model with a frame `tip` at some distance from it."""
    builder = Builder()
    builder.link(JointType.REVOLUTE, Sphere(0.1), x_bm=RigidTransform(np.array([ARM, 0, 0])))
    robot = builder.build()
    body = robot.model.plant.get_body(robot.model.bodies["robot::link0"])
    return robot, replace(robot.model, frames={"tip": body.body_frame()})


def moving(robot: Robot, powers: np.ndarray) -> CertifyRequest:
    curve = TimedTrajectory(
        robot.group.joints, np.array([0.0, 1.0]), np.zeros((1, 1)), powers[None, :, None]
    )
    return robot.request(curve, MARGINS)


@pytest.mark.campaign
@pytest.mark.parametrize("degree", [14, 18, 22])
def test_no_frame_is_faster_than_a_limit_that_passes(degree: int) -> None:
    """The limit is between the frame's true speed at the end and the computed one."""
    robot, model = pendulum()
    tempting = 0
    for seed in seeds(10, 200):
        powers = growing(np.random.default_rng(seed), degree, 1e-3)
        request = moving(robot, powers)
        true = ARM * value(slopes(powers), 1.0)
        states = FrameStates(model, request, "tip")
        seen = states.at(np.zeros(1, dtype=int), np.ones(1), no_hurry())
        limit = (true + float(np.linalg.norm(seen.velocity))) / 2 / (1 + 1e-6)
        tempting += true > limit * (1 + 1e-6)
        limited = replace(request, tool_limits=(ToolLimit("tip", limit),))
        (check,) = tool_checks(model, limited, no_hurry())
        assert not (check.passed and true > limit * (1 + 1e-6)), (true, limit, check)
    assert tempting > 3


@pytest.mark.parametrize("degree", [5, 14, 22, 30])
def test_frame_errors_are_within_their_bounds(degree: int) -> None:
    robot, model = pendulum()
    for seed in range(8):
        powers = growing(np.random.default_rng(seed), degree, 1.0)
        request = moving(robot, powers)
        errors = origin_bounds(model, request, "tip").errors[0]
        turned = direction_bounds(model, request, "tip").errors[0, 0]
        states = FrameStates(model, request, "tip")
        for t in (0.3, 0.9, 1.0):
            q = value([Fraction(float(c)) for c in powers], t)
            v = value(slopes(powers), t)
            seen = states.at(np.zeros(1, dtype=int), np.array([t]), no_hurry())
            pose = FramePoses(model, request, "tip").at(
                np.zeros(1, dtype=int), np.array([t]), no_hurry()
            )[0]
            exactly = FramePoses(model, replace(request, start=np.array([q])), "tip").at_reference()
            assert np.linalg.norm(exactly[:3, 3] - pose[:3, 3]) <= errors[0]
            assert np.linalg.norm(exactly[:3, 0] - pose[:3, 0]) <= turned
            assert abs(float(np.linalg.norm(seen.velocity)) - ARM * abs(v)) <= errors[1]
        assert errors[1] < (1e-9 if degree < 13 else 1.0)


def turning_speed(parts: list[np.ndarray], t: float) -> float:
    """Return the norm of the angular velocity of a rotation in space."""
    delta = np.array([float(exact_value(powers, t)) for powers in parts])
    rate = np.array([value(slopes(powers), t) for powers in parts])
    return float(np.linalg.norm(rotation.right_jacobian(delta, rate)))


@pytest.mark.parametrize("degree", [5, 25, 30])
def test_no_rotation_in_space_is_faster_than_its_bound(degree: int) -> None:
    for seed in range(10):
        rng = np.random.default_rng(seed)
        parts = [growing(rng, degree, size) for size in (0.8, 0.5, 0.3)]
        coefficients = np.stack(parts, axis=1)[None]
        bound, _, _ = angular_peak(coefficients, np.ones(1), 1, 1e-9)
        true = max(turning_speed(parts, t) for t in (0.999, 1.0))
        assert true <= bound * (1 + 1e-12)
        if degree == 5:
            assert bound <= true * (1 + 1e-5)


@pytest.mark.parametrize("far", [1.0, 40.0])
def test_bounds_by_sizes_include_rounding(far: float) -> None:
    """Rotations so large that they are bounded by sizes alone include rounding errors too."""
    for seed in range(10):
        rng = np.random.default_rng(seed)
        powers = growing(rng, 30, far)
        coefficients = powers[None, :, None] * np.array([1.0, 0.0, 0.0])
        bound, _, _ = angular_peak(coefficients, np.ones(1), 1, 1e-9)
        assert value(slopes(powers), 1.0) <= bound


def bob(mass: float) -> Robot:
    builder = Builder(mass=mass)
    place, axis = RigidTransform(np.array([ARM, 0, 0])), np.array([0.0, 1.0, 0.0])
    builder.link(JointType.REVOLUTE, Sphere(0.1), axis=axis, x_bm=place)
    return builder.build()


@pytest.mark.parametrize("degree", [5, 16, 22])
def test_torque_errors_are_within_their_bounds(degree: int) -> None:
    """At one instant there is no remainder beyond the last power, only rounding."""
    robot = bob(2.0)
    for seed in range(8):
        powers = growing(np.random.default_rng(seed), degree, 1.0)
        request = moving(robot, powers)
        links = links_of(robot.model, request)
        for t in (0.3, 0.8):
            half = np.array([1e-9])
            found = torque_series(
                links, GRAVITY, request.trajectory, (np.zeros(1, dtype=int), np.array([t]), half)
            )
            true = efforts(links, powers, t)
            assert abs(found.taylor[0, 0, 0] - true) <= found.errors[0, 0]
            assert found.errors[0, 0] < (1e-7 if degree < 13 else np.inf)


def efforts(links: object, powers: np.ndarray, t: float) -> float:
    """Return the torque at the exact position, velocity and acceleration."""
    q, first = [Fraction(float(c)) for c in powers], slopes(powers)
    second = [k * c for k, c in enumerate(first)][1:]
    local = np.array([[[0.0], [value(first, t)], [value(second, t) / 2]]])
    curve = TimedTrajectory(
        bob(2.0).group.joints, np.array([0.0, 1.0]), np.array([[value(q, t)]]), local
    )
    here = (np.zeros(1, dtype=int), np.zeros(1), np.array([1e-12]))
    return float(torque_series(links, GRAVITY, curve, here).taylor[0, 0, 0])
