"""What every refiner promises: ends, limits, margins, constraints, objective and deadline."""

from dataclasses import replace

import numpy as np
import pytest

from planning.domain.curves.curve import TimedTrajectory
from planning.domain.request.constraint import DistanceBand
from planning.domain.request.options import RefineOptions, RetimeOptions
from planning.domain.request.refine_objective import QUICKEST, RefineObjective
from planning.domain.robot.manifold import Manifold
from planning.domain.value import digest
from planning.refine.motion.motion_objectives import MotionObjectives
from planning.refine.refine_method import Refiner
from planning.refine.refiner import REFINERS, refine
from planning.retime.blend import blend_corners
from planning.retime.retimer import keep_timing, retime
from planning.world.constraints.path_constraints import PathConstraints
from tests.clocks import after_looks
from tests.profiles import only_campaign
from tests.refine.conftest import Case, case_of

FINE = np.linspace(0.0, 1.0, 1001)
# Methods with each objective that they know.
WAYS = {
    "trajopt": RefineOptions("trajopt"),
    "trajopt, smooth": RefineOptions(
        "trajopt", objective=RefineObjective(smoothness=1.0, max_duration=4.0)
    ),
    "trajopt, sum": RefineOptions(
        "trajopt", objective=RefineObjective(1.0, 0.05, path_length=1.0, max_duration=4.0)
    ),
    "trajopt, jerk": RefineOptions(
        "trajopt", objective=RefineObjective(1.0, 0.001, derivative="jerk")
    ),
    "trajopt, short": RefineOptions("trajopt", objective=RefineObjective(path_length=1.0)),
    "drake": RefineOptions("drake"),
    "drake, smooth": RefineOptions(
        "drake", objective=RefineObjective(smoothness=1.0, max_duration=4.0)
    ),
    "drake, short": RefineOptions("drake", objective=RefineObjective(path_length=1.0)),
}
# A block whose corner is at (0.6, 0), and a path that turns about it.
BLOCK = ([1.2, 1.0, 0.2], [0.0, -0.5, 0.0])
ABOUT = [[-0.5, 0.1], [0.3, 0.17], [0.62, 0.12], [0.72, 0.02], [0.75, -0.3], [0.72, -0.6]]


@pytest.fixture(scope="module", params=WAYS, ids=str)
def options(request: pytest.FixtureRequest) -> RefineOptions:
    return WAYS[request.param]


@pytest.fixture(scope="module", params=["thin_wall", "arm", "pillar_with_jerk"])
def way(request: pytest.FixtureRequest, options: RefineOptions) -> Case:
    case = request.getfixturevalue(request.param)
    return replace(case, request=replace(case.request, options=options))


def timed(case: Case, curve: object) -> TimedTrajectory:
    """Return what the pipeline would deliver of a curve."""
    retiming = RetimeOptions("ruckig" if case.request.limits_jerk else "toppra")
    if isinstance(curve, TimedTrajectory):
        kept = keep_timing(curve, case.request.limits, retiming)
        assert kept is not None
        return kept[0]
    return retime(curve, case.request.limits, retiming)[0]


def cost(case: Case, trajectory: TimedTrajectory) -> float:
    objective = case.request.options.objective
    measured = MotionObjectives.of(case.world, case.request.path.group, trajectory, objective, None)
    return measured.cost(measured.best_slowdown)


def test_every_method_is_a_refiner():
    assert set(REFINERS) == {"auto", "drake", "trajopt"}
    assert all(isinstance(refiner, Refiner) for refiner in REFINERS.values())


def test_the_curve_keeps_its_ends_its_limits_and_the_margins(way):
    curve, report = way.outcome
    assert curve is not None, report.reason
    assert report.improved
    waypoints, joints = way.request.path.waypoints, way.request.path.group.joints
    np.testing.assert_array_equal(curve.start, waypoints[0])
    assert Manifold(joints).distance(curve.end, waypoints[-1]) < 1e-12
    at = curve.positions(FINE * curve.breaks[-1])
    assert way.are_free(at).all()
    assert (at >= way.request.limits.lower - 1e-9).all()
    assert (at <= way.request.limits.upper + 1e-9).all()


def test_a_motion_with_its_own_time_keeps_limits_on_rates(way):
    curve, _ = way.outcome
    if not isinstance(curve, TimedTrajectory):
        pytest.skip("the retimer times it")
    times, limits = FINE * curve.duration, way.request.limits
    bounds = [limits.velocity, limits.acceleration, limits.jerk]
    for order, bound in enumerate(bounds[: 3 if way.request.limits_jerk else 2], start=1):
        assert (np.abs(curve.tangents(times, order)) <= bound * (1 + 1e-4)).all(), order
    rest = [1, 2] if way.request.limits_jerk else [1]
    for order in rest:
        ends = curve.tangents(np.array([0.0, curve.duration]), order)
        np.testing.assert_allclose(ends, 0.0, atol=1e-6)


def test_no_motion_is_worse_than_along_the_path_by_its_own_objective(way):
    curve, _ = way.outcome
    smoothness = 2 if way.request.limits_jerk else 1
    before = timed(way, blend_corners(way.request.path, 0.03, smoothness))
    assert cost(way, timed(way, curve)) < cost(way, before)
    longest = (way.request.options.objective or QUICKEST).max_duration
    assert timed(way, curve).duration <= (longest or np.inf) * (1 + 1e-6)


@only_campaign("10 s for all")
def test_the_same_request_gives_the_same_bytes(way):
    assert digest(way.refined()) == digest(way.outcome)


def test_path_constraints_are_kept(make_puck, options):
    world = make_puck([BLOCK])
    group, ends = world.group("puck"), np.array(ABOUT)[[0, -1]]
    rules = PathConstraints.compiled(world, group, (DistanceBand(None, None, 0.05, 0.16),), ends[0])
    constraints = rules.tightened(ends[0], ends[1:])
    curve, report = case_of(
        world, "puck", ABOUT, constraints=constraints, options=options
    ).refined()
    assert curve is not None, report.reason
    at = curve.positions(FINE * curve.breaks[-1])
    away = np.linalg.norm(np.maximum(at - [0.6, 0.0], 0.0), axis=1) - 0.02
    assert away.min() >= 0.05
    assert away.max() <= 0.16


def test_after_the_deadline_nothing_begins(thin_wall, options):
    request = replace(thin_wall.request, options=options)
    curve, report = replace(thin_wall, request=request).refined(seconds=0.0)
    assert curve is None
    assert report.reason == "the deadline passed before refinement began"


@pytest.mark.parametrize("looks", [20, 60, 120])
def test_a_deadline_in_the_middle_leaves_a_free_curve_or_none(thin_wall, options, looks):
    request = replace(thin_wall.request, options=options)
    curve, report = refine(thin_wall.world, request, after_looks(looks))
    if curve is None:
        assert report.reason
        return
    assert thin_wall.are_free(curve.positions(FINE * curve.breaks[-1])).all()
