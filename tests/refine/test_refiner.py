"""A refined curve is free, within limits, from start to goal, and quicker; or there is none."""

import pickle
import subprocess
import sys
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from planning.domain.curves.path import JointPath
from planning.domain.request.constraint import DistanceBand, PathConstraint, PathPredicate
from planning.domain.request.deadline import Deadline
from planning.domain.request.options import RefineOptions, RetimeOptions
from planning.domain.robot.manifold import Manifold
from planning.domain.value import digest
from planning.refine.descents.multi_start import solve_multi_start
from planning.refine.descents.trust_region import TrustRegion
from planning.refine.model.curve_model import CurveModel
from planning.refine.model.penalty_qp import solver_name
from planning.refine.refine_problem import RefineProblem
from planning.refine.refiner import refine
from planning.refine.request import RefineRequest
from planning.retime.blend import blend_corners
from planning.retime.retimer import retime
from planning.world.constraints.path_constraints import PathConstraints
from planning.world.loading.load_world import load_world
from planning.world.world import World
from tests.clocks import after_looks, no_hurry
from tests.refine.conftest import Case, case_of, whole_descent

FINE = np.linspace(0, 1, 400)

AGAIN = """
import pickle, sys
from planning.domain.value import digest
from planning.refine.refiner import refine
from planning.refine.request import RefineRequest
from planning.world.loading.load_world import load_world
from tests.clocks import no_hurry
scene, request = pickle.load(open(sys.argv[1], "rb"))
curve, report = refine(load_world(scene), request, no_hurry(60.0))
print(digest((curve, report)))
"""


def test_the_curve_is_free_and_within_limits(case):
    curve, report = case.outcome
    assert curve is not None, report.reason
    assert report.improved
    assert report.reason == ""
    assert report.solver == solver_name()
    assert case.are_free(curve.positions(FINE)).all()
    limits, s = case.request.limits, np.linspace(0, 1, 2001)
    assert (curve.positions(s) >= limits.lower - 1e-9).all()
    assert (curve.positions(s) <= limits.upper + 1e-9).all()


def test_the_estimated_duration_is_what_the_retimer_needs(case):
    curve, report = case.outcome
    timed, _ = retime(curve, case.request.limits, RetimeOptions("toppra"))
    assert report.lower_bound <= report.duration_after
    if case.request.limits_jerk:
        assert timed.duration < report.duration_after
    else:
        assert report.duration_after == pytest.approx(timed.duration, rel=0.02)


def test_the_motion_is_quicker_than_along_the_path(case):
    curve, _ = case.outcome
    options = RetimeOptions("ruckig" if case.request.limits_jerk else "toppra")
    rounded = blend_corners(case.request.path, 0.03, 2)
    limits = case.request.limits
    before, _ = retime(rounded, limits, options)
    after, _ = retime(curve, limits, options)
    assert after.duration < before.duration


def test_the_curve_joins_start_and_goal_and_is_quicker(case):
    curve, report = case.outcome
    assert curve is not None, report.reason
    waypoints = case.request.path.waypoints
    manifold = Manifold(case.request.path.group.joints)
    np.testing.assert_array_equal(curve.start, waypoints[0])
    assert manifold.distance(curve.end, waypoints[-1]) < 1e-12
    assert report.duration_after < report.duration_before
    assert report.length_after <= report.length_before
    assert report.length_before == case.request.path.length
    np.testing.assert_allclose(curve.breaks[[0, -1]], [0, 1], atol=0)


def test_the_curve_is_smooth_and_rests_nowhere(case):
    curve, _ = case.outcome
    joints = curve.breaks[1:-1]
    before = joints - 1e-12
    np.testing.assert_allclose(curve.positions(before), curve.positions(joints), atol=1e-9)
    for order in (1, 2):
        left, right = curve.tangents(before, order), curve.tangents(joints, order)
        np.testing.assert_allclose(left, right, atol=1e-8 * np.abs(right).max())
    speeds = np.linalg.norm(curve.tangents(np.linspace(0, 1, 501), 1), axis=1)
    assert speeds.min() > 1e-3 * speeds.max()


def test_an_angle_takes_the_short_way_across_the_half_turn(arm):
    curve, report = arm.outcome
    assert curve is not None, report.reason
    assert curve.end[0] == pytest.approx(np.pi + 0.6)
    assert np.abs(curve.positions(FINE)[:, 0] - np.pi).max() < 1.5


def test_a_wall_between_two_instants_is_found_and_avoided(thin_wall):
    curve, report = thin_wall.outcome
    assert curve is not None, report.reason
    assert report.rounds > 1
    assert thin_wall.are_free(curve.positions(np.linspace(0, 1, 5001))).all()


def problem_of(case: Case) -> RefineProblem:
    return RefineProblem.of(case.world, case.request, no_hurry())


def test_instants_that_the_audit_finds_are_added(make_puck):
    world = make_puck([([0.001, 1.3, 0.2], [0.0, -0.35, 0.0])])
    waypoints = [[-0.2, 0.1], [-0.1, 0.5], [0.1, 0.5], [0.2, 0.1]]
    case = case_of(world, "puck", waypoints)
    # Neither of the two first instants is near the wall.
    problem = replace(problem_of(case), sample_range=(2, 2))
    guess = problem.fit_path(0.15)
    descent = whole_descent(problem)
    best = descent.best
    assert best is not None, descent.reason
    assert case.are_free(problem.curve_of(best).positions(np.linspace(0, 1, 5001))).all()
    # The same steps without more instants.
    model = CurveModel(
        problem.distance_query, problem.chart_limits, problem.rate_bounds, len(guess), 2
    )
    unaudited = [
        evaluation
        for evaluation in TrustRegion(model, model.evaluate(guess)).run(25)
        if not problem.check_curve(evaluation)[0]
    ]
    assert best.duration < min(evaluation.duration for evaluation in unaudited) - 0.05


@pytest.mark.parametrize("kernel", [True, False])
def test_with_and_without_the_kernel_curves_are_as_quick(thin_wall, kernel):
    scene = thin_wall.world.scene
    world = load_world(scene, thin_wall.world.library, kernel=kernel)
    curve, report = replace(thin_wall, world=world).refined()
    assert curve is not None, report.reason
    assert report.duration_after == pytest.approx(report.lower_bound, rel=0.02)


def test_the_same_request_gives_the_same_bytes_in_another_process(pillar, tmp_path: Path):
    first = digest(pillar.outcome)
    assert digest(pillar.refined()) == first
    file = tmp_path / "case.pickle"
    file.write_bytes(pickle.dumps((pillar.world.scene, pillar.request)))
    again = subprocess.run(
        [sys.executable, "-c", AGAIN, str(file)], check=True, capture_output=True, text=True
    )
    assert again.stdout.strip().splitlines()[-1] == first


def test_method_none_refines_nothing(thin_wall):
    request = replace(thin_wall.request, options=RefineOptions("none"))
    curve, report = replace(thin_wall, request=request).refined()
    assert curve is None
    assert (report.method, report.improved, report.reason) == (
        "none",
        False,
        "refine.method is none",
    )


@pytest.mark.parametrize(("seconds", "refines"), [(0.4, False), (60.0, True)])
def test_the_automatic_method_wants_time(thin_wall, seconds: float, refines: bool):
    request = replace(thin_wall.request, options=RefineOptions("auto"))
    deadline = Deadline.after(seconds, lambda: 0.0)
    curve, report = refine(thin_wall.world, request, deadline)
    assert (curve is not None) == refines
    assert report.method == "auto"
    assert ("0.5 s" in report.reason) != refines


def test_a_path_that_does_not_move_is_left_alone(thin_wall):
    still = replace(thin_wall.request.path, waypoints=np.full((3, 2), 0.4))
    curve, report = replace(thin_wall, request=replace(thin_wall.request, path=still)).refined()
    assert curve is None
    assert report.reason == "the path has zero length"


def test_after_the_deadline_the_path_goes_on(thin_wall):
    curve, report = thin_wall.refined(seconds=0.0)
    assert curve is None
    assert report.reason == "the deadline passed before refinement began"


def test_a_deadline_between_rounds_ends_the_work(thin_wall):
    """This stage may use 0.35 of the remaining time, and every step reads the clock."""
    rounds = []
    for looks in (9, 12, 20):
        curve, report = refine(thin_wall.world, thin_wall.request, after_looks(looks))
        assert curve is not None, report.reason
        assert thin_wall.are_free(curve.positions(FINE)).all()
        assert report.rounds <= 0.35 * looks
        rounds.append(report.rounds)
    assert rounds[0] < rounds[1] < rounds[2]


def test_a_straight_path_is_left_alone(make_puck):
    world = make_puck([])
    path = JointPath(world.group("puck"), np.array([[-0.5, -0.5], [0.5, 0.5]]))
    request = RefineRequest(path, world.limits(path.group), world.margins(), RefineOptions())
    curve, report = refine(world, request, no_hurry(60))
    assert curve is None
    assert report.reason == "the straight path is already optimal"
    assert report.rounds == 0
    assert report.duration_before == pytest.approx(report.lower_bound, rel=2e-3)


@pytest.mark.parametrize(
    ("points", "reason"),
    [
        (np.linspace([-0.6, 0.1], [0.6, 0.1], 14), "violates a collision margin"),
        (np.array([[-0.6, 0.1], *[[0.0, 3.0]] * 12, [0.6, 0.1]]), "limits"),
    ],
)
def test_invalid_curves_are_rejected(thin_wall, points, reason: str):
    problem = problem_of(thin_wall)
    model = CurveModel(
        problem.distance_query, problem.chart_limits, problem.rate_bounds, len(points), 60
    )
    assert reason in problem.check_curve(model.evaluate(points))[0]
    assert problem.check_curve(model.evaluate(problem.fit_path(0.04)))[0] == ""


@pytest.mark.parametrize("scale", [1.0, 20.0])
def test_the_audit_looks_at_the_delivered_curve_densely(case, scale: float):
    problem = problem_of(case)
    points = problem.fit_path(0.04)
    points[3] += scale * 0.1
    samples, curve = problem.samples_of(points), problem.chart.curve(points)
    positions = samples.positions
    wanted = curve.positions(np.linspace(0.0, 1.0, len(positions)))
    np.testing.assert_allclose(positions, wanted, atol=1e-9)
    assert len(positions) > 400
    assert samples.length < 0.0101 * (len(positions) - 1)
    assert samples.length == pytest.approx(_length_of(wanted))


def _length_of(positions: np.ndarray) -> float:
    return float(np.linalg.norm(np.diff(positions, axis=0), axis=1).sum())


def test_a_robot_that_stands_near_a_wall_does_not_hinder_another(make_puck):
    wall = ([0.2, 0.2, 0.2], [0.0, 0.0, 0.0])
    # The idle puck stands on four slabs at once, a tenth of a millimetre above each.
    slabs = [([0.2, 0.2, 0.02], [3.0 + x, y, -0.0301]) for x in (-0.1, 0.1) for y in (-0.1, 0.1)]
    world = make_puck([wall, *slabs], idle=[3.0, 0.0, 0.0])
    waypoints = [[-0.6, 0.0], [-0.2, 0.4], [0.2, 0.4], [0.6, 0.0]]
    path = JointPath(world.group("puck"), np.array(waypoints))
    request = RefineRequest(path, world.limits(path.group), world.margins(), RefineOptions())
    curve, report = refine(world, request, no_hurry(60))
    assert curve is not None, report.reason
    oracle = world.collision_oracle(path.group, world.margins())
    assert oracle.are_free(curve.positions(FINE)).all()


class Misled(RefineProblem):
    """Problem whose first guess is a straight line through all obstacles."""

    def fit_path(self, tolerance: float) -> np.ndarray:
        return self.fit_waypoints(
            self.waypoints if tolerance < 0.1 else self.waypoints[[0, -1]], tolerance
        )


def test_a_nearer_guess_is_tried_where_the_first_leads_nowhere(thin_wall):
    problem = problem_of(thin_wall)
    misled = Misled(**{field.name: getattr(problem, field.name) for field in fields(problem)})
    nowhere = whole_descent(misled)
    assert nowhere.best is None
    assert "violates a collision margin" in nowhere.reason
    found = solve_multi_start(thin_wall.world, misled)
    assert found.best is not None, found.reason
    assert thin_wall.are_free(problem.curve_of(found.best).positions(FINE)).all()


def test_mimic_joints_follow(pickup):
    group = pickup.group("arm::gripper")
    path = JointPath(group, np.array([[0.025], [0.02], [0.004]]))
    request = RefineRequest(path, pickup.limits(group), pickup.margins(), RefineOptions())
    curve, report = refine(pickup, request, no_hurry(60))
    assert curve is not None, report.reason
    assert report.duration_after == pytest.approx(report.lower_bound, rel=2e-2)


# A block whose corner is at (0.6, 0), and a path that turns about it.
BLOCK = ([1.2, 1.0, 0.2], [0.0, -0.5, 0.0])
ABOUT = [[-0.5, 0.1], [0.3, 0.17], [0.62, 0.12], [0.72, 0.02], [0.75, -0.3], [0.72, -0.6]]


def constrained_case(world: World, *constraints: PathConstraint) -> Case:
    group = world.group("puck")
    ends = np.array(ABOUT)[[0, -1]]
    rules = PathConstraints.compiled(world, group, constraints, ends[0])
    return case_of(world, "puck", ABOUT, constraints=rules.tightened(ends[0], ends[1:]))


@pytest.mark.parametrize("kernel", [True, False])
def test_a_curve_under_a_band_keeps_it_and_is_quicker(make_puck, kernel):
    world = make_puck([BLOCK])
    world = load_world(world.scene, world.library, kernel=kernel)
    case = constrained_case(world, DistanceBand(None, None, 0.05, 0.16))
    curve, report = case.refined()
    assert curve is not None, report.reason
    assert report.duration_after < report.duration_before
    at = curve.positions(np.linspace(0, 1, 5001))
    away = np.linalg.norm(np.maximum(at - [0.6, 0.0], 0.0), axis=1) - 0.02
    assert 0.05 <= away.min() < 0.055
    assert away.max() <= 0.16
    rounded = blend_corners(case.request.path, 0.03, 1)
    limits, options = case.request.limits, RetimeOptions("toppra")
    before, after = (retime(one, limits, options)[0].duration for one in (rounded, curve))
    assert after < 0.95 * before


def test_without_its_band_a_curve_would_leave_it(make_puck):
    """Only the upper bound keeps the puck near the block: without it the corner is cut."""
    curve, _ = constrained_case(
        make_puck([BLOCK]), DistanceBand(None, None, 0.05, np.inf)
    ).refined()
    at = curve.positions(np.linspace(0, 1, 501))
    away = np.linalg.norm(np.maximum(at - [0.6, 0.0], 0.0), axis=1) - 0.02
    assert away.max() > 0.16


def test_a_predicate_that_accepts_changes_nothing(make_puck):
    world = make_puck([BLOCK])
    plain, _ = case_of(world, "puck", ABOUT).refined()
    curve, report = constrained_case(world, PathPredicate(lambda _: True, 0.01)).refined()
    assert report.improved
    np.testing.assert_array_equal(curve.coefficients, plain.coefficients)


def test_a_predicate_keeps_what_it_accepts(make_puck):
    """A lower ceiling than the quickest curve wants, which the path keeps."""
    curve, report = constrained_case(
        make_puck([BLOCK]), PathPredicate(lambda q: bool(q[0] < 0.78), 0.01)
    ).refined()
    assert curve is not None, report.reason
    assert (curve.positions(np.linspace(0, 1, 2001))[:, 0] < 0.78).all()


def test_a_predicate_that_rejects_is_soon_left_alone(make_puck):
    asked: list[np.ndarray] = []
    rule = PathPredicate(lambda q: bool(asked.append(q)), 0.01)
    case = constrained_case(make_puck([BLOCK]), rule)
    asked.clear()
    curve, report = case.refined()
    assert curve is None
    assert not report.improved
    assert "predicate" in report.reason
    # Every evaluation of a curve begins at its start; one evaluation per curve was enough.
    num_curves = sum(np.array_equal(q, ABOUT[0]) for q in asked)
    assert 1 <= num_curves <= 4
    assert len(asked) < 130 * num_curves
