"""Stops along the path: within limits at every instant, with the reported duration."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.geometry import Sphere

from planning.certify.certifier import CertifyRequest, certify
from planning.certify.intervals.motion_cells import motion_cells
from planning.certify.stopping.stops import (
    hardest_stops,
    max_braking,
    smooth_durations,
    smooth_stops,
)
from planning.domain.curves.curve import JointSpline
from planning.domain.curves.path import JointPath
from planning.domain.report.certificate import Certificate
from planning.domain.report.stage_reports import CertifyReport
from planning.domain.request.options import CertifyOptions, RetimeOptions
from planning.execute.time_scaling import path_acceleration_bounds
from planning.retime.blend import blend_corners
from planning.retime.limits.signed_acceleration import SignedAcceleration
from planning.retime.retimer import retime
from planning.world.collision.margins import PairMargins
from planning.world.world import World
from tests.certify.chains import Builder, P
from tests.certify.conftest import quintic, request_for
from tests.clocks import no_hurry
from tests.conftest import bundled_world, limits_of
from tests.profiles import num_cases

# Lowest and highest acceleration of every joint, where they differ.
type BySign = tuple[float, float] | None

STOPS = CertifyOptions(stop_anywhere=True)
# What limits may be passed by, and what rounding adds in these tests.
ALLOWED = 1 + 2e-6


def held(
    request: CertifyRequest, spline: JointSpline, method: str, bounds: BySign
) -> CertifyRequest:
    """Return the request of the quickest motion along a curve."""
    columns = {name: indices[0] for name, indices in request.group.blocks} if bounds else {}
    signed = dict.fromkeys(columns, bounds)
    others = (SignedAcceleration(signed, tuple(columns.values())),) if bounds else ()
    trajectory, _ = retime(spline, request.limits, RetimeOptions(method=method), others)
    jerk = method == "ruckig"
    return replace(request, trajectory=trajectory, jerk=jerk, acceleration_bounds=signed)


def slide(length: float, method: str = "toppra", bounds: BySign = None) -> CertifyRequest:
    """Return the fastest translation within 2 m/s, 10 m/s^2 and 100 m/s^3."""
    builder = Builder()
    builder.link(P, Sphere(0.05))
    robot = builder.build()
    limits = limits_of(robot.group)
    path = JointPath(robot.group, np.array([[0.0], [length]]))
    resting = quintic(robot.group, np.zeros(1), np.array([length]), 10.0)
    request = robot.request(resting, PairMargins(0.0))
    return held(replace(request, limits=limits), path.spline, method, bounds)


def detour(seed: int, method: str, bounds: BySign = None) -> tuple[World, CertifyRequest]:
    """Return a motion of the UR5e over a corner that is rounded; it may well collide."""
    world = bundled_world("ur5e_pickup")
    group = world.group("arm")
    rng = np.random.default_rng(seed)
    rows = world.positions(group) + np.concatenate([np.zeros((1, 6)), rng.normal(0, 0.4, (3, 6))])
    spline = blend_corners(JointPath(group, rows), 0.1, 1 if method == "toppra" else 2)
    resting = quintic(group, rows[0], rows[-1], 10.0)
    return world, held(request_for(world, "arm", resting), spline, method, bounds)


def certify_request(world: World, request: CertifyRequest) -> tuple[Certificate, CertifyReport]:
    return certify(world.drake, request, no_hurry(30.0))


def use(request: CertifyRequest, rates: np.ndarray, order: int) -> float:
    bounds = (request.limits.velocity, request.limits.acceleration, request.limits.jerk)[order - 1]
    signed = request.acceleration_bounds if order == 2 else {}
    columns = dict(request.group.blocks)
    return max(
        *(
            float(np.linalg.norm(rates[:, list(block)], axis=1).max() / bound)
            for block, bound in zip(request.limits.blocks, bounds, strict=True)
        ),
        *(
            float((rates[:, columns[name][0]] / bound).max())
            for name, either in signed.items()
            for bound in either
        ),
    )


def ridden(request: CertifyRequest, first: int, cells_at: int = 600) -> tuple[float, float]:
    """Follow the hardest stop from a cell on, in small steps; return its time and utilization."""
    cells = motion_cells(request, cells_at)
    y, clock, worst, at = 1.0, 0.0, 0.0, first
    while y > 1e-12 and at < len(cells.begins):
        width = float(cells.widths[at])
        x = float(max_braking(cells, np.array([at]), np.array([y]))[0])
        local = np.linspace(0.0, width, 17)
        ys = np.maximum(y - 2 * x * local, 0.0)[:, None]
        times = cells.begins[at] + np.clip(local, 1e-12, width - 1e-12)
        v, vdot = request.trajectory.velocities(times), request.trajectory.accelerations(times)
        worst = max(worst, use(request, vdot * ys - v * x, 2))
        after = max(y - 2 * x * width, 0.0)
        passed = width if after > 1e-12 else y / (2 * x)
        clock += 2 * passed / (np.sqrt(y) + np.sqrt(after))
        y, at = after, at + 1
    return clock, worst


@pytest.mark.parametrize("length", [0.1, 0.4, 4.0])
def test_one_joint_stops_as_quickly_as_it_can_brake(length: float) -> None:
    request = slide(length)
    cells = motion_cells(request, 600)
    stops = hardest_stops(cells)
    longest = float((cells.widths + stops.times[1:]).max())
    top = min(2.0, np.sqrt(length * 10.0))
    # Braking from full speed takes top / a, and the resolution is a few cells.
    assert top / 10.0 - 1e-6 <= longest <= top / 10.0 + 3 * cells.widths.max()


def test_the_report_of_one_joint_is_the_analytic_one() -> None:
    request = replace(slide(4.0), options=STOPS)
    builder = Builder()
    builder.link(P, Sphere(0.05))
    certificate, report = certify(builder.build().model, request, no_hurry(9.0))
    assert certificate.proven
    assert report.stop is not None
    assert report.stop.distance == pytest.approx(0.2, rel=0.08)
    assert report.stop.distance >= 0.2
    assert report.stop.joint == "robot::j0"
    assert (report.stop.tool_distance, report.stop.frame) == (None, "")


@pytest.mark.parametrize("method", ["toppra", "ruckig"])
@pytest.mark.parametrize(("bounds", "lasting"), [((-2.0, 10.0), 1.0), ((-10.0, 2.0), 0.2)])
def test_a_joint_stops_as_its_bounds_by_sign_allow(
    method: str, bounds: tuple[float, float], lasting: float
) -> None:
    """From 2 m/s, which take 1 s to lose at 2 m/s^2, and 0.2 s at 10 m/s^2."""
    request = replace(slide(8.0, method, bounds), options=STOPS)
    cells = motion_cells(request, 200 if request.jerk else 600)
    stops = smooth_stops(cells) if request.jerk else hardest_stops(cells)
    middle = float(stops.times[len(stops.times) // 2])
    assert lasting / ALLOWED <= middle < (2.2 * lasting if request.jerk else lasting + 0.03)


EITHER_WAY = st.sampled_from([None, (-1.0, 2.5), (-2.5, 1.0)])


@given(seed=st.integers(0, 1000), start=st.floats(0, 0.95), bounds=EITHER_WAY)
@settings(max_examples=num_cases(4))
def test_hardest_stops_keep_the_limits_at_every_instant(
    seed: int, start: float, bounds: BySign
) -> None:
    _, request = detour(seed, "toppra", bounds)
    cells = motion_cells(request, 600)
    first = int(start * len(cells.begins))
    clock, worst = ridden(request, first)
    assert worst <= ALLOWED
    reported = hardest_stops(cells).times[first]
    left = request.trajectory.duration - cells.begins[first]
    assert reported == pytest.approx(min(clock, left), rel=1e-9)


@given(seed=st.integers(0, 1000), start=st.floats(0.05, 0.9))
@settings(max_examples=num_cases(3))
def test_an_execution_that_brakes_step_by_step_is_hardly_quicker(seed: int, start: float) -> None:
    _, request = detour(seed, "toppra")
    motion, period = request.trajectory, 5e-4
    at, rate, clock = start * motion.duration, 1.0, 0.0
    while rate > 0 and at < motion.duration:
        ahead = np.array([at, at + rate * period])
        least, _ = path_acceleration_bounds(motion, request.limits, ahead, np.array([rate, rate]))
        after = max(0.0, rate + min(least, 0.0) * period)
        at += (rate + after) / 2 * period
        rate, clock = after, clock + period
    cells = motion_cells(request, 600)
    cell = int(np.searchsorted(cells.begins, start * motion.duration, side="right")) - 1
    reported = float(cells.widths[cell] + hardest_stops(cells).times[cell + 1])
    quickest = min(clock, (1 - start) * motion.duration)
    assert 0.98 * quickest - 2e-3 <= reported <= 1.15 * quickest + 0.01


@given(seed=st.integers(0, 1000), bounds=EITHER_WAY)
@settings(max_examples=num_cases(3))
def test_smooth_stops_keep_the_limits_at_every_instant(seed: int, bounds: BySign) -> None:
    _, request = detour(seed, "ruckig", bounds)
    motion = request.trajectory
    cells = motion_cells(request, 150)
    durations = smooth_durations(cells)
    passing = np.flatnonzero(np.isfinite(durations))
    for first in passing[:: max(1, len(passing) // 5)]:
        lasting = float(durations[first])
        u = np.linspace(0.0, 1.0, 801)
        times = cells.begins[first] + lasting * (u - u**3 + u**4 / 2)
        rate = (1 - 3 * u**2 + 2 * u**3)[:, None]
        ramp = (-6 * u * (1 - u) / lasting)[:, None]
        twist = ((-6 + 12 * u) / lasting**2)[:, None]
        moves = (times < motion.duration)[:, None]
        v, vdot, vddot = (motion.tangents(times, order) * moves for order in (1, 2, 3))
        assert use(request, vdot * rate**2 + v * ramp, 2) <= ALLOWED
        jerk = vddot * rate**3 + 3 * vdot * rate * ramp + v * twist
        assert use(request, jerk, 3) <= ALLOWED


def test_smooth_stops_of_one_joint_are_not_much_longer_than_the_best() -> None:
    request = slide(4.0, "ruckig")
    stops = smooth_stops(motion_cells(request, 300))
    # From 2 m/s to rest under 10 m/s^2 and 100 m/s^3: v / a + a / j = 0.3 s at least.
    middle = len(stops.times) // 2
    assert 0.3 <= stops.times[middle] < 0.45
    assert stops.times[-1] == 0.0
    assert (stops.ends >= np.arange(len(stops.ends))).all()


@pytest.mark.parametrize("method", ["toppra", "ruckig"])
def test_a_turning_body_stops_too(method: str) -> None:
    world = bundled_world("window_3d")
    group = world.group("body")
    q0 = world.positions(group)
    q1 = np.array([0.6, 0.3, -0.7, 0.2, 0.3, 0.1, 0.6])
    q1[:4] /= np.linalg.norm(q1[:4])
    path = JointPath(group, np.stack([q0, (q0 + q1) / 2, q1])).waypoints
    path = np.array(path)
    path[1, :4] /= np.linalg.norm(path[1, :4])
    spline = blend_corners(JointPath(group, path), 0.1, 1 if method == "toppra" else 2)
    trajectory, _ = retime(spline, world.limits(group), RetimeOptions(method=method))
    request = replace(request_for(world, "body", trajectory), jerk=method == "ruckig")
    cells = motion_cells(request, 200)
    stops = hardest_stops(cells) if method == "toppra" else smooth_stops(cells)
    left = trajectory.duration - np.append(cells.begins, trajectory.duration)
    assert (stops.times <= left + 1e-9).all()
    if method == "toppra":
        assert (stops.times < 0.9 * left - 1e-3).any()
        for first in range(0, len(cells.begins), 20):
            assert ridden(request, first, 200)[1] <= ALLOWED


def test_stops_are_a_check_only_if_requested() -> None:
    world = bundled_world("ur5e_pickup")
    group = world.group("arm")
    q0 = world.positions(group)
    motion = quintic(group, q0, q0 + np.array([-1.2, 0.2, -0.3, 0.1, 0.2, 0.4]), 2.5)
    request = request_for(world, "arm", motion)
    silent, report = certify_request(world, request)
    assert report.stop is None
    assert "stop" not in {check.name for check in silent.checks}
    certificate, report = certify_request(world, replace(request, options=STOPS))
    assert certificate.checks[:-1] == silent.checks
    check, stop = certificate.checks[-1], report.stop
    assert certificate.proven
    assert stop is not None
    assert (check.name, check.value, check.bound) == ("stop", stop.time, np.inf)
    assert 0 < stop.time < motion.duration
    # Until that stop is over the tool moves no farther than at its largest speed.
    times = np.linspace(0, motion.duration, 500)
    poses = world.frame_poses(stop.frame, world.embed(group, motion.positions(times)))
    speed = np.linalg.norm(np.diff(poses[:, :3, 3], axis=0), axis=1).max() / times[1]
    assert stop.tool_distance is not None
    assert 0.2 * speed * stop.time < stop.tool_distance < 1.01 * speed * stop.time + 0.01
    for most, proven in ((stop.time * 1.001, True), (stop.time * 0.999, False)):
        bounded = CertifyOptions(stop_anywhere=True, max_stopping_time=most)
        again, _ = certify_request(world, replace(request, options=bounded))
        assert again.proven is proven
        assert {failed.name for failed in again.failed} == (set() if proven else {"stop"})


@pytest.mark.parametrize("jerk", [False, True])
def test_a_motion_without_displacement_has_stopped_already(jerk: bool) -> None:
    request = replace(slide(0.4), jerk=jerk)
    still = replace(request.trajectory, coefficients=0 * request.trajectory.coefficients)
    cells = motion_cells(replace(request, trajectory=still), 50)
    stops = smooth_stops(cells) if jerk else hardest_stops(cells)
    assert stops.times.max() <= still.duration + 1e-9
    assert (stops.times >= 0).all()
