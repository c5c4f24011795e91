"""Where Drake's program begins, and what is delivered when it brings nothing."""

from dataclasses import replace

import numpy as np

from planning.domain.curves.curve import JointSpline, TimedTrajectory
from planning.domain.request.motion_limits import MotionLimits
from planning.domain.request.options import RefineOptions
from planning.domain.request.refine_objective import RefineObjective
from planning.refine.constraints.request_bounds import exact_rate_bounds
from planning.refine.drake.program import DrakeProgram
from planning.refine.motion.motion_cost import MotionCost
from planning.refine.motion.motion_program import OUT_OF_TIME, MotionTask
from planning.refine.motion.spline_motion import fit_motion
from planning.refine.refine_problem import RefineProblem
from planning.refine.refiner import refine
from planning.world.mechanics.dynamics import GroupDynamics
from tests.clocks import after_looks, no_hurry
from tests.profiles import only_campaign
from tests.refine.conftest import Case, whole_descent


def by_drake(case: Case, **options: object) -> Case:
    return replace(case, request=replace(case.request, options=RefineOptions("drake", **options)))


def test_the_curve_of_the_convex_steps_is_delivered_where_it_is_as_quick(thin_wall):
    """Around a thin wall these end at the lower bound of all durations."""
    curve, report = by_drake(thin_wall).outcome
    quickest, _ = thin_wall.outcome
    assert isinstance(curve, JointSpline)
    np.testing.assert_array_equal(curve.coefficients, quickest.coefficients)
    assert report.improved
    assert report.reason == "the program found no quicker motion than the convex steps"
    assert report.solver == "SNOPT"
    assert report.rounds >= 1


def test_jerk_limits_in_the_program_save_time_over_the_model_of_the_convex_steps(pillar_with_jerk):
    curve, report = by_drake(pillar_with_jerk).outcome
    _, other = pillar_with_jerk.outcome
    assert isinstance(curve, TimedTrajectory)
    assert curve.duration == report.duration_after
    assert curve.duration < 0.9 * other.duration_after


def test_a_solution_in_collision_between_its_instants_is_solved_again(thin_wall):
    objective = RefineObjective(smoothness=1.0, max_duration=4.0)
    curve, report = by_drake(thin_wall, objective=objective).outcome
    assert isinstance(curve, TimedTrajectory)
    assert report.rounds > 1
    assert thin_wall.are_free(curve.positions(np.linspace(0.0, 4.0, 5001))).all()


def test_a_deadline_during_the_program_leaves_what_there_is(thin_wall):
    objective = RefineObjective(smoothness=1.0, max_duration=4.0)
    case = by_drake(thin_wall, objective=objective)
    expired = []
    deadline = after_looks(60).with_on_expiry(lambda: expired.append(True))
    curve, report = refine(case.world, case.request, deadline)
    assert expired
    assert curve is not None or report.reason == OUT_OF_TIME


@only_campaign("5 s")
def test_torque_limits_are_kept_by_the_program(pillar):
    """The motor of the vertical axis, which carries no weight, is weak."""
    share = np.array([0.04, 1.0, 1.0, 1.0, 1.0, 1.0])
    limits = replace(pillar.request.limits, effort=share * pillar.request.limits.effort)
    bound = replace(
        pillar.request,
        limits=limits,
        motion_limits=MotionLimits(limits_effort=True),
        options=RefineOptions("drake"),
    )
    curve, report = replace(pillar, request=bound).refined()
    free, _ = by_drake(pillar).outcome
    assert isinstance(curve, TimedTrajectory), report.reason

    def peak(motion: TimedTrajectory) -> float:
        times = np.linspace(0.0, motion.duration, 301)
        dynamics = GroupDynamics(pillar.world, pillar.request.path.group)
        efforts = dynamics.efforts(
            motion.positions(times), motion.velocities(times), motion.accelerations(times)
        )
        return float((np.abs(efforts) / limits.effort).max())

    assert peak(free) > 1.2
    assert peak(curve) < 1.01
    assert curve.duration > free.duration


def test_a_solution_keeps_the_margins_at_its_instants(thin_wall):
    problem = RefineProblem.of(thin_wall.world, thin_wall.request, no_hurry())
    objective = RefineObjective(smoothness=1.0, max_duration=4.0)
    bounds, cost = exact_rate_bounds(thin_wall.request, ()), MotionCost(objective, None, 24)
    program = DrakeProgram(MotionTask(problem, bounds, cost, 2), thin_wall.world.drake.plant)
    best = whole_descent(problem).best
    assert best is not None
    guess = fit_motion(best.points, best.path_velocity, 24, 2)
    instants = np.linspace(0.05, 0.95, 150)
    solution = program.solve(guess, instants)
    motion = solution.motion
    assert solution.ending == ""
    rows = problem.distance_query.within(
        problem.chart.curve(motion.points).positions(instants), 0.1
    )
    assert -1e-5 < rows.signed_margins.min() < 1e-4
