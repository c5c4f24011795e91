"""The steering check proves motions of cars, and names what it refuses."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planning.certify.intervals.bernstein_products import elevate_degree, multiply
from planning.certify.request import CertifyRequest
from planning.certify.steering_check import steering_checks
from planning.domain.curves.curve import JointSpline, TimedTrajectory
from planning.domain.curves.path import JointPath
from planning.domain.report.certificate import Check
from planning.domain.request.options import RetimeOptions
from planning.domain.robot.joints import JointGroup, JointType
from planning.domain.robot.steering import Steering, manifold_of, steered
from planning.retime.retimer import retime
from planning.world.collision.margins import PairMargins
from tests.conftest import group_of, limits_of
from tests.drivers import assert_driven

RADIUS = 0.5
KINDS = (JointType.FLOATING, JointType.PLANAR, JointType.REVOLUTE)
CAR = "g::j1"
# Arcs and lines (v_x, omega): left at full lock, straight, right, gently left, and back.
PIECES = [(0.8, 1.6), (0.5, 0.0), (0.9, -1.8), (0.7, 0.3), (-0.4, 0.8)]


def group_with(radius: float = RADIUS, *, reverse: bool = True) -> JointGroup:
    return steered(group_of(*KINDS), {CAR: Steering(radius, reverse)})


def motion(pieces: list[tuple[float, float]], method: str = "toppra") -> TimedTrajectory:
    """Return the motion of a group that contains a car, along arcs one after another."""
    group = group_with()
    manifold = manifold_of(group)
    rows = [np.array([1.0, 0, 0, 0, 0, 0, 0, 0.2, -0.1, 2.9, 0.0])]
    for ahead, turn in pieces:
        delta = np.array([0, 0, 0.1, 0.2, 0, 0, ahead, 0.0, turn, 0.3])
        rows.append(manifold.plus(rows[-1], delta))
    spline = JointPath(group, np.array(rows)).spline
    options = RetimeOptions(method="ruckig" if method == "ruckig" else "toppra")
    return retime(spline, limits_of(group), options)[0]


def checked(trajectory: TimedTrajectory, group: JointGroup) -> Check:
    request = CertifyRequest(
        group=group,
        trajectory=trajectory,
        state=np.zeros(20),
        start=trajectory.start,
        goals=trajectory.end[None],
        limits=limits_of(group),
        margins=PairMargins(0.0, {}, {}),
        jerk=False,
    )
    (check,) = steering_checks(request)
    assert check.name == f"steering {CAR}"
    return check


@pytest.mark.parametrize("method", ["toppra", "ruckig"])
def test_planned_car_motions_are_proven(method: str) -> None:
    trajectory = motion(PIECES, method)
    check = checked(trajectory, group_with())
    assert check.passed
    assert check.value == pytest.approx(1.0, abs=1e-3)
    assert check.value + check.resolution == pytest.approx(check.bound)
    assert_driven(trajectory, RADIUS, reverse=True, at=(7, 6))


@pytest.mark.parametrize(
    ("radius", "reverse", "pieces", "where"),
    [
        (RADIUS * 1.001, True, PIECES, "curvature"),
        (RADIUS, False, PIECES, "reverse"),
        (RADIUS, True, [(0.5, 0.0), (0.2, 0.41)], "curvature"),
        (RADIUS, True, [(0.0, 0.5)], "curvature"),
        (RADIUS, False, [(0.5, 0.0), (-0.01, 0.0)], "reverse"),
    ],
)
def test_too_tight_and_backwards_are_refused(
    radius: float, reverse: bool, pieces: list[tuple[float, float]], where: str
) -> None:
    check = checked(motion(pieces), group_with(radius, reverse=reverse))
    assert not check.passed
    assert check.where == where
    assert check.value > check.bound
    assert np.isfinite([check.value, check.resolution]).all()


@given(power=st.sampled_from([1.0, 3e-1, 3e-2, 3e-3]), slowness=st.sampled_from([1.0, 30.0]))
def test_a_slip_is_refused_at_any_speed(power: float, slowness: float) -> None:
    """A bump pulls the base aside by a share of its path, in the middle alone."""
    sound = motion(PIECES)
    slipping = np.array(sound.coefficients)
    piece = int(np.argmax(np.abs(slipping[:, 1, 6:8]).max(axis=1)))
    width = float(np.diff(sound.breaks)[piece])
    # s^2 (1 - s)^2 vanishes at both ends, and so does its derivative.
    bump = power * 0.05 * width * np.array([0, 0, 1, -2, 1]) / width ** np.arange(5.0)
    slipping[piece, :5, 6] += bump
    slipping[piece, :5, 7] -= bump
    moved = replace(sound, coefficients=slipping).time_scaled(slowness)
    check = checked(moved, group_with())
    assert not check.passed
    assert check.where in {"sideways", "curvature"}
    assert checked(sound.time_scaled(slowness), group_with()).passed


def test_a_geodesic_is_refused_for_a_car() -> None:
    group = group_with()
    rows = np.array([
        [1.0, 0, 0, 0, 0, 0, 0, 0.0, 0.0, 0.0, 0.0],
        [1.0, 0, 0, 0, 0, 0, 0, 1.0, 0.4, 0.5, 0.0],
    ])
    trajectory = retime(JointSpline.through(group.joints, rows), limits_of(group), RetimeOptions())[
        0
    ]
    assert checked(trajectory, group).where == "sideways"


def test_a_base_that_spins_fast_is_unproven() -> None:
    joints = group_of(*KINDS).joints
    coefficients = np.zeros((1, 2, 10))
    coefficients[0, 1, 8] = 1e6
    bases = np.array([[1.0, 0, 0, 0, 0, 0, 0, 0.0, 0.0, 0.0, 0.0]])
    whirl = TimedTrajectory(joints, np.array([0.0, 1.0]), bases, coefficients)
    check = checked(whirl, group_with())
    assert not check.passed
    # It turns in place: the utilization relative to the neglected speed is the largest possible.
    assert check.value + check.resolution == pytest.approx(1e6 * RADIUS / 1e-6)


def test_a_group_without_cars_has_no_such_check() -> None:
    trajectory = motion(PIECES)
    with pytest.raises(ValueError, match="unpack"):
        checked(trajectory, group_of(*KINDS))


@given(seed=st.integers(0, 1000), i=st.integers(0, 5), j=st.integers(0, 5))
def test_products_of_bernstein_forms(seed: int, i: int, j: int) -> None:
    a, b = (np.random.default_rng(seed).normal(size=(3, k + 1)) for k in (i, j))

    def value(form: np.ndarray, x: float) -> np.ndarray:
        while form.shape[1] > 1:
            form = (1 - x) * form[:, :-1] + x * form[:, 1:]
        return form[:, 0]

    for x in (0.0, 0.3, 1.0):
        assert value(multiply(a, b), x) == pytest.approx(value(a, x) * value(b, x), abs=1e-12)
        assert value(elevate_degree(a, i + j), x) == pytest.approx(value(a, x), abs=1e-12)
