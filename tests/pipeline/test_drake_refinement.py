"""Plans that Drake refines: objectives, bounds on duration, and terms of the library's user."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydrake.multibody.inverse_kinematics import PositionConstraint

import planning
from planning.domain.request.options import ClearanceObjective, RefineOptions, RetimeOptions
from planning.domain.request.refine_objective import RefineObjective
from planning.errors import NotCertified, ProblemInvalid, RetimingFailed
from planning.world.world import World
from tests.clocks import no_hurry
from tests.conftest import bundled_world
from tests.profiles import only_campaign
from tests.refine.conftest import puck_world

WALL = ([0.2, 0.6, 0.2], [0.0, -0.1, 0.0])
SMOOTH = RefineObjective(smoothness=1.0, max_duration=4.0)


@pytest.fixture
def puck(tmp_path: Path) -> World:
    return puck_world(tmp_path, [WALL])


def problem(refine: RefineOptions, **changes: Any) -> planning.PlanningProblem:
    goal = planning.JointGoal(np.array([[0.6, -0.1]]))
    return planning.PlanningProblem(
        "puck", goal, start=np.array([-0.6, -0.1]), refine=refine, seed=1, **changes
    )


def plan(world: World, refine: RefineOptions, **changes: Any) -> planning.MotionPlan:
    return planning.plan(problem(refine, **changes), world, deadline=no_hurry(60.0))


def test_a_gentle_motion_takes_the_time_that_it_may_and_no_more(puck):
    motion = plan(puck, RefineOptions("drake", objective=SMOOTH))
    assert motion.certificate.proven
    assert motion.trajectory.duration == pytest.approx(4.0, rel=1e-6)
    report = motion.stages.refine
    assert report.improved
    assert report.after.smoothness < 0.2 * report.before.smoothness
    assert report.before.duration < report.after.duration
    # It has its own time: one cubic for each span of the spline.
    assert motion.trajectory.num_pieces == 21
    assert motion.stages.retime.slowed == pytest.approx(1.0, abs=1e-6)


def test_under_jerk_limits_drakes_duration_is_delivered_as_it_is(puck):
    quick = plan(puck, RefineOptions("trajopt"), retime=RetimeOptions("ruckig"))
    motion = plan(puck, RefineOptions("drake"), retime=RetimeOptions("ruckig"))
    assert motion.certificate.proven
    assert motion.trajectory.num_pieces == 21
    assert motion.trajectory.duration < quick.trajectory.duration
    assert motion.trajectory.duration == pytest.approx(
        motion.stages.refine.duration_after, rel=1e-3
    )


def test_a_path_that_drake_does_not_improve_is_slowed_to_its_best_duration(puck):
    """After the deadline of refinement the path itself is as gentle as its shape permits."""
    straight = replace(
        problem(RefineOptions("drake", objective=SMOOTH)), start=np.array([0.6, 0.5])
    )
    motion = planning.plan(straight, puck, deadline=no_hurry(60.0))
    assert motion.trajectory.duration == pytest.approx(4.0, rel=1e-6)
    assert motion.stages.refine.after.smoothness == pytest.approx(12 * 0.6**2 / 4.0**3, rel=1e-2)


def test_less_time_than_the_limits_allow_is_a_failure_with_the_least_duration(puck):
    hasty = RefineOptions("drake", objective=replace(SMOOTH, max_duration=0.5))
    with pytest.raises(RetimingFailed, match=r"max_duration of 0\.5 s") as failure:
        plan(puck, hasty)
    assert failure.value.evidence["least"] > 1.2


def test_a_requested_duration_is_kept(puck):
    motion = plan(
        puck,
        RefineOptions("drake", objective=RefineObjective(path_length=1.0)),
        retime=RetimeOptions(duration=5.0),
    )
    assert motion.trajectory.duration == pytest.approx(5.0)
    assert motion.certificate.proven


@only_campaign("energy by difference quotients: 14 s")
def test_an_arm_with_effort_limits_and_payload_saves_energy():
    world = bundled_world("ur5e_pickup")
    carried = planning.Payload.from_parts("arm::tcp", 1.0, (0.0, 0.0, 0.05))
    asked = planning.PlanningProblem(
        "arm",
        planning.ConfigurationGoal("stowed"),
        refine=RefineOptions("drake", objective=RefineObjective(energy=1.0, max_duration=2.5)),
        retime=RetimeOptions(effort=True, payload=carried),
        seed=3,
    )
    motion = planning.plan(asked, world, deadline=no_hurry(60.0))
    assert motion.certificate.proven
    report = motion.stages.refine
    assert report.after.energy < 0.9 * report.before.energy
    assert motion.trajectory.duration <= 2.5 * (1 + 1e-9)


def keep_high(trajopt: Any, plant: Any) -> None:
    """The puck is at y >= 0.6 in the middle, by Drake's own kinematics."""
    frame, world = plant.GetFrameByName("puck"), plant.world_frame()
    low, high = [-10.0, 0.6, -10.0], [10.0, 10.0, 10.0]
    context = plant.CreateDefaultContext()
    for s in (0.45, 0.5, 0.55):
        constraint = PositionConstraint(plant, world, low, high, frame, [0, 0, 0], context)
        trajopt.AddPathPositionConstraint(constraint, s)


def above(height: float):
    def add(trajopt: Any, _: Any) -> None:
        low, high = np.array([-np.inf, height]), np.array([np.inf, np.inf])
        for s in (0.45, 0.5, 0.55):
            trajopt.AddPathPositionConstraint(low, high, s)

    return add


@pytest.mark.parametrize("add", [above(0.6), keep_high], ids=["rows", "kinematics"])
def test_a_term_is_kept_and_the_certificate_says_that_it_is_sampled(puck, add):
    term = planning.DrakeTerm(add, "high in the middle")
    motion = plan(puck, RefineOptions("drake", terms=(term,)))
    curve = motion.trajectory
    s = np.array([0.45, 0.5, 0.55])
    assert (curve.positions(curve.duration * s)[:, 1] >= 0.6 - 1e-5).all()
    check = motion.certificate.checks[-2]
    assert check.name == "drake term 0: high in the middle"
    assert check.passed
    assert check.resolution == np.inf
    assert "sampled" in check.where
    plain = plan(puck, RefineOptions("drake")).trajectory
    assert (plain.positions(plain.duration * s)[:, 1] < 0.6).any()


def test_a_motion_that_breaks_a_term_is_not_certified(puck):
    term = planning.DrakeTerm(above(5.0), "far away")
    with pytest.raises(NotCertified, match="drake term 0: far away"):
        plan(puck, RefineOptions("drake", terms=(term,)))


@pytest.mark.parametrize(
    ("options", "field", "message"),
    [
        (RefineOptions("none", objective=RefineObjective(1.0)), "objective", "optimizes nothing"),
        (RefineOptions("drake", objective=RefineObjective()), "objective", "must be positive"),
        (
            RefineOptions("drake", objective=RefineObjective(energy=1.0)),
            "objective",
            "give max_duration",
        ),
        (
            RefineOptions("drake", objective=RefineObjective(-1.0)),
            "objective.duration",
            "not negative",
        ),
        (
            RefineOptions("drake", objective=replace(SMOOTH, max_duration=0.0)),
            "objective.max_duration",
            "positive",
        ),
        (
            RefineOptions("drake", ClearanceObjective(0.1, 1.0)),
            "clearance",
            "weighs no clearance",
        ),
        (
            RefineOptions("trajopt", ClearanceObjective(0.1, 1.0), RefineObjective(1.0)),
            "objective",
            "leave one",
        ),
        (
            RefineOptions("trajopt", terms=(planning.DrakeTerm(print),)),
            "terms",
            "require method 'drake'",
        ),
    ],
)
def test_what_a_method_cannot_do_is_refused_with_the_reason(puck, options, field, message):
    with pytest.raises(ProblemInvalid, match=message) as fault:
        plan(puck, options)
    assert fault.value.evidence["field"] == f"refine.{field}"


def test_a_car_is_refused_by_name():
    car = bundled_world("parallel_parking")
    group = next(iter(car.scene.robots)).name
    asked = planning.PlanningProblem(
        group,
        planning.JointGoal(car.positions(car.group(group))[None]),
        refine=RefineOptions("drake"),
    )
    with pytest.raises(ProblemInvalid, match="steering") as fault:
        planning.plan(asked, car, deadline=no_hurry(60.0))
    assert fault.value.evidence["field"] == "refine.method"
