"""refine_motion(): the motion in time that costs the least by any objective, by any solver.

The convex steps on the duration find a quick free curve first; its motion is where the program
begins, or else that along the path. Every solution is audited densely. Where the audit refuses it,
those instants are added and the program is solved again from there (constraint generation), a few
times at most.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from planning.domain.arrays import Array
from planning.domain.curves.curve import JointSpline
from planning.domain.report.stage_reports import RefineReport
from planning.domain.request.deadline import Deadline
from planning.domain.request.refine_objective import QUICKEST, RefineObjective
from planning.refine.constraints.request_bounds import exact_rate_bounds
from planning.refine.curve_checks import curve_length
from planning.refine.descents.multi_start import MultiStartResult, solve_multi_start
from planning.refine.model.load_evaluation import path_velocity_along
from planning.refine.motion.motion_cost import MotionCost
from planning.refine.motion.motion_program import OUT_OF_TIME, MotionProgram, MotionTask
from planning.refine.motion.spline_motion import (
    NUM_REST_POINTS,
    NUM_SMOOTH_REST_POINTS,
    SplineMotion,
    fit_motion,
    rate_time_scaling,
)
from planning.refine.refine_method import Refined
from planning.refine.refine_problem import RefineProblem
from planning.refine.request import RefineRequest
from planning.world.mechanics.dynamics import GroupDynamics
from planning.world.world import World

STATIC_LOAD_REASON = "the static torque exceeds an effort limit at the start or the goal"
# More control points make better motions and slower programs.
_NUM_CONTROL_POINTS = 24
# Spacing of the instants of the first program (joint-space length), and their number.
_SAMPLE_SPACING = 0.06
_MIN_SAMPLES, _MAX_SAMPLES = 40, 120
_MAX_PROGRAMS = 6
# Share of this stage's time for the convex steps.
_START_SHARE = 0.6
# Largest time scaling by which a solution is slowed to keep its rate bounds.
_MAX_TIME_SCALING = 1.02
# Shares of the way to a solution that are tried in turn.
_SHARES = (1.0, 0.5, 0.2)
# Relative difference up to which a duration counts as permitted.
_DURATION_TOLERANCE = 1e-6
# Factors by which the first motion is slowed where that may cost less.
_SLOWDOWNS = np.geomspace(1.0, 16.0, 25)
# Least relative decrease of the cost that counts.
_LEAST_GAIN = 1e-3


@dataclass(frozen=True)
class _Start:
    """Motion to begin with; `quickest` is the duration of a free curve, infinite for none."""

    problem: RefineProblem
    motion: SplineMotion
    quickest: float
    curve: JointSpline | None


def refine_motion(
    world: World,
    request: RefineRequest,
    deadline: Deadline,
    report: RefineReport,
    make_program: Callable[[MotionTask], MotionProgram],
) -> tuple[Refined, RefineReport]:
    """Return a motion in time, or the curve of the convex steps, or None; and the report.

    Args:
        world: The scene, loaded.
        request: Path, limits, margins and constraints.
        deadline: End of the refinement.
        report: Report to be completed; it has the solver's name.
        make_program: Returns the solver of a task.
    """
    first = RefineProblem.of(world, request, deadline.at_fraction(_START_SHARE))
    report = replace(report, lower_bound=first.lower_bound)
    if not first.is_static_load_feasible:
        return None, replace(report, reason=STATIC_LOAD_REASON)
    result = solve_multi_start(world, first)
    report = replace(report, duration_before=first.duration_of(result.first_guess))
    objective = (request.options.objective or QUICKEST).normalized
    num_rest_points = _num_rest_points(request, objective)
    start = _start(result, num_rest_points)
    problem = replace(start.problem, deadline=deadline)
    task = MotionTask(
        problem,
        exact_rate_bounds(request, problem.rate_bounds.loads),
        MotionCost(objective, _dynamics(world, request, objective), _NUM_CONTROL_POINTS),
        num_rest_points,
    )
    best, num_rounds, reason = _generate(make_program(task), _slowed(task.cost, start.motion))
    report = replace(report, rounds=num_rounds)
    if best is None or (not request.options.terms and _is_no_gain(objective, best, start)):
        reason = reason or "the program found no quicker motion than the convex steps"
        return _fall_back(start, replace(report, reason=reason))
    curve = problem.chart.curve(best.points)
    return best.trajectory(problem.chart), replace(
        report, improved=True, length_after=curve_length(curve), duration_after=best.duration
    )


def _num_rest_points(request: RefineRequest, objective: RefineObjective) -> int:
    """Return how many control points at either end rest there."""
    integrates_jerk = objective.smoothness > 0 and objective.derivative == "jerk"
    return NUM_SMOOTH_REST_POINTS if request.limits_jerk or integrates_jerk else NUM_REST_POINTS


def _dynamics(
    world: World, request: RefineRequest, objective: RefineObjective
) -> GroupDynamics | None:
    if not objective.energy:
        return None
    return GroupDynamics(world, request.path.group, request.motion_limits.payload)


def _start(result: MultiStartResult, num_rest_points: int) -> _Start:
    """Return the motion of the convex steps' curve, or that of their guess near the path."""
    problem, best = result.problem, result.best
    if best is not None:
        points, b, quickest = best.points, best.path_velocity, best.duration
        curve: JointSpline | None = problem.curve_of(best) if result.num_steps else None
    else:
        points, quickest, curve = result.first_guess, np.inf, None
        b, _ = path_velocity_along(points, problem.rate_bounds)
    motion = fit_motion(points, b, _NUM_CONTROL_POINTS, num_rest_points)
    return _Start(problem, motion, quickest, curve)


def _slowed(cost: MotionCost, motion: SplineMotion) -> SplineMotion:
    """Return the motion at the duration that costs the least."""
    longest = cost.objective.max_duration
    if not cost.objective.is_gentle:
        return motion
    durations = motion.duration * _SLOWDOWNS
    if longest is not None:
        durations = np.append(durations[durations < longest], longest)
    best = min(durations.tolist(), key=lambda duration: cost.value(motion.points, duration))
    return SplineMotion(motion.points, best)


def _generate(program: MotionProgram, anchor: SplineMotion) -> tuple[SplineMotion | None, int, str]:
    """Return the best motion that the audit accepts, or None; the rounds, and what ended.

    Where a solution is refused, the next program begins at the last motion that was not, or on the
    way from there to the solution: at a thin wall that a solution crossed, gradients point to
    either side.
    """
    task = program.task
    instants = _first_instants(task.problem)
    best: SplineMotion | None = None
    reason, num_rounds = "", 0
    for _ in range(_MAX_PROGRAMS):
        if task.problem.deadline.is_over:
            return best, num_rounds, OUT_OF_TIME
        solution = program.solve(anchor, instants)
        num_rounds += solution.rounds
        refusal, violations = _refusal(task, solution.motion)
        reason = refusal + (f" ({solution.ending})" if refusal and solution.ending else "")
        for share in _SHARES:
            accepted = _accepted(task, anchor.toward(solution.motion, share))
            if accepted is not None and _is_better(task.cost, accepted, best):
                best = anchor = accepted
                break
        if not len(violations):
            break
        instants = np.concatenate([instants, violations])
    return best, num_rounds, reason


def _first_instants(problem: RefineProblem) -> Array:
    """Return the instants of the first program, in (0, 1)."""
    length = float(np.linalg.norm(np.diff(problem.waypoints, axis=0), axis=1).sum())
    count = int(np.clip(length / _SAMPLE_SPACING, _MIN_SAMPLES, _MAX_SAMPLES))
    return np.linspace(0.0, 1.0, count + 2)[1:-1]


def _refusal(task: MotionTask, motion: SplineMotion) -> tuple[str, Array]:
    """Return why a motion is refused, or "", and the instants at which a margin is violated."""
    refusal, violations = task.problem.check_points(motion.points)
    if refusal:
        return refusal, violations
    longest = task.cost.objective.max_duration or np.inf
    time_scaling = max(1.0, rate_time_scaling(motion, task.bounds))
    if time_scaling > _MAX_TIME_SCALING:
        return "the solution exceeds a limit on a joint's rate", violations
    if motion.duration * time_scaling > longest * (1 + _DURATION_TOLERANCE):
        return f"no motion in {longest:g} s was found", violations
    return "", violations


def _accepted(task: MotionTask, motion: SplineMotion) -> SplineMotion | None:
    """Return a motion, slowed until it keeps its rate bounds, if it is not refused."""
    time_scaling = max(1.0, rate_time_scaling(motion, task.bounds))
    slower = SplineMotion(motion.points, motion.duration * time_scaling)
    return None if _refusal(task, slower)[0] else slower


def _is_better(cost: MotionCost, motion: SplineMotion, best: SplineMotion | None) -> bool:
    return best is None or (
        cost.value(motion.points, motion.duration) < cost.value(best.points, best.duration)
    )


def _is_no_gain(objective: RefineObjective, best: SplineMotion, start: _Start) -> bool:
    """Return whether the convex steps have found as quick a motion, where only that counts."""
    return objective.is_duration_alone and best.duration > start.quickest * (1 - _LEAST_GAIN)


def _fall_back(start: _Start, report: RefineReport) -> tuple[Refined, RefineReport]:
    """Return the curve of the convex steps, if they improved the path; the reason stays."""
    if start.curve is None:
        return None, report
    return start.curve, replace(
        report, improved=True, length_after=curve_length(start.curve), duration_after=start.quickest
    )
