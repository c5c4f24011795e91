"""Bounds on the duration of plans with an objective: of the objective, of the request, of terms."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import planning
from planning.domain.request.options import RefineOptions, RetimeOptions
from planning.domain.request.refine_objective import MAX_WEIGHT, RefineObjective
from planning.errors import ProblemInvalid, RetimingFailed, UnknownName
from planning.world.world import World
from tests.clocks import no_hurry
from tests.conftest import bundled_world
from tests.refine.conftest import puck_world

WALL = ([0.2, 0.6, 0.2], [0.0, -0.1, 0.0])
SMOOTH = RefineObjective(smoothness=1.0, max_duration=4.0)


@pytest.fixture
def puck(tmp_path: Path) -> World:
    return puck_world(tmp_path, [WALL])


@pytest.fixture(scope="module")
def arm() -> World:
    return bundled_world("ur5e_pickup")


def around(refine: RefineOptions, **changes: Any) -> planning.PlanningProblem:
    goal = planning.JointGoal(np.array([[0.6, -0.1]]))
    start = np.array([-0.6, -0.1])
    return planning.PlanningProblem("puck", goal, start=start, refine=refine, seed=1, **changes)


def plan(world: World, problem: planning.PlanningProblem) -> planning.MotionPlan:
    return planning.plan(problem, world, deadline=no_hurry(60.0))


def by_approach(objective: RefineObjective, duration: float | None) -> planning.PlanningProblem:
    """Return the problem of the guide's grasp: 10 cm of approach after the free motion."""
    exact, target = np.zeros(3), planning.PoseTarget(planning.Pose.identity(), frame="pick")
    goal = planning.PoseGoal((target,), "arm::tcp", exact, exact, np.array([0.0, 0.0, -0.1]))
    retiming = RetimeOptions(duration=duration)
    return planning.PlanningProblem(
        "arm", goal, refine=RefineOptions(objective=objective), retime=retiming, seed=1
    )


def integral_of_squared_accelerations(motion: planning.MotionPlan) -> float:
    free = motion.parts[0]
    times = np.linspace(free.begin, free.end, 20_001)
    rates = motion.trajectory.accelerations((times[1:] + times[:-1]) / 2)
    return float((rates**2).sum() * (times[1] - times[0]))


@pytest.mark.parametrize("method", ["trajopt", "drake"])
def test_a_requested_duration_is_used_by_the_objective(puck, method):
    """With both bounds the motion of 2.5 s is as gentle as with that bound alone."""
    options = RefineOptions(method, objective=SMOOTH)
    both = plan(puck, around(options, retime=RetimeOptions(duration=2.5)))
    assert both.trajectory.duration == pytest.approx(2.5, rel=1e-9)
    bounded = RefineOptions(method, objective=replace(SMOOTH, max_duration=2.5))
    alone = plan(puck, around(bounded))
    cost = both.stages.refine.after.smoothness
    assert cost == pytest.approx(alone.stages.refine.after.smoothness, rel=1e-2)
    assert both.stages.refine.improved


def test_a_requested_duration_beyond_the_bound_is_refused(puck):
    asked = around(RefineOptions(objective=SMOOTH), retime=RetimeOptions(duration=5.0))
    with pytest.raises(ProblemInvalid, match=r"retime\.duration is 5 s") as fault:
        plan(puck, asked)
    assert fault.value.evidence["field"] == "refine.objective"


def test_an_objective_leaves_time_for_the_approach(arm):
    """The free motion may take 3 s; the whole motion is to take 3 s, approach included."""
    motion = plan(arm, by_approach(replace(SMOOTH, max_duration=3.0), 3.0))
    assert motion.trajectory.duration == pytest.approx(3.0, rel=1e-6)
    assert motion.parts[0].end < 3.0


def test_the_report_is_of_what_is_delivered_with_the_approach(arm):
    motion = plan(arm, by_approach(RefineObjective(1.0, 0.05), 6.0))
    after = motion.stages.refine.after
    assert motion.trajectory.duration == pytest.approx(6.0, rel=1e-6)
    assert after.duration == pytest.approx(motion.parts[0].end, rel=1e-9)
    assert after.smoothness == pytest.approx(integral_of_squared_accelerations(motion), rel=1e-3)


def test_the_bound_holds_for_the_free_motion_that_is_delivered(arm):
    """6 s in all would make the free motion take 5 s."""
    with pytest.raises(RetimingFailed, match=r"refine\.objective\.max_duration of 3 s") as failure:
        plan(arm, by_approach(replace(SMOOTH, max_duration=3.0), 6.0))
    assert failure.value.evidence["max_duration"] == 3.0


def test_a_line_has_no_objective(arm):
    up = planning.LineGoal((planning.Displacement(np.array([0.0, 0.0, 0.05])),))
    asked = replace(by_approach(SMOOTH, None), goal=up)
    with pytest.raises(ProblemInvalid, match="lines are not optimized") as fault:
        plan(arm, asked)
    assert fault.value.evidence["field"] == "refine.objective"
    quickest = replace(asked, refine=RefineOptions(objective=RefineObjective(1.0)))
    assert plan(arm, quickest).certificate.proven


def test_a_term_may_bound_the_duration(puck):
    """By smoothness alone 4 s are better, but then the term is broken."""

    def take_two_seconds(trajopt: Any, _: Any) -> None:
        trajopt.AddDurationConstraint(1.9, 2.0)

    term = planning.DrakeTerm(take_two_seconds, "two seconds")
    motion = plan(puck, around(RefineOptions("drake", objective=SMOOTH, terms=(term,))))
    assert 1.9 - 1e-4 <= motion.trajectory.duration <= 2.0 + 1e-4
    assert motion.certificate.proven


def test_a_term_without_constraints_has_none_checked(puck):
    term = planning.DrakeTerm(lambda trajopt, _: trajopt.AddPathLengthCost(0.1), "short")
    motion = plan(puck, around(RefineOptions("drake", objective=SMOOTH, terms=(term,))))
    check = next(c for c in motion.certificate.checks if c.name == "drake term 0: short")
    assert check.where == "it has no constraints"


@pytest.mark.parametrize("weight", [1e-300, MAX_WEIGHT])
@pytest.mark.parametrize("method", ["trajopt", "drake"])
def test_only_the_proportions_of_weights_count(puck, method, weight):
    one, other = (
        plan(puck, around(RefineOptions(method, objective=replace(SMOOTH, smoothness=w))))
        for w in (1.0, weight)
    )
    expected = one.stages.refine.after.smoothness
    assert other.stages.refine.after.smoothness == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize(
    ("change", "field"),
    [({"smoothness": 1e300}, "smoothness"), ({"max_duration": 1e300}, "max_duration")],
)
def test_numbers_out_of_range_are_refused(puck, change, field):
    with pytest.raises(ProblemInvalid, match="at most") as fault:
        plan(puck, around(RefineOptions(objective=replace(SMOOTH, **change))))
    assert fault.value.evidence["field"] == f"refine.objective.{field}"


def test_an_unknown_derivative_is_refused(puck):
    unknown = replace(SMOOTH, derivative="snap")
    with pytest.raises(UnknownName, match="snap"):
        plan(puck, around(RefineOptions(objective=unknown)))


def test_the_objective_is_the_reason_of_a_long_duration(puck):
    """No limit keeps a gentle motion from being quicker, so none would save time."""
    asked = around(RefineOptions(objective=SMOOTH), retime=RetimeOptions(explain=True))
    explanation = plan(puck, asked).stages.retime.explanation
    assert [interval.limit for interval in explanation.intervals] == ["duration"]
    assert explanation.savings == ()
