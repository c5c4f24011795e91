"""Stops under limits on torques and on accelerations of frames: kept at every instant."""

from collections.abc import Callable
from dataclasses import replace
from typing import Literal

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planning.certify.certifier import CertifyRequest, certify
from planning.certify.frames.frame_states import FrameStates
from planning.certify.intervals.motion_cells import MotionCells, motion_cells
from planning.certify.stopping.stop_constraint import StopConstraint
from planning.certify.stopping.stop_constraints import with_stop_constraints
from planning.certify.stopping.stops import hardest_stops, max_braking, smooth_durations
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.curves.path import JointPath
from planning.domain.report.stop_report import StopReport
from planning.domain.request.deadline import Deadline
from planning.domain.request.motion_limits import ToolLimit
from planning.domain.request.options import CertifyOptions, RetimeOptions
from planning.domain.robot.payload import Payload
from planning.retime.blend import blend_corners
from planning.retime.limits.request_limits import path_limits
from planning.retime.retimer import retime
from planning.world.mechanics.dynamics import GroupDynamics
from planning.world.world import World
from tests.certify.conftest import quintic, request_for
from tests.clocks import no_hurry
from tests.conftest import bundled_world
from tests.profiles import num_cases

TOOL = ToolLimit("panda::panda_hand", None, 3.0)
LOAD = Payload.from_parts("panda::panda_hand", 4.0, (0.0, 0.05, 0.1))
# What limits may be passed by, and what rounding adds in these tests.
ALLOWED = 1 + 3e-6

ARM = """<robot name="p"><link name="base"/><link name="bob"><inertial>
<origin xyz="0 0 -0.5"/><mass value="2"/>
<inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="swing" type="{kind}"><parent link="base"/><child link="bob"/><axis xyz="{axis}"/>
<limit lower="-9" upper="9" velocity="100" effort="{effort}"/><dynamics damping="{damping}"/>
</joint></robot>"""


def soon() -> Deadline:
    return no_hurry(30.0)


def loaded(world: World, request: CertifyRequest, count: int = 300) -> MotionCells:
    return with_stop_constraints(world.drake, request, motion_cells(request, count), soon())


def detour(
    seed: int, method: Literal["toppra", "ruckig"], *, effort: bool
) -> tuple[World, CertifyRequest]:
    """Return the quickest motion of the Panda over a corner under a limit of either kind."""
    world = bundled_world("panda_shelf")
    group = world.group("panda")
    rng = np.random.default_rng(seed)
    rows = world.positions(group) + np.concatenate([np.zeros((1, 7)), rng.normal(0, 0.25, (3, 7))])
    spline = blend_corners(JointPath(group, rows), 0.1, 1 if method == "toppra" else 2)
    options = RetimeOptions(method=method, tool_limits=() if effort else (TOOL,))
    trajectory, _ = retime(spline, world.limits(group), options, path_limits(world, group, options))
    request = request_for(world, "panda", trajectory)
    request = replace(request, jerk=method == "ruckig", tool_limits=options.tool_limits)
    return world, just_strong_enough(world, request) if effort else request


def just_strong_enough(world: World, request: CertifyRequest) -> CertifyRequest:
    """Return the request with effort limits just above what motion and rest need."""
    motion = request.trajectory
    times = np.linspace(0.0, motion.duration, 1000)
    rates = motion.positions(times), motion.velocities(times), motion.accelerations(times)
    dynamics = GroupDynamics(world, request.group, LOAD)
    taken = np.abs([dynamics.efforts(*rates), dynamics.path_efforts(*rates).static]).max(
        axis=(0, 1)
    )
    limits = replace(request.limits, effort=1.02 * taken + 0.01)
    return replace(request, effort=True, payload=LOAD, limits=limits)


type Ride = tuple[np.ndarray, np.ndarray, np.ndarray]


def ridden(cells: MotionCells, first: int) -> tuple[Ride, float]:
    """Follow the hardest stop from a cell on: instants of the motion, s'^2 and x, and the time.

    The time is infinite where the ride meets a cell that leaves no way on.
    """
    y, clock, at = 1.0, 0.0, first
    found: list[np.ndarray] = []
    while y > 1e-12 and at < len(cells.begins):
        width = float(cells.widths[at])
        x = float(max_braking(cells, np.array([at]), np.array([y]))[0])
        if np.isnan(x):
            clock = np.inf
            break
        assert x >= 0
        local = np.linspace(0.0, width, 9)
        local = local[2 * x * local <= y]
        found.append(
            np.stack([
                cells.begins[at] + np.clip(local, 1e-9, width - 1e-9),
                y - 2 * x * local,
                np.full(len(local), x),
            ])
        )
        after = max(y - 2 * x * width, 0.0)
        passed = width if after > 1e-12 else y / (2 * x)
        clock += 2 * passed / (np.sqrt(y) + np.sqrt(after))
        y, at = after, at + 1
    times, ys, xs = np.concatenate([np.empty((3, 0)), *found], axis=1)
    return (times, ys, xs), clock


def torque_use(world: World, request: CertifyRequest, ride: Ride) -> float:
    """Return peak over limit by Drake's inverse dynamics."""
    times, y, x = ride
    motion, rate = request.trajectory, np.sqrt(np.maximum(y, 0.0))[:, None]
    v, vdot = motion.velocities(times), motion.accelerations(times)
    dynamics = GroupDynamics(world, request.group, request.payload)
    efforts = dynamics.efforts(motion.positions(times), v * rate, vdot * rate**2 - v * x[:, None])
    return float((np.abs(efforts) / request.limits.effort).max())


def frame_use(world: World, request: CertifyRequest, ride: Ride) -> float:
    """Return the same of the acceleration of the limited frame."""
    times, y, x = ride
    (limit,) = request.tool_limits
    seen = FrameStates(world.drake, request, limit.frame).at(
        *request.trajectory.locate(times), soon()
    )
    found = seen.acceleration * y[:, None] - seen.velocity * x[:, None]
    assert limit.acceleration is not None
    return float(np.linalg.norm(found, axis=1).max() / limit.acceleration)


@pytest.mark.parametrize(("effort", "use"), [(True, torque_use), (False, frame_use)])
def test_hardest_stops_keep_them_at_every_instant(
    effort: bool, use: Callable[[World, CertifyRequest, Ride], float]
) -> None:
    @given(seed=st.integers(0, 1000), start=st.floats(0.05, 0.9))
    @settings(max_examples=num_cases(2))
    def kept(seed: int, start: float) -> None:
        world, request = detour(seed, "toppra", effort=effort)
        cells = loaded(world, request)
        assert cells.can_rest.all()
        first = int(start * len(cells.begins))
        ride, clock = ridden(cells, first)
        assert use(world, request, ride) <= ALLOWED
        reported = float(hardest_stops(cells).times[first])
        left = request.trajectory.duration - float(cells.begins[first])
        assert reported == pytest.approx(min(clock, left), rel=1e-9)

    kept()


@pytest.mark.parametrize("effort", [True, False])
def test_stops_without_these_constraints_violate_them(effort: bool) -> None:
    world, request = detour(3, "toppra", effort=effort)
    cells = loaded(world, request)
    use = torque_use if effort else frame_use
    worst, kept = 0.0, 0.0
    for first in range(0, len(cells.begins), 30):
        worst = max(
            worst, use(world, request, ridden(replace(cells, stop_constraints=()), first)[0])
        )
        kept = max(kept, use(world, request, ridden(cells, first)[0]))
    assert kept <= ALLOWED
    assert worst > 1.05
    # They use the full limits.
    assert kept > 0.97


@pytest.mark.parametrize(("effort", "use"), [(True, torque_use), (False, frame_use)])
def test_smooth_stops_keep_them_too(
    effort: bool, use: Callable[[World, CertifyRequest, Ride], float]
) -> None:
    world, request = detour(1, "ruckig", effort=effort)
    cells = loaded(world, request, 150)
    durations = smooth_durations(cells)
    passing = np.flatnonzero(np.isfinite(durations))
    assert len(passing) > 20
    for first in passing[:: len(passing) // 5]:
        lasting = float(durations[first])
        u = np.linspace(0.0, 1.0, 201)
        times = cells.begins[first] + lasting * (u - u**3 + u**4 / 2)
        moves = times < request.trajectory.duration
        rate, ramp = 1 - 3 * u**2 + 2 * u**3, 6 * u * (1 - u) / lasting
        assert use(world, request, (times[moves], rate[moves] ** 2, ramp[moves])) <= ALLOWED


def cruise(world: World, way: float) -> TimedTrajectory:
    """Return a motion of one joint that is at 2 rad/s or m/s for most of its 2 s."""
    speed = np.sign(way) * 2.0
    coefficients = np.zeros((3, 3, 1))
    coefficients[0, 2] = speed / 2 / 0.5
    coefficients[1, 1] = speed
    coefficients[2, 1:, 0] = speed, -speed / 2 / 0.5
    bases = np.array([[0.0], [speed * 0.25], [speed * 1.25]])
    breaks = np.array([0.0, 0.5, 1.5, 2.0])
    return TimedTrajectory(world.group("r").joints, breaks, bases, coefficients)


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize("damping", [0.0, 3.0])
def test_a_lift_stops_as_quickly_as_its_motor_and_gravity_allow(
    urdf_world: Callable[..., World], way: float, damping: float
) -> None:
    weight, effort = 2 * 9.81, 40.0
    world = urdf_world(ARM.format(kind="prismatic", axis="0 0 1", effort=effort, damping=damping))
    request = replace(request_for(world, "r", cruise(world, way)), effort=True)
    limits = replace(request.limits, acceleration=np.full(1, 1e3))
    cells = loaded(world, replace(request, limits=limits), 600)
    stops = hardest_stops(cells)
    # Against the motion: the motor, gravity if it goes up, and damping d v; m v' = -(f + d v).
    force = effort + np.sign(way) * weight
    best = 2.0 / (force / 2) if not damping else 2 / damping * np.log1p(damping * 2.0 / force)
    middle = len(cells.begins) // 3
    assert stops.times[middle] >= best - 1e-6
    assert stops.times[middle] <= best * 1.02 + 2 * cells.widths.max()


def pendulum(urdf_world: Callable[..., World], damping: float) -> tuple[World, CertifyRequest]:
    """Return a swing through the horizontal, where the motor is too weak to hold it."""
    axis = "0 1 0"
    world = urdf_world(ARM.format(kind="revolute", axis=axis, effort=9.81 * 0.95, damping=damping))
    motion = quintic(world.group("r"), np.array([0.3]), np.array([2.0]), 2.2)
    return world, replace(request_for(world, "r", motion), effort=True)


def found(world: World, request: CertifyRequest, most: float | None = None) -> StopReport:
    options = CertifyOptions(stop_anywhere=True, max_stopping_time=most)
    certificate, report = certify(world.drake, replace(request, options=options), soon())
    assert report.stop is not None
    assert {check.name for check in certificate.failed} <= {"stop"}
    check = certificate.checks[-1]
    assert (check.name, check.where) == ("stop", report.stop.unheld)
    assert check.passed is (most is None or report.stop.time <= most)
    return report.stop


@pytest.mark.parametrize("jerk", [False, True])
def test_no_stop_ends_where_the_motor_is_too_weak_and_the_report_says_where(
    urdf_world: Callable[..., World], jerk: bool
) -> None:
    world, request = pendulum(urdf_world, 0.0)
    if jerk:
        limits = replace(request.limits, jerk=np.full(1, 1e3))
        request = replace(request, jerk=True, limits=limits)
    report = found(world, request)
    assert report.unheld == "torque r::swing"
    assert report.unheld_at is not None
    at = float(request.trajectory.positions(np.array([report.unheld_at]))[0, 0])
    assert at == pytest.approx(np.pi / 2, abs=0.02)
    times = np.linspace(0.0, 2.2, 2001)
    angles = request.trajectory.positions(times)[:, 0]
    weak = times[np.sin(angles) > 0.95]
    # From where it becomes too weak the swing goes on to where it is strong again.
    assert report.time >= weak[-1] - weak[0]
    assert found(world, request, most=0.9 * report.time).time == report.time
    stronger = replace(request.limits, effort=request.limits.effort * 1.1)
    strong = found(world, replace(request, limits=stronger))
    assert (strong.unheld, strong.unheld_at) == ("", None)
    assert strong.time < 0.7 * report.time


def test_stops_of_a_weak_pendulum_end_where_it_can_be_held(
    urdf_world: Callable[..., World],
) -> None:
    world, request = pendulum(urdf_world, 0.02)
    cells = loaded(world, request, 400)
    assert not cells.can_rest.all()
    stops, rode, waited = hardest_stops(cells), 0, 0
    for first in range(0, len(cells.begins), 7):
        ride, clock = ridden(cells, first)
        left = cells.end - cells.begins[first]
        if np.isinf(clock):
            waited += 1
            later = float(cells.widths[first] + stops.times[first + 1])
            assert stops.times[first] == pytest.approx(min(later, left))
            continue
        rode += 1
        assert torque_use(world, request, ride) <= ALLOWED
        stood = np.searchsorted(cells.begins, ride[0][-1], side="right") - 1
        assert cells.can_rest[stood]
        assert stops.times[first] == pytest.approx(min(clock, left))
    assert rode > 10
    assert waited > 10


def test_overflow_leaves_no_admissible_braking() -> None:
    form = np.ones((3, 2, 1, 1))
    form[1, 0] = np.inf
    form[2, 1] = np.nan
    bounds = np.full((3, 1), 2.0)
    load = StopConstraint(
        ("a",), form, form, form[:1] * 0 + np.zeros((3, 1, 1, 1)), None, 0 * bounds, bounds
    )
    assert load.without_overflow.is_satisfied_at_rest[:, 0].tolist() == [True, False, False]
    assert np.isfinite(load.without_overflow.by_path_acceleration).all()
