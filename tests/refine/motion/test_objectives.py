"""Objectives of a motion: measured, scaled in time, and least where `best_slowdown` says."""

import numpy as np
import pytest

from planning.domain.curves.path import JointPath
from planning.domain.request.options import RetimeOptions
from planning.domain.request.refine_objective import RefineObjective
from planning.domain.robot.payload import Payload
from planning.refine.motion.motion_objectives import MotionObjectives
from planning.retime.blend import blend_corners
from planning.retime.retimer import keep_timing, retime
from planning.world.mechanics.dynamics import GroupDynamics
from tests.conftest import bundled_world

JERK = RefineObjective(smoothness=1.0, derivative="jerk", max_duration=9.0)


def motion_of(case, method="toppra"):
    spline = blend_corners(case.request.path, 0.03, 2)
    return retime(spline, case.request.limits, RetimeOptions(method))[0]


def measured(case, motion, objective=None, payload=None) -> MotionObjectives:
    return MotionObjectives.of(case.world, case.request.path.group, motion, objective, payload)


def test_values_are_integrals_over_time(pillar):
    motion = motion_of(pillar)
    values = measured(pillar, motion).values()
    times = np.linspace(0.0, motion.duration, 20_001)
    step = times[1]
    speeds = np.linalg.norm(motion.velocities(times), axis=1)
    accelerations = motion.accelerations(times)
    assert values.duration == motion.duration
    assert values.path_length == pytest.approx(speeds.sum() * step, rel=1e-3)
    assert values.smoothness == pytest.approx((accelerations**2).sum() * step, rel=1e-2)
    assert values.energy > 0


def test_energy_is_integrated_between_the_jumps_of_accelerations(pillar):
    """To a ten-thousandth by midpoints, of which few fall on a piece with a jump."""
    motion = motion_of(pillar)
    width = motion.duration / 40_000
    times = (np.arange(40_000) + 0.5) * width
    dynamics = GroupDynamics(pillar.world, pillar.request.path.group)
    rates = motion.positions(times), motion.velocities(times), motion.accelerations(times)
    expected = float((dynamics.efforts(*rates) ** 2).sum()) * width
    assert measured(pillar, motion).values().energy == pytest.approx(expected, rel=1e-4)


def test_jerk_is_infinite_where_accelerations_jump(pillar):
    assert measured(pillar, motion_of(pillar), JERK).values().smoothness is None
    assert measured(pillar, motion_of(pillar), JERK).cost() == np.inf
    smooth = motion_of(pillar, "ruckig")
    values = measured(pillar, smooth, JERK).values()
    times = np.linspace(0.0, smooth.duration, 20_001)
    jerks = smooth.tangents(times, 3)
    assert values.smoothness == pytest.approx((jerks**2).sum() * times[1], rel=2e-2)


@pytest.mark.parametrize("derivative", ["acceleration", "jerk"])
def test_a_slower_motion_costs_what_was_predicted(pillar, derivative):
    objective = RefineObjective(1.0, 0.1, 0.001, 0.5, derivative)
    motion = motion_of(pillar, "ruckig")
    predicted = measured(pillar, motion, objective).values(1.7)
    slower = measured(pillar, motion.time_scaled(1.7), objective).values()
    assert slower.duration == pytest.approx(predicted.duration)
    assert slower.smoothness == pytest.approx(predicted.smoothness, rel=1e-6)
    assert slower.energy == pytest.approx(predicted.energy, rel=1e-9)
    assert slower.path_length == pytest.approx(predicted.path_length)


def test_the_best_duration_of_a_sum_is_where_its_slope_vanishes(pillar):
    """w T k + S k^-3 is least at k^4 = 3 S / (w T)."""
    motion = motion_of(pillar)
    plain = measured(pillar, motion).values()
    weight = 5 * plain.duration / plain.smoothness
    objective = RefineObjective(duration=1.0, smoothness=weight)
    best = measured(pillar, motion, objective).best_slowdown
    assert best == pytest.approx(15**0.25, rel=2e-3)
    bounded = RefineObjective(duration=1.0, smoothness=weight, max_duration=1.1 * plain.duration)
    assert measured(pillar, motion, bounded).best_slowdown == pytest.approx(1.1)
    assert measured(pillar, motion).best_slowdown == 1.0


def test_a_payload_costs_energy(pillar):
    motion, frame = motion_of(pillar), "arm::tcp"
    carried = Payload.from_parts(frame, 3.0, (0.0, 0.0, 0.05))
    without, with_it = (
        measured(pillar, motion, None, load).values().energy for load in (None, carried)
    )
    assert with_it > without


def test_a_motion_that_keeps_its_limits_keeps_its_time(pillar):
    motion, limits = motion_of(pillar, "ruckig").time_scaled(1.3), pillar.request.limits
    kept = keep_timing(motion, limits, RetimeOptions("ruckig"))
    assert kept is not None
    assert kept[0].duration == motion.duration
    assert max(kept[1].utilisation.values()) < 1
    longer = keep_timing(motion, limits, RetimeOptions("ruckig", duration=9.0))
    assert longer[0].duration == pytest.approx(9.0)
    assert keep_timing(motion.time_scaled(0.5), limits, RetimeOptions("ruckig")) is None


def test_a_hair_too_fast_is_slowed(pillar):
    limits = pillar.request.limits
    motion = motion_of(pillar).time_scaled(1 - 1e-4)
    trajectory, report = keep_timing(motion, limits, RetimeOptions("toppra"))
    assert 1 < report.slowed < 1.001
    assert trajectory.duration == pytest.approx(motion.duration * report.slowed)


def turning_about_two_axes(method):
    """Return a floating body's motion around a corner at which its axis of rotation changes."""
    world = bundled_world("window_3d")
    group = world.group("body")
    corners = np.array([
        [1.0, 0.0, 0.0, 0.0, -0.7, 0.0, 0.5],
        [0.8, 0.6, 0.0, 0.0, -0.6, 0.0, 0.5],
        [0.48, 0.36, 0.8, 0.0, -0.5, 0.1, 0.5],
    ])
    spline = blend_corners(JointPath(group, corners), 0.3, 2)
    return world, group, retime(spline, world.limits(group), RetimeOptions(method))[0]


@pytest.mark.parametrize("derivative", ["acceleration", "jerk"])
def test_rates_of_a_floating_body_are_those_of_its_twist(derivative):
    """By midpoints of the body's accelerations, not of the coordinates that the curve has."""
    world, group, motion = turning_about_two_axes("ruckig")
    width = motion.duration / 100_000
    times = (np.arange(100_000) + 0.5) * width
    rates = motion.accelerations(times)
    if derivative == "jerk":
        rates = np.diff(rates, axis=0) / width
    expected = float((rates**2).sum()) * width
    objective = RefineObjective(smoothness=1.0, derivative=derivative, max_duration=9.0)
    values = MotionObjectives.of(world, group, motion, objective, None).values()
    assert values.smoothness == pytest.approx(expected, rel=1e-3)
    length = float(np.linalg.norm(motion.velocities(times), axis=1).sum()) * width
    assert values.path_length == pytest.approx(length, rel=1e-6)


def test_a_floating_bodys_jerk_is_infinite_where_its_accelerations_jump():
    world, group, motion = turning_about_two_axes("toppra")
    assert MotionObjectives.of(world, group, motion, JERK, None).values().smoothness is None
