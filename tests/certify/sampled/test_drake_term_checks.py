"""Terms of library users are evaluated on the motion itself, whatever made it."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import planning
from planning.certify.request import CertifyRequest
from planning.certify.sampled.drake_term_checks import drake_term_checks
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.curves.path import JointPath
from planning.pipeline.certification import certify_request
from planning.refine.curves.chart import FlatChart
from planning.refine.motion.spline_motion import SplineMotion
from planning.world.world import World
from tests.refine.conftest import puck_world

# A spline from rest to rest whose largest y is that of its middle control points, and less.
POINTS = np.column_stack([
    np.linspace(-0.6, 0.6, 12),
    np.concatenate([np.zeros(3), np.full(6, 0.5), np.zeros(3)]),
])


@pytest.fixture
def puck(tmp_path: Path) -> World:
    return puck_world(tmp_path, [])


@pytest.fixture
def request_of(puck: World):
    group = puck.group("puck")
    motion = SplineMotion(POINTS, 3.0).with_ends_of(POINTS, 2)
    trajectory = motion.trajectory(FlatChart(JointPath(group, POINTS)))

    def build(*terms: planning.DrakeTerm, motion: TimedTrajectory = trajectory) -> CertifyRequest:
        made = certify_request(puck, group, motion, planning.RetimeOptions(), puck.margins())
        return replace(made, terms=terms)

    return build


def below(height: float) -> planning.DrakeTerm:
    def add(trajopt: Any, _: Any) -> None:
        low, high = np.full(2, -np.inf), np.array([np.inf, height])
        for s in np.linspace(0.0, 1.0, 11):
            trajopt.AddPathPositionConstraint(low, high, s)

    return planning.DrakeTerm(add, "below")


def speed_below(limit: float) -> planning.DrakeTerm:
    def add(trajopt: Any, _: Any) -> None:
        trajopt.AddVelocityBounds(np.full(2, -limit), np.full(2, limit))

    return planning.DrakeTerm(add, "slow")


def test_the_value_is_the_largest_violation(puck, request_of):
    made = request_of(below(0.3), below(0.6))
    broken, kept = drake_term_checks(puck.drake, made)
    highest = made.trajectory.positions(np.linspace(0.0, 3.0, 11))[:, 1].max()
    assert broken.value == pytest.approx(highest - 0.3, abs=1e-9)
    assert not broken.passed
    assert kept.passed
    assert kept.value == 0.0


def test_durations_count(puck, request_of):
    slow = request_of(speed_below(2.0))
    assert drake_term_checks(puck.drake, slow)[0].passed
    quick = request_of(speed_below(2.0), motion=slow.trajectory.time_scaled(0.2))
    assert not drake_term_checks(puck.drake, quick)[0].passed


def test_a_motion_of_another_form_fails(puck, request_of):
    whole = request_of().trajectory
    cut = TimedTrajectory.joined([whole.until(1.1), whole.after(1.1)])
    (check,) = drake_term_checks(puck.drake, request_of(below(9.0), motion=cut))
    assert not check.passed
    assert check.where == "the motion is not one of Drake's program"


def test_a_variable_without_a_value_is_no_proof(puck, request_of):
    def add(trajopt: Any, _: Any) -> None:
        program = trajopt.get_mutable_prog()
        (slack,) = program.NewContinuousVariables(1)
        program.AddLinearConstraint(slack >= 0.0)

    (check,) = drake_term_checks(puck.drake, request_of(planning.DrakeTerm(add)))
    assert not check.passed
    assert check.value == np.inf
