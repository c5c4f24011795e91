"""A refined curve is free, within limits, from start to goal, and quicker; or there is none."""

import pickle
import subprocess
import sys
import time
from dataclasses import replace
from itertools import count
from pathlib import Path

import numpy as np
import pytest

from planning.domain.deadline import Deadline
from planning.domain.manifold import Manifold
from planning.domain.options import RefineOptions
from planning.domain.path import JointPath
from planning.domain.value import digest
from planning.refine import refiner
from planning.refine.buffers import Buffers
from planning.refine.program import CurveProgram, Solution
from planning.refine.refiner import RefineRequest, refine

FINE = np.linspace(0, 1, 400)

AGAIN = """
import pickle, sys, time
from planning.domain.deadline import Deadline
from planning.domain.value import digest
from planning.refine.refiner import RefineRequest, refine
from planning.world.world import load_world
scene, request = pickle.load(open(sys.argv[1], "rb"))
curve, report = refine(load_world(scene), request, Deadline.after(60.0, time.monotonic))
print(digest((curve, report)))
"""


@pytest.mark.slow
def test_the_curve_is_free_and_keeps_every_limit(case):
    curve, report = case.refined()
    assert curve is not None, report.reason
    assert report.improved
    assert report.reason == ""
    assert report.solver == "SNOPT"
    assert case.are_free(curve.positions(FINE)).all()
    limits, s = case.request.limits, np.linspace(0, 1, 2001)
    assert (curve.positions(s) >= limits.lower - 1e-9).all()
    assert (curve.positions(s) <= limits.upper + 1e-9).all()
    duration = report.duration_after
    velocity = limits.per_coordinate(limits.velocity)
    acceleration = limits.per_coordinate(limits.acceleration)
    # SNOPT meets nonlinear constraints to its tolerance; the retimer bounds rates exactly.
    assert (np.abs(curve.tangents(s, 1)) / duration <= velocity * 1.01).all()
    assert (np.abs(curve.tangents(s, 2)) / duration**2 <= acceleration * 1.01).all()
    if case.request.jerk:
        jerk = limits.per_coordinate(limits.jerk)
        assert (np.abs(curve.tangents(s, 3)) / duration**3 <= jerk * 1.01).all()


@pytest.mark.slow
def test_the_curve_joins_start_and_goal_and_is_quicker(case):
    curve, report = case.refined()
    assert curve is not None, report.reason
    waypoints = case.request.path.waypoints
    manifold = Manifold(case.request.path.group.joints)
    np.testing.assert_array_equal(curve.start, waypoints[0])
    assert manifold.distance(curve.end, waypoints[-1]) < 1e-12
    assert report.duration_after < report.duration_before
    assert report.length_after <= report.length_before
    assert report.length_before == case.request.path.length
    np.testing.assert_allclose(curve.breaks[[0, -1]], [0, 1], atol=0)


@pytest.mark.slow
def test_the_curve_is_smooth_and_rests_nowhere(case):
    curve, _ = case.refined()
    joints = curve.breaks[1:-1]
    before = joints - 1e-12
    np.testing.assert_allclose(curve.positions(before), curve.positions(joints), atol=1e-9)
    for order in (1, 2):
        left, right = curve.tangents(before, order), curve.tangents(joints, order)
        np.testing.assert_allclose(left, right, atol=1e-8 * np.abs(right).max())
    speeds = np.linalg.norm(curve.tangents(np.linspace(0, 1, 501), 1), axis=1)
    assert speeds.min() > 1e-3 * speeds.max()


def test_an_angle_takes_the_short_way_across_the_half_turn(arm):
    curve, report = arm.refined()
    assert curve is not None, report.reason
    assert curve.end[0] == pytest.approx(np.pi + 0.6)
    assert np.abs(curve.positions(FINE)[:, 0] - np.pi).max() < 1.5


def test_instants_at_which_a_solution_is_too_near_are_added(thin_wall, monkeypatch):
    added: list[np.ndarray] = []
    keep = CurveProgram.keep_distance_at

    def spy(self, instants):
        added.append(instants)
        keep(self, instants)

    monkeypatch.setattr(refiner, "_MAX_ROUNDS", 1)
    curve, report = thin_wall.refined()
    assert curve is None
    assert report.rounds == 1
    named = [float(s) for s in report.reason.split(" s = ")[1].split(", ")]
    monkeypatch.setattr(refiner, "_MAX_ROUNDS", 2)
    monkeypatch.setattr(CurveProgram, "keep_distance_at", spy)
    thin_wall.refined()
    np.testing.assert_allclose(added[1][:5], named, atol=5e-4)


def test_a_wall_between_two_instants_is_found_and_avoided(thin_wall):
    curve, report = thin_wall.refined()
    assert curve is not None, report.reason
    assert report.rounds > 1
    assert thin_wall.are_free(curve.positions(np.linspace(0, 1, 5001))).all()


@pytest.mark.slow
def test_added_instants_alone_free_a_curve(pillar, monkeypatch):
    monkeypatch.setattr(refiner, "_PATIENCE", refiner._MAX_ROUNDS + 1)
    curve, report = pillar.refined()
    assert curve is not None, report.reason
    assert report.rounds > 1
    keep = CurveProgram.keep_distance_at

    def keep_only_first(self, instants):
        if instants is refiner._FIRST_INSTANTS:
            keep(self, instants)

    monkeypatch.setattr(CurveProgram, "keep_distance_at", keep_only_first)
    curve, report = pillar.refined()
    assert curve is None
    assert report.rounds == refiner._MAX_ROUNDS


@pytest.mark.slow
def test_the_same_request_gives_the_same_bytes_in_another_process(pillar, tmp_path: Path):
    first = digest(pillar.refined())
    assert digest(pillar.refined()) == first
    file = tmp_path / "case.pickle"
    file.write_bytes(pickle.dumps((pillar.world.scene, pillar.request)))
    again = subprocess.run(
        [sys.executable, "-c", AGAIN, str(file)], check=True, capture_output=True, text=True
    )
    assert again.stdout.strip().splitlines()[-1] == first


def test_what_was_not_asked_for_is_not_done(thin_wall):
    request = replace(thin_wall.request, options=RefineOptions("none"))
    curve, report = replace(thin_wall, request=request).refined()
    assert curve is None
    assert (report.method, report.improved, report.reason) == ("none", False, "not asked for")


def test_floating_joints_are_left_alone(world_of):
    world = world_of("window_3d")
    group = next(g for g in world.groups if not Manifold(g.joints).is_flat)
    q = world.positions(group)
    path = JointPath(group, np.stack([q, q + np.eye(7)[6] * 0.01]))
    request = RefineRequest(path, world.limits(group), world.margins(), RefineOptions())
    curve, report = refine(world, request, Deadline.after(5, lambda: 0.0))
    assert curve is None
    assert "R^n" in report.reason


def test_a_path_that_does_not_move_is_left_alone(thin_wall):
    still = replace(thin_wall.request.path, waypoints=np.full((3, 2), 0.4))
    curve, report = replace(thin_wall, request=replace(thin_wall.request, path=still)).refined()
    assert curve is None
    assert report.reason == "the path does not move"


def test_after_the_deadline_the_path_goes_on(thin_wall):
    curve, report = thin_wall.refined(seconds=0.0)
    assert curve is None
    assert report.reason == "no time was left"


def test_a_deadline_between_rounds_ends_the_work(thin_wall):
    ticks = count()
    request = thin_wall.request
    deadline = Deadline.after(4.0, lambda: float(next(ticks)) / 2)
    curve, report = refine(thin_wall.world, request, deadline)
    assert report.rounds <= 2
    assert (curve is not None) == report.improved


def test_a_solver_that_breaks_is_no_failure(thin_wall, monkeypatch):
    def broken(self, seconds):
        message = "q contains NaN"
        raise RuntimeError(message)

    monkeypatch.setattr(CurveProgram, "solve", broken)
    curve, report = thin_wall.refined()
    assert curve is None
    assert report.reason == "the solver stopped: q contains NaN"


def test_a_straight_path_is_left_alone_after_one_round(make_puck):
    world = make_puck([])
    path = JointPath(world.group("puck"), np.array([[-0.5, -0.5], [0.5, 0.5]]))
    request = RefineRequest(path, world.limits(path.group), world.margins(), RefineOptions())
    curve, report = refine(world, request, Deadline.after(60, time.monotonic))
    assert curve is None
    assert "nothing quicker" in report.reason
    assert report.rounds == 1


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"cut_short": True}, "no time was left"),
        ({"duration": 99.0}, "nothing quicker"),
        ({"control_points": np.linspace([-0.6, 0.1], [0.6, 0.1], 14)}, "too near to something"),
        ({"control_points": np.array([[-0.6, 0.1], *[[0.0, 3.0]] * 12, [0.6, 0.1]])}, "limits"),
    ],
)
def test_solutions_that_are_no_good_are_refused(thin_wall, monkeypatch, change: dict, reason: str):
    def solve(self, seconds):
        found = Solution(self.guess, self.guessed_duration / 2, converged=True, cut_short=False)
        return replace(found, **change)

    monkeypatch.setattr(CurveProgram, "solve", solve)
    curve, report = thin_wall.refined()
    assert curve is None
    assert reason in report.reason


def test_a_robot_that_stands_near_a_wall_does_not_hinder_another(make_puck):
    wall = ([0.2, 0.2, 0.2], [0.0, 0.0, 0.0])
    # The idle puck stands on four slabs at once, a tenth of a millimetre above each.
    slabs = [([0.2, 0.2, 0.02], [3.0 + x, y, -0.0301]) for x in (-0.1, 0.1) for y in (-0.1, 0.1)]
    world = make_puck([wall, *slabs], idle=[3.0, 0.0, 0.0])
    waypoints = [[-0.6, 0.0], [-0.2, 0.4], [0.2, 0.4], [0.6, 0.0]]
    path = JointPath(world.group("puck"), np.array(waypoints))
    request = RefineRequest(path, world.limits(path.group), world.margins(), RefineOptions())
    curve, report = refine(world, request, Deadline.after(60, time.monotonic))
    assert curve is not None, report.reason
    oracle = world.collision_oracle(path.group, world.margins())
    assert oracle.are_free(curve.positions(FINE)).all()


def test_steps_are_bounded_where_instants_alone_do_not_help(thin_wall, monkeypatch):
    monkeypatch.setattr(refiner, "_PATIENCE", refiner._MAX_ROUNDS + 1)
    curve, _ = thin_wall.refined()
    assert curve is None
    monkeypatch.setattr(refiner, "_PATIENCE", 1)
    curve, report = thin_wall.refined()
    assert curve is not None, report.reason


def test_mimic_joints_follow_and_the_rest_is_held(pickup):
    group = pickup.group("arm::gripper")
    guess = np.linspace([0.025], [0.004], 14) + np.sin(np.linspace(0, np.pi, 14))[:, None] * 0.01
    margins, limits = pickup.margins(), pickup.limits(group)
    buffers = Buffers.between(pickup, margins, pickup.embed(group, guess[[0, -1]]))
    program = CurveProgram(pickup, group, limits, buffers, guess, jerk=False)
    program.keep_distance_at(np.linspace(0.1, 0.9, 9))
    found = program.solve(10.0)
    assert found.converged
    assert found.duration < program.guessed_duration
    # A straight line at full speed is the best there is.
    assert found.duration == pytest.approx(0.021 / limits.velocity[0], rel=0.02)
    points = program._kto.control_points()
    where = program._kto.prog().FindDecisionVariableIndices(points.ravel())
    full = program._x[where].reshape(points.shape).T
    np.testing.assert_allclose(full, pickup.embed(group, found.control_points), atol=1e-6)
