"""The kernel's torque series are the reference's, on every instruction set, and so are verdicts."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from pydrake.geometry import Sphere

from planning.certify.torque.joint_motion import MotionKind
from planning.certify.torque.kernel_torques import KernelTorques
from planning.certify.torque.links import Link, links_of
from planning.certify.torque.taylor_torques import torque_series
from planning.certify.torque.torque_check import torque_check
from planning.domain.arrays import Array
from planning.domain.curves.curve import TimedTrajectory
from planning.kernel.native import native
from planning.world.collision.margins import PairMargins
from tests.certify.chains import (
    FLOATING,
    PLANAR,
    Builder,
    P,
    R,
    Robot,
    random_robot,
    random_trajectory,
)
from tests.certify.conftest import quintic, request_for
from tests.certify.oracles import without_kernel
from tests.clocks import no_hurry
from tests.conftest import bundled_world
from tests.profiles import num_cases

pytestmark = pytest.mark.skipif(native() is None, reason="the native kernel is not built")
GRAVITY = np.array([0.3, -0.2, -9.81])


def made_up(
    seed: int,
) -> tuple[Robot, tuple[Link, ...], TimedTrajectory, tuple[Any, Array, Array]]:
    """A robot whose links all turn about axes or shift, its links, a motion and segments of it."""
    rng = np.random.default_rng(seed)
    robot = random_robot(rng, int(rng.integers(1, 6)), 0, mass=float(rng.uniform(0.1, 3.0)))
    trajectory = random_trajectory(rng, robot.group, 3, spread=0.6)
    links = links_of(robot.model, robot.request(trajectory, PairMargins(0.0, {}, {})))
    assume(not any(link.motion.kind is MotionKind.SPHERICAL for link in links))
    drives = rng.uniform(0.0, 2.0, (len(links), 2))
    links = tuple(
        replace(link, motion=replace(link.motion, damping=damping, rotor_inertia=inertia))
        for link, (damping, inertia) in zip(links, drives, strict=True)
    )
    count = int(rng.integers(1, 20))
    widths = np.diff(trajectory.breaks)
    pieces = rng.integers(0, 3, count)
    segments = pieces, rng.uniform(0, 1, count) * widths[pieces], rng.uniform(0, 0.1, count)
    return robot, links, trajectory, segments


@settings(max_examples=num_cases(40))
@given(seed=st.integers(0, 2**32 - 1), order=st.integers(0, 2))
def test_series_and_error_bounds_are_those_of_the_reference(seed: int, order: int) -> None:
    _, links, trajectory, segments = made_up(seed)
    expected = torque_series(links, GRAVITY, trajectory, segments, order, use_kernel=False)
    found = torque_series(links, GRAVITY, trajectory, segments, order)
    scale = np.abs(expected.taylor).max(axis=(0, 2))[:, None] + 1e-9
    assert (np.abs(found.taylor - expected.taylor) <= 1e-12 * scale).all()
    # Of the smallest bounds, those of rounding alone, few digits are known: differences of sums.
    np.testing.assert_allclose(found.errors, expected.errors, rtol=1e-6, atol=1e-15 * scale.max())


@settings(max_examples=num_cases(20))
@given(seed=st.integers(0, 2**32 - 1))
def test_every_instruction_set_gives_the_same_bytes(seed: int) -> None:
    module: Any = native()
    _, links, trajectory, segments = made_up(seed)
    torques = KernelTorques.of(links, GRAVITY, trajectory)
    assert torques is not None
    found = {name: torques.polynomials(*segments, 2, name) for name in module.batch_kernels()}
    assert "base" in found
    for taylor, errors in found.values():
        assert taylor.tobytes() == found["base"][0].tobytes()
        assert errors.tobytes() == found["base"][1].tobytes()


@settings(max_examples=num_cases(10))
@given(seed=st.integers(0, 2**32 - 1), excess=st.sampled_from([-0.02, -0.0005, 0.0005, 0.02]))
def test_verdicts_are_those_of_the_reference(seed: int, excess: float) -> None:
    robot, _, trajectory, _ = made_up(seed)
    request = replace(robot.request(trajectory, PairMargins(0.0, {}, {})), effort=True)
    efforts = np.ones(len(robot.group.blocks))
    request = replace(request, limits=replace(request.limits, effort=1e9 * efforts))
    largest = 1e9 * torque_check(robot.model, request, no_hurry()).value
    limited = replace(request.limits, effort=largest * (1 + excess) * efforts)
    checks = [
        torque_check(model, replace(request, limits=limited), no_hurry())
        for model in (robot.model, without_kernel(robot.model))
    ]
    assert checks[0].passed == checks[1].passed
    assert checks[0].value == pytest.approx(checks[1].value, rel=1e-9)
    assert (checks[0].where, checks[0].time) == (checks[1].where, checks[1].time)
    if excess < -0.01:
        assert not checks[0].passed


def test_links_that_turn_in_space_are_left_to_the_reference() -> None:
    rng = np.random.default_rng(2)
    for kind, is_left in ((R, False), (P, False), (PLANAR, False), (FLOATING, True)):
        builder = Builder(mass=1.0)
        builder.link(kind, Sphere(0.1))
        robot = builder.build()
        trajectory = random_trajectory(rng, robot.group, 1, spread=0.1)
        links = links_of(robot.model, robot.request(trajectory, PairMargins(0.0, {}, {})))
        assert (KernelTorques.of(links, GRAVITY, trajectory) is None) is is_left


@pytest.mark.parametrize("size", [3e4, 1e60, 1e200, 1e300])
def test_the_bounds_of_what_overflows_are_no_bounds(size: float) -> None:
    world = bundled_world("ur5e_pickup")
    group = world.group("arm")
    q = world.positions(group)
    wild = quintic(group, q, q + 1e-3, 1.0)
    coefficients = np.array(wild.coefficients)
    coefficients[0, 3:] *= size
    request = request_for(world, "arm", replace(wild, coefficients=coefficients))
    for model in (world.drake, without_kernel(world.drake)):
        assert not torque_check(model, replace(request, effort=True), no_hurry()).passed
