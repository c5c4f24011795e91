"""Ends and continuity: jumps where pieces meet are refused, and smooth joints pass."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.geometry import Sphere

from planning.certify.certifier import CertifyRequest, certify
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.robot.joints import JointLimits
from planning.world.collision.margins import PairMargins
from tests.certify.chains import FLOATING, Builder, P, Robot
from tests.clocks import no_hurry

pytestmark = [pytest.mark.usefixtures("implementation"), pytest.mark.drake_only]


def slider(limit: float = 10.0) -> tuple[Robot, JointLimits]:
    builder = Builder()
    builder.link(P, Sphere(0.05))
    robot = builder.build()
    return robot, robot.limits(limit)


def failures(robot: Robot, request: CertifyRequest) -> set[str]:
    certificate, _ = certify(robot.model, request, no_hurry(9.0))
    assert certificate.proven is (not certificate.failed)
    return {check.name for check in certificate.failed}


def pieces(robot: Robot, *coefficients: tuple[float, ...]) -> TimedTrajectory:
    """Return pieces of one second each, each anchored where the one before it ends."""
    q, bases = 0.0, []
    for piece in coefficients:
        bases.append([q])
        q += sum(piece)
    return TimedTrajectory(
        robot.group.joints,
        np.arange(len(coefficients) + 1.0),
        np.array(bases),
        np.array(coefficients)[:, :, None],
    )


# x(t) over one second: from rest to speed 1, on, and to rest again, smoothly to second order.
START, ON, STOP = (0.0, 0.0, 0.0, 1.0, -0.5), (0.0, 1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, -1.0, 0.5)


@pytest.mark.parametrize("jerk", [False, True])
def test_smooth_pieces_pass(jerk: bool) -> None:
    robot, limits = slider(20.0)
    request = robot.request(pieces(robot, START, ON, STOP), PairMargins(0.0))
    assert not failures(robot, replace(request, limits=limits, jerk=jerk))


def test_a_jump_of_speed_is_refused() -> None:
    robot, limits = slider(20.0)
    faster = (0.0, 1.01, 0.0, 0.0, 0.0)
    request = robot.request(pieces(robot, START, faster, STOP), PairMargins(0.0))
    assert failures(robot, replace(request, limits=limits)) == {"velocity continuity"}


def test_a_jump_of_acceleration_matters_only_if_jerk_is_limited() -> None:
    robot, limits = slider(20.0)
    ramp, brake = (0.0, 0.0, 0.5, 0.0, 0.0), (0.0, 1.0, -0.5, 0.0, 0.0)
    request = replace(robot.request(pieces(robot, ramp, brake), PairMargins(0.0)), limits=limits)
    assert not failures(robot, request)
    assert failures(robot, replace(request, jerk=True)) == {"acceleration continuity"}


def test_a_step_of_acceleration_from_rest_is_an_infinite_jerk() -> None:
    robot, limits = slider(20.0)
    # Speed t (1 - t): at rest at both ends, accelerating at once.
    hop = (0.0, 0.0, 0.5, -1.0 / 3.0, 0.0)
    request = replace(robot.request(pieces(robot, hop), PairMargins(0.0)), limits=limits)
    assert not failures(robot, request)
    assert failures(robot, replace(request, jerk=True)) == {"acceleration continuity"}


def test_limits_are_those_of_blocks_and_of_true_angular_rates() -> None:
    builder = Builder()
    builder.link(FLOATING, Sphere(0.05))
    robot = builder.build()
    q0 = np.eye(7)[0]
    coefficients = np.zeros((1, 6, 6))
    for power, factor in ((3, 10.0), (4, -15.0), (5, 6.0)):
        coefficients[0, power, :2] = factor * np.array([0.6, 0.8])
        coefficients[0, power, 3:5] = factor * np.array([0.3, 0.4])
    motion = TimedTrajectory(robot.group.joints, np.array([0.0, 1.0]), q0[None], coefficients)
    request = robot.request(motion, PairMargins(0.0))
    # The speed of 10 x^3 - 15 x^4 + 6 x^5 peaks at 15/8: of 1 rad, and of 0.5 m.
    for share, proven in ((1.001, True), (0.999, False)):
        peaks = np.array([1.875, 0.9375]) * share
        limits = replace(request.limits, velocity=peaks)
        assert (failures(robot, replace(request, limits=limits)) == set()) is proven


def test_the_nearest_goal_counts_and_so_does_the_start() -> None:
    robot, limits = slider(20.0)
    request = replace(robot.request(pieces(robot, START, STOP), PairMargins(0.0)), limits=limits)
    end = request.trajectory.end
    far = np.stack([end + 1.0, end - 1.0])
    assert failures(robot, replace(request, goals=far)) == {"goal"}
    assert not failures(robot, replace(request, goals=np.stack([end + 1.0, end])))
    assert failures(robot, replace(request, start=request.start + 1e-5)) == {"start"}
