"""Speed zones: slow in the box, as quick as ever out of it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planning.domain.curves.path import JointPath
from planning.domain.geometry.pose import Pose
from planning.domain.geometry.rotation import matrix
from planning.domain.request.constraint import PlacedBox
from planning.domain.request.motion_limits import SpeedZone
from planning.domain.request.options import RetimeOptions
from planning.retime.blend import blend_corners
from planning.retime.limits.request_limits import path_limits
from planning.retime.retimer import RETIMERS, retime
from tests.conftest import bundled_world
from tests.profiles import num_cases
from tests.retime.limits.test_tool_rate import SMOOTHNESS, TOOLS, random_path, tool_rates


def zone_at(
    centre: np.ndarray, side: float, frame: str, speed: float, turn: float = 0.3
) -> SpeedZone:
    pose = Pose.from_parts(centre, rpy=(turn, turn, turn))
    return SpeedZone("slow", frame, PlacedBox(np.full(3, side), pose), speed)


def are_inside(zone: SpeedZone, points: np.ndarray) -> np.ndarray:
    pose = zone.box.pose
    local = (points - pose.position) @ matrix(pose.quaternion)
    return (np.abs(local) <= zone.box.size / 2).all(axis=1)


@given(
    length=st.floats(0.3, 0.9),
    share=st.floats(0.1, 0.5),
    speed=st.floats(0.05, 0.3),
)
@settings(max_examples=num_cases(6))
def test_a_straight_line_through_a_zone_takes_the_known_time(
    length: float, share: float, speed: float
) -> None:
    """A body slides along x: up, down to the zone's speed, through, up and down again."""
    world = bundled_world("window_3d")
    group = world.group("body")
    limits = world.limits(group)
    top, push = float(limits.velocity[1]), float(limits.acceleration[1])
    q0 = world.positions(group)
    q1 = np.array(q0)
    q1[4] += length
    middle = (q0 + q1)[4:] / 2
    zone = SpeedZone(
        "slow",
        "body::body",
        PlacedBox(np.array([share * length, 1.0, 1.0]), Pose.from_parts(middle)),
        speed,
    )
    options = RetimeOptions(speed_zones=(zone,))
    spline = JointPath(group, np.stack([q0, q1])).spline
    motion, report = retime(spline, limits, options, path_limits(world, group, options))
    run_up = (length - share * length) / 2
    peak = min(top, float(np.sqrt(push * run_up + speed**2 / 2)))
    ramps = peak / push + (peak - speed) / push
    cruise = (run_up - peak**2 / push + speed**2 / (2 * push)) / peak
    best = 2 * (ramps + cruise) + share * length / speed
    assert best <= motion.duration <= 1.006 * best
    assert report.utilisation["speed_zone"] == pytest.approx(1, abs=3e-3)
    assert report.binding["speed_zone"] == "slow"


@pytest.mark.parametrize("method", sorted(RETIMERS))
@pytest.mark.parametrize("scene", TOOLS)
@given(seed=st.integers(0, 1000), side=st.sampled_from([0.01, 0.1, 0.3]))
@settings(max_examples=num_cases(2))
def test_zones_are_kept_between_samples(scene: str, method: str, seed: int, side: float) -> None:
    world = bundled_world(scene)
    name, frame = TOOLS[scene]
    group = world.group(name)
    spline = blend_corners(random_path(world, name, seed), 0.05, SMOOTHNESS[method])
    full = world.embed(group, spline.positions(np.array([0.4])))
    zone = zone_at(world.frame_poses(frame, full)[0, :3, 3], side, frame, 0.1)
    options = RetimeOptions(method=method, speed_zones=(zone,))
    limits = world.limits(group)
    motion, _ = retime(spline, limits, options, path_limits(world, group, options))
    times = np.linspace(0, motion.duration, 4000)
    p_wt = world.frame_poses(frame, world.embed(group, motion.positions(times)))[:, :3, 3]
    both = are_inside(zone, p_wt[:-1]) & are_inside(zone, p_wt[1:])
    speeds, _ = tool_rates(world, name, frame, motion, 4000)
    assert both.any()
    assert speeds[both].max() <= 0.1
    plain, _ = retime(spline, limits, RetimeOptions(method=method))
    slow = float(both.mean()) * motion.duration
    # Slow in the zone, and while speeding up and slowing down around it.
    assert motion.duration - slow <= plain.duration + 1.0


def test_a_zone_that_is_passed_by_costs_nothing() -> None:
    world = bundled_world("ur5e_pickup")
    group = world.group("arm")
    limits = world.limits(group)
    spline = blend_corners(random_path(world, "arm", 2), 0.05)
    options = RetimeOptions(speed_zones=(zone_at(np.full(3, 9.0), 0.5, "arm::tcp", 0.01),))
    plain, _ = retime(spline, limits, RetimeOptions())
    motion, report = retime(spline, limits, options, path_limits(world, group, options))
    assert motion.duration <= 1.005 * plain.duration
    assert "speed_zone" not in report.utilisation
