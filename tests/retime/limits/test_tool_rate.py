"""Limits on a frame's speed and acceleration: kept everywhere, and met where theory says so."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planning.domain.curves.curve import TimedTrajectory
from planning.domain.curves.path import JointPath
from planning.domain.request.motion_limits import ToolLimit
from planning.domain.request.options import RetimeOptions
from planning.retime.blend import blend_corners
from planning.retime.duration_explanation import explain_duration
from planning.retime.limits.request_limits import path_limits
from planning.retime.retimer import RETIMERS, retime
from planning.world.world import World
from tests.conftest import bundled_world
from tests.profiles import num_cases

SMOOTHNESS = {"toppra": 1, "ruckig": 2}
TOOLS = {
    "ur5e_pickup": ("arm", "arm::tcp"),
    "panda_shelf": ("panda", "panda::panda_hand_tcp"),
}


def random_path(world: World, name: str, seed: int, count: int = 4) -> JointPath:
    group = world.group(name)
    steps = np.random.default_rng(seed).normal(0, 0.4, (count - 1, group.num_velocities))
    q = world.positions(group)
    return JointPath(group, np.concatenate([q[None], q + np.cumsum(steps, axis=0)]))


def tool_rates(
    world: World, name: str, frame: str, motion: TimedTrajectory, count: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return speeds and accelerations between instants, by differences of Drake's poses."""
    times = np.linspace(0, motion.duration, count)
    full = world.embed(world.group(name), motion.positions(times))
    p_wt = world.frame_poses(frame, full)[:, :3, 3]
    step = times[1]
    velocity = np.diff(p_wt, axis=0) / step
    acceleration = np.diff(velocity, axis=0) / step
    return np.linalg.norm(velocity, axis=1), np.linalg.norm(acceleration, axis=1)


@pytest.mark.parametrize("method", sorted(RETIMERS))
@pytest.mark.parametrize("scene", TOOLS)
@given(seed=st.integers(0, 1000), speed=st.sampled_from([0.05, 0.3, 5.0]))
@settings(max_examples=num_cases(2))
def test_limits_hold_between_all_samples_and_one_is_met(
    scene: str, method: str, seed: int, speed: float
) -> None:
    world = bundled_world(scene)
    name, frame = TOOLS[scene]
    options = RetimeOptions(method=method, tool_limits=(ToolLimit(frame, speed, 1.5),))
    spline = blend_corners(random_path(world, name, seed), 0.05, SMOOTHNESS[method])
    group = world.group(name)
    limits = world.limits(group)
    motion, report = retime(spline, limits, options, path_limits(world, group, options))
    speeds, accelerations = tool_rates(world, name, frame, motion, 3000)
    assert speeds.max() <= speed
    assert accelerations.max() <= 1.5 * (1 + 1e-4)
    assert report.utilisation["tool_speed"] == pytest.approx(speeds.max() / speed, rel=1e-3)
    assert report.binding["tool_speed"] == frame
    assert 0.997 < max(report.utilisation.values()) <= 1


@given(st.floats(0.3, 3.0), st.floats(0.05, 0.5))
@settings(max_examples=num_cases(6))
def test_a_tool_on_a_circle_takes_the_time_of_its_arc(angle: float, speed: float) -> None:
    """One joint that turns a tool at a radius: v / r caps it, rest to rest in d / w + w / a."""
    world = bundled_world("ur5e_pickup")
    group = world.group("arm")
    q0 = world.positions(group)
    q1 = np.array(q0)
    q1[0] += angle
    frame = world.frame_pose("arm::tcp", world.embed(group, q0))
    base = world.frame_pose("arm::base_link", world.embed(group, q0))
    radius = float(np.linalg.norm((frame.position - base.position)[:2]))
    options = RetimeOptions(tool_limits=(ToolLimit("arm::tcp", speed),))
    limits = world.limits(group)
    spline = JointPath(group, np.stack([q0, q1])).spline
    motion, _ = retime(spline, limits, options, path_limits(world, group, options))
    w, a = speed / radius, float(limits.acceleration[0])
    best = angle / w + w / a
    assert best <= motion.duration <= 1.01 * best


def test_explanation_names_the_frame_and_the_saving() -> None:
    world = bundled_world("ur5e_pickup")
    group = world.group("arm")
    options = RetimeOptions(tool_limits=(ToolLimit("arm::tcp", 0.2),))
    spline = blend_corners(random_path(world, "arm", 3), 0.05)
    others = path_limits(world, group, options)
    limits = world.limits(group)
    motion, report = retime(spline, limits, options, others)
    found = explain_duration(spline, motion, limits, options, others)
    assert ("tool_speed", "arm::tcp") in {(entry.limit, entry.where) for entry in found.intervals}
    most = found.savings[0]
    assert (most.limit, most.where) == ("tool_speed", "arm::tcp")
    looser = RetimeOptions(tool_limits=(ToolLimit("arm::tcp", 0.24),))
    again, _ = retime(spline, limits, looser, path_limits(world, group, looser))
    assert most.seconds == pytest.approx(report.duration - again.duration, abs=1e-6)


def test_a_limit_that_does_not_bind_costs_no_time_worth_naming() -> None:
    world = bundled_world("ur5e_pickup")
    group = world.group("arm")
    options = RetimeOptions(tool_limits=(ToolLimit("arm::tcp", 100.0),))
    limits = world.limits(group)
    spline = blend_corners(random_path(world, "arm", 5), 0.05)
    free, _ = retime(spline, limits, RetimeOptions())
    bound, _ = retime(spline, limits, options, path_limits(world, group, options))
    assert bound.duration <= 1.01 * free.duration


@pytest.mark.parametrize("frame", ["world", "arm::base_link", "arm::tcp"])
@pytest.mark.parametrize("method", sorted(RETIMERS))
def test_a_frame_that_hardly_moves_is_no_limit(frame: str, method: str) -> None:
    """The last joint turns alone, about the axis on which the tool's origin lies."""
    world = bundled_world("ur5e_pickup")
    group = world.group("arm")
    limits = world.limits(group)
    q0 = world.positions(group)
    q1 = np.array(q0)
    q1[5] += 1.0
    options = RetimeOptions(method=method, tool_limits=(ToolLimit(frame, 0.001, 0.001),))
    spline = JointPath(group, np.stack([q0, q1])).spline
    plain, _ = retime(spline, limits, RetimeOptions(method=method))
    bound, report = retime(spline, limits, options, path_limits(world, group, options))
    assert bound.duration <= 1.003 * plain.duration
    assert report.utilisation["tool_speed"] < 1e-6
