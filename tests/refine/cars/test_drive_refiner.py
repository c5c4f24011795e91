"""Refined drives: quicker, drivable, free, and from the same start to the same goal."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

import planning
from benchmarks.car_problems.yards import CarProblem, parking, yard
from planning.domain.curves.curve import JointSpline
from planning.domain.curves.path import JointPath
from planning.domain.request.constraint import PathPredicate, TightLimits
from planning.domain.request.options import ClearanceObjective, RefineOptions, RetimeOptions
from planning.domain.robot.steering import manifold_of, steering_of
from planning.refine.cars.drive_model import DriveModel
from planning.refine.cars.drive_solver import DriveSolver
from planning.refine.cars.drive_trust_region import DriveTrustRegion
from planning.refine.cars.segment_times import SegmentTimes
from planning.refine.constraints.clearance_objective import make_clearance_objective
from planning.refine.constraints.distance_query import DistanceRows
from planning.refine.refiner import refine
from planning.refine.request import RefineRequest
from planning.retime.retimer import retime
from planning.world.constraints.path_constraints import PathConstraints
from planning.world.world import World
from tests.clocks import after_looks, no_hurry
from tests.drivers import assert_driven

CASES = {
    "parked": lambda: parking("parked", reverse=True),
    "passed": lambda: parking("passed", reverse=False),
    "yard": lambda: yard(4, reverse=True),
    "one way": lambda: yard(10, reverse=False),
}


class Drive:
    """A world and the path that the search finds in it."""

    def __init__(self, problem: CarProblem) -> None:
        self.world: World = problem.world
        unrefined = problem.problem(0, refine=RefineOptions("none"))
        soon = no_hurry(30.0)
        self.path: JointPath = planning.plan(unrefined, self.world, deadline=soon).path
        self.limits = self.world.limits(self.path.group)

    def request(self, **fields: object) -> RefineRequest:
        request = RefineRequest(self.path, self.limits, self.world.margins(), RefineOptions())
        return replace(request, **fields)

    def refined(self, seconds: float = 60.0, **fields: object):
        deadline = no_hurry(seconds)
        return refine(self.world, self.request(**fields), deadline)

    def duration(self, curve: JointSpline, method: str = "toppra") -> float:
        return retime(curve, self.limits, RetimeOptions(method=method))[0].duration

    def are_free(self, curve: JointSpline) -> np.ndarray:
        qs = curve.positions(np.linspace(0.0, 1.0, 3001))
        return self.world.collision_oracle(self.path.group, self.world.margins()).are_free(qs)


@pytest.fixture(scope="module")
def drive_of() -> Callable[[str], Drive]:
    made: dict[str, Drive] = {}

    def drive(name: str) -> Drive:
        if name not in made:
            made[name] = Drive(CASES[name]())
        return made[name]

    return drive


@pytest.mark.parametrize("name", CASES)
def test_drives_become_quicker_and_stay_drives(drive_of: Callable[[str], Drive], name: str) -> None:
    drive = drive_of(name)
    curve, report = drive.refined()
    assert report.improved
    assert curve is not None
    timed, _ = retime(curve, drive.limits, RetimeOptions())
    steering = steering_of(drive.path.group)["car::base_joint"]
    assert_driven(timed, steering.turning_radius, reverse=steering.reverse)
    assert drive.are_free(curve).all()
    assert curve.start.tobytes() == drive.path.waypoints[0].tobytes()
    assert curve.end == pytest.approx(drive.path.waypoints[-1], abs=1e-9)
    before = drive.duration(drive.path.spline)
    assert timed.duration < 0.97 * before
    assert report.lower_bound <= timed.duration
    assert report.duration_before == pytest.approx(before, rel=0.02)
    assert report.duration_after == pytest.approx(timed.duration, rel=0.02)
    assert report.length_after == pytest.approx(_length(drive, curve), rel=1e-3)


def _length(drive: Drive, curve: JointSpline) -> float:
    qs = curve.positions(np.linspace(0, 1, 2001))
    return float(manifold_of(drive.path.group).distance(qs[1:], qs[:-1]).sum())


def test_a_drive_with_bounded_jerk(drive_of: Callable[[str], Drive]) -> None:
    drive = drive_of("parked")
    curve, report = drive.refined(limits_jerk=True)
    assert curve is not None
    before, after = (drive.duration(c, "ruckig") for c in (drive.path.spline, curve))
    assert after < 0.9 * before
    assert report.duration_after == pytest.approx(after, rel=0.15)


def test_the_same_request_gives_the_same_bytes(drive_of: Callable[[str], Drive]) -> None:
    drive = drive_of("yard")
    (one, first), (two, second) = drive.refined(), drive.refined(120.0)
    assert one == two
    assert first == second


def test_the_deadline_is_kept_and_the_best_so_far_is_given(
    drive_of: Callable[[str], Drive],
) -> None:
    """By a deadline that passes after a number of reads of the clock."""
    drive = drive_of("parked")
    taken: list[int] = []
    for patience, is_quicker in ((3, False), (40, False), (100, True)):
        deadline = after_looks(round(patience / 0.35))
        curve, report = refine(drive.world, drive.request(), deadline)
        assert (curve is not None) is report.improved is is_quicker
        if curve is not None:
            assert drive.are_free(curve).all()
            assert drive.duration(curve) < drive.duration(drive.path.spline)
        # Every step reads the clock.
        assert report.rounds <= patience
        taken.append(report.rounds)
    assert taken == sorted(taken)
    assert taken[0] <= 3 < taken[2]
    curve, report = drive.refined(0.0)
    assert curve is None
    assert report.reason == "the deadline passed before refinement began"


class NoObstacles:
    """Distance query without any pair."""

    def within(self, qs: np.ndarray, influence_distance: float) -> DistanceRows:
        return DistanceRows(np.zeros(0, dtype=np.intp), np.zeros(0), np.zeros((0, 3)))


def test_colliding_paths_are_rejected(drive_of: Callable[[str], Drive]) -> None:
    """A model without obstacles finds paths through them; the audit rejects all of them."""
    drive = drive_of("parked")
    deadline, jerk = no_hurry(), drive.request().limits_jerk
    solver = DriveSolver.of(drive.world, drive.request(), deadline)
    times = SegmentTimes.of(solver.limits, solver.problem.car_index, limits_jerk=jerk)
    model = DriveModel(solver.problem, NoObstacles(), solver.limits, times, None)
    found = replace(solver, model=model, trust_region=DriveTrustRegion(model, deadline)).run()
    assert found.path is None
    assert "violates a collision margin" in found.reason


def test_position_limits_are_kept(drive_of: Callable[[str], Drive]) -> None:
    """The limits leave only the range of the given path, in which the faster one must stay."""
    drive = drive_of("yard")
    free, _ = drive.refined()
    assert free is not None
    qs = drive.path.spline.positions(np.linspace(0, 1, 2001))
    box = {
        f"car::base_joint.{axis}": (float(qs[:, i].min()) - 1e-3, float(qs[:, i].max()) + 1e-3)
        for i, axis in enumerate("xy")
    }
    rules = PathConstraints.compiled(drive.world, drive.path.group, (TightLimits(box),), qs[0])
    curve, report = drive.refined(constraints=rules)
    assert curve is not None, report.reason
    moved = curve.positions(np.linspace(0, 1, 2001))
    for i, axis in enumerate("xy"):
        low, high = box[f"car::base_joint.{axis}"]
        assert low - 1e-6 < moved[:, i].min()
        assert moved[:, i].max() < high + 1e-6


def test_predicates_reject_a_path(drive_of: Callable[[str], Drive]) -> None:
    drive = drive_of("passed")
    positions = drive.path.spline.positions(np.linspace(0, 1, 4001))

    def is_on_the_path(q: np.ndarray) -> bool:
        return bool(np.linalg.norm(positions - q, axis=1).min() < 2e-3)

    constraint = PathPredicate(is_on_the_path, 0.05, "there")
    rules = PathConstraints.compiled(drive.world, drive.path.group, (constraint,), positions[0])
    curve, report = drive.refined(constraints=rules)
    assert curve is None
    assert "predicate" in report.reason


def test_the_clearance_objective_is_weighed(drive_of: Callable[[str], Drive]) -> None:
    drive = drive_of("yard")
    objective = ClearanceObjective(0.15, 40.0)
    group, margins = drive.path.group, drive.world.margins()
    clearance_cost = make_clearance_objective(drive.world, group, margins, objective)
    assert clearance_cost is not None
    quick, _ = drive.refined()
    wide, _ = drive.refined(options=RefineOptions(clearance=objective))
    assert quick is not None
    assert wide is not None
    times = [retime(c, drive.limits, RetimeOptions())[0] for c in (quick, wide)]
    assert clearance_cost.mean_shortfall(times[1]) < clearance_cost.mean_shortfall(times[0])
    assert times[1].duration >= times[0].duration


def test_none_and_auto(drive_of: Callable[[str], Drive]) -> None:
    drive = drive_of("passed")
    curve, report = drive.refined(options=RefineOptions("none"))
    assert curve is None
    assert report.reason == "refine.method is none"
    curve, report = drive.refined(0.3, options=RefineOptions("auto"))
    assert curve is None
    assert "less than" in report.reason
    curve, _ = drive.refined(options=RefineOptions("auto"))
    assert curve is not None


def test_groups_of_several_cars_are_not_refined(drive_of: Callable[[str], Drive]) -> None:
    drive = drive_of("passed")
    group = drive.path.group
    joint = group.joints[0]
    twin = replace(joint, name="twin")
    steering = steering_of(group)[joint.name]
    both = replace(group, joints=(joint, twin), steering={joint.name: steering, "twin": steering})
    twice = np.concatenate([drive.path.waypoints, drive.path.waypoints], axis=1)
    curve, report = drive.refined(path=JointPath(both, twice))
    assert curve is None
    assert "several cars" in report.reason
