"""Motions whose least duration is known in closed form."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planning.domain.curves.path import JointPath
from planning.domain.request.options import RetimeOptions
from planning.domain.robot.joints import JointLimits, JointType
from planning.retime.retimer import retime
from tests.conftest import group_of, limits_of, random_waypoints

ONE = group_of(JointType.REVOLUTE)
FIVE = group_of(*[JointType.REVOLUTE] * 3, *[JointType.PRISMATIC] * 2)


def ramps(length: float, speed: float, push: float) -> float:
    """Return the least time under velocity and acceleration limits: triangle or trapezoid."""
    if speed**2 / push >= length:
        return 2 * float(np.sqrt(length / push))
    return length / speed + speed / push


def s_curve(length: float, speed: float, push: float, jerk: float) -> float:
    """Return the least time with jerk limits too: seven phases, or as many as there is room for.

    Biagiotti and Melchiorri, Trajectory Planning for Automatic Machines and Robots (2008), 3.4.
    """
    reaches_push = speed * jerk >= push**2
    half = push / jerk + speed / push if reaches_push else 2 * float(np.sqrt(speed / jerk))
    if length >= speed * half:
        return length / speed + half
    if length >= 2 * push**3 / jerk**2:
        rise = push / jerk / 2
        return 2 * float(rise + np.sqrt(rise**2 + length / push))
    return 4 * float(length / (2 * jerk)) ** (1 / 3)


def limits_for(seed: int) -> JointLimits:
    rng = np.random.default_rng(seed)
    base = limits_of(FIVE)
    scale = np.exp(rng.normal(0.0, 0.7, (3, 5)))
    return JointLimits(
        base.lower,
        base.upper,
        base.velocity * scale[0],
        base.acceleration * scale[1],
        base.jerk * scale[2],
        base.effort,
        base.blocks,
    )


@pytest.mark.parametrize(("length", "phases"), [(0.01, 2), (0.39, 2), (0.41, 3), (4.0, 3)], ids=str)
def test_one_joint_is_bang_bang_at_every_instant(length: float, phases: int) -> None:
    limits = limits_of(ONE, 2.0, 10.0)  # full speed is reached after 0.2 m, and left for as much
    path = JointPath(ONE, np.array([[0.0], [length]]))
    trajectory, _ = retime(path.spline, limits, RetimeOptions())
    assert trajectory.duration == pytest.approx(ramps(length, 2.0, 10.0), rel=1e-8)
    times = np.linspace(0.0, trajectory.duration, 1001)[1:-1]
    v, vdot = trajectory.velocities(times)[:, 0], trajectory.accelerations(times)[:, 0]
    at_limit = np.isclose(np.abs(vdot), 10.0, rtol=1e-6) | np.isclose(v, 2.0, rtol=1e-6)
    assert at_limit.all()
    assert len(np.unique(np.round(vdot, 3))) == phases


@given(st.floats(0.02, 8.0), st.floats(0.2, 3.0), st.floats(0.5, 20.0), st.floats(2.0, 400.0))
def test_one_joint_under_jerk_limits_takes_the_s_curve(
    length: float, speed: float, push: float, jerk: float
) -> None:
    path = JointPath(ONE, np.array([[0.0], [length]]))
    limits = limits_of(ONE, speed, push, jerk)
    trajectory, _ = retime(path.spline, limits, RetimeOptions(method="ruckig"))
    assert trajectory.duration == pytest.approx(s_curve(length, speed, push, jerk), rel=1e-6)


@given(st.integers(0, 10_000))
def test_several_joints_on_a_line_have_the_optimum_of_the_line(seed: int) -> None:
    # On a straight line each joint moves its share of the way: the tightest of each kind binds.
    limits = limits_for(seed)
    waypoints = random_waypoints(FIVE, seed, 2)
    shares = np.abs(waypoints[1] - waypoints[0])
    path = JointPath(FIVE, waypoints)
    speed, push, jerk = (
        float(np.min(bound / shares))
        for bound in (limits.velocity, limits.acceleration, limits.jerk)
    )
    quick, _ = retime(path.spline, limits, RetimeOptions())
    smooth, _ = retime(path.spline, limits, RetimeOptions(method="ruckig"))
    assert quick.duration == pytest.approx(ramps(1.0, speed, push), rel=1e-6)
    assert smooth.duration == pytest.approx(s_curve(1.0, speed, push, jerk), rel=1e-6)
    # No joint could be quicker by itself, and the slowest is no quicker than all together.
    alone = [
        ramps(float(share), float(v), float(a))
        for share, v, a in zip(shares, limits.velocity, limits.acceleration, strict=True)
    ]
    assert quick.duration >= max(alone) * (1 - 1e-9)


@given(st.integers(0, 10_000))
def test_the_slowest_joint_decides_where_the_limits_go_together(seed: int) -> None:
    # With v, a and j in proportion for every joint, the line is as quick as its slowest joint.
    shares = np.abs(random_waypoints(FIVE, seed, 2)[1]) + 0.05
    path = JointPath(FIVE, np.stack([np.zeros(5), shares]))
    limits = limits_of(FIVE, 1.5, 6.0, 60.0)
    quick, _ = retime(path.spline, limits, RetimeOptions())
    smooth, _ = retime(path.spline, limits, RetimeOptions(method="ruckig"))
    assert quick.duration == pytest.approx(max(ramps(s, 1.5, 6.0) for s in shares), rel=1e-6)
    slowest = max(s_curve(s, 1.5, 6.0, 60.0) for s in shares)
    assert smooth.duration == pytest.approx(slowest, rel=1e-6)


def test_a_path_with_corners_that_may_not_be_rounded_is_as_quick_as_its_lines() -> None:
    waypoints = random_waypoints(FIVE, 4, 5)
    limits = limits_of(FIVE, 1.5, 6.0, 60.0)
    path = JointPath(FIVE, waypoints)
    lines = [np.abs(step).max() for step in np.diff(waypoints, axis=0)]
    quick, report = retime(path.spline, limits, RetimeOptions())
    smooth, _ = retime(path.spline, limits, RetimeOptions(method="ruckig"))
    assert report.stops == 3
    assert quick.duration == pytest.approx(sum(ramps(x, 1.5, 6.0) for x in lines), rel=1e-6)
    expected = sum(s_curve(x, 1.5, 6.0, 60.0) for x in lines)
    assert smooth.duration == pytest.approx(expected, rel=1e-6)
