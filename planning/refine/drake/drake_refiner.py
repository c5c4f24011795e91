"""DrakeRefiner: the refiner by Drake's `KinematicTrajectoryOptimization`.

The convex steps find a quick free curve first; its motion is where the program begins, or else that
along the path. Every solution is audited densely. Where the audit refuses it, those instants are
added and the program is solved again from there (constraint generation), a few times at most.
"""

from dataclasses import dataclass, replace

import numpy as np

from planning.domain.arrays import Array
from planning.domain.curves.curve import JointSpline
from planning.domain.report.stage_reports import RefineReport
from planning.domain.request.deadline import Deadline
from planning.domain.request.refine_objective import QUICKEST, RefineObjective
from planning.domain.robot.steering import steering_of
from planning.refine.constraints.request_bounds import exact_rate_bounds
from planning.refine.convex_steps import STATIC_LOAD_REASON
from planning.refine.curve_checks import curve_length
from planning.refine.drake.motion_cost import MotionCost
from planning.refine.drake.program import OUT_OF_TIME, SOLVER_NAME, DrakeProgram
from planning.refine.drake.spline_motion import (
    NUM_REST_POINTS,
    NUM_SMOOTH_REST_POINTS,
    SplineMotion,
    fit_motion,
    rate_time_scaling,
)
from planning.refine.model.load_evaluation import path_velocity_along
from planning.refine.multi_start import MultiStartResult, solve_multi_start
from planning.refine.refine_method import Refined
from planning.refine.refine_problem import RefineProblem
from planning.refine.request import RefineRequest
from planning.world.mechanics.dynamics import GroupDynamics
from planning.world.world import World

# More control points make better motions and slower programs.
_NUM_CONTROL_POINTS = 24
# Spacing of the instants of the first program (joint-space length), and their number.
_SAMPLE_SPACING = 0.06
_MIN_SAMPLES, _MAX_SAMPLES = 40, 120
_MAX_PROGRAMS = 6
# Share of this stage's time for the convex steps.
_START_SHARE = 0.4
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


@dataclass(frozen=True)
class DrakeRefiner:
    """Refiner by Drake's kinematic trajectory optimization. It minimizes any objective."""

    def unsupported_reason(self, request: RefineRequest) -> str:
        """Return why a path cannot be refined, or ""."""
        if steering_of(request.path.group):
            return "method drake: its splines do not keep the steering of a car"
        return ""

    def refine(
        self, world: World, request: RefineRequest, deadline: Deadline, report: RefineReport
    ) -> tuple[Refined, RefineReport]:
        """Return a motion in time, or the curve of the convex steps, or None; and the report."""
        first = RefineProblem.of(world, request, deadline.at_fraction(_START_SHARE))
        report = replace(report, solver=SOLVER_NAME, lower_bound=first.lower_bound)
        if not first.is_static_load_feasible:
            return None, replace(report, reason=STATIC_LOAD_REASON)
        result = solve_multi_start(world, first)
        report = replace(report, duration_before=first.duration_of(result.first_guess))
        objective = request.options.objective or QUICKEST
        num_rest_points = _num_rest_points(request, objective)
        start = _start(result, num_rest_points)
        problem = replace(start.problem, deadline=deadline)
        program = DrakeProgram(
            problem,
            exact_rate_bounds(request, problem.rate_bounds.loads),
            MotionCost(objective, _dynamics(world, request, objective), _NUM_CONTROL_POINTS),
            num_rest_points,
            world.drake.plant,
            request.options.terms,
        )
        best, num_programs, reason = _generate(program, _slowed(program.cost, start.motion))
        report = replace(report, rounds=num_programs)
        if best is None or (not program.terms and _is_no_gain(objective, best, start)):
            reason = reason or "the program found no quicker motion than the convex steps"
            return _fall_back(start, replace(report, reason=reason))
        curve = problem.chart.curve(best.points)
        return best.trajectory(problem.chart), replace(
            report, improved=True, length_after=curve_length(curve), duration_after=best.duration
        )


def _num_rest_points(request: RefineRequest, objective: RefineObjective) -> int:
    """Return how many control points at either end rest there."""
    integrates_jerk = objective.smoothness > 0 and objective.derivative == "jerk"
    return NUM_SMOOTH_REST_POINTS if request.jerk or integrates_jerk else NUM_REST_POINTS


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
        _, b, _ = path_velocity_along(points, problem.rate_bounds)
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


def _generate(program: DrakeProgram, anchor: SplineMotion) -> tuple[SplineMotion | None, int, str]:
    """Return the best motion that the audit accepts, or None; the programs solved, and what ended.

    Where a solution is refused, the next program begins at the last motion that was not, or on the
    way from there to the solution: at a thin wall that a solution crossed, gradients point to
    either side.
    """
    problem = program.problem
    instants = _first_instants(problem)
    best: SplineMotion | None = None
    reason = ""
    for i in range(_MAX_PROGRAMS):
        if problem.deadline.is_over:
            return best, i, OUT_OF_TIME
        solution, ending = program.solve(anchor, instants)
        refusal, violations = _refusal(program, solution)
        reason = refusal + (f" ({ending})" if refusal and ending else "")
        for share in _SHARES:
            accepted = _accepted(program, anchor.toward(solution, share))
            if accepted is not None and _is_better(program.cost, accepted, best):
                best = anchor = accepted
                break
        if not len(violations):
            return best, i + 1, reason
        instants = np.concatenate([instants, violations])
    return best, _MAX_PROGRAMS, reason


def _first_instants(problem: RefineProblem) -> Array:
    """Return the instants of the first program, in (0, 1)."""
    length = float(np.linalg.norm(np.diff(problem.waypoints, axis=0), axis=1).sum())
    count = int(np.clip(length / _SAMPLE_SPACING, _MIN_SAMPLES, _MAX_SAMPLES))
    return np.linspace(0.0, 1.0, count + 2)[1:-1]


def _refusal(program: DrakeProgram, motion: SplineMotion) -> tuple[str, Array]:
    """Return why a motion is refused, or "", and the instants at which a margin is violated."""
    refusal, violations = program.problem.check_spline(program.problem.chart.curve(motion.points))
    if refusal:
        return refusal, violations
    longest = program.cost.objective.max_duration or np.inf
    time_scaling = max(1.0, rate_time_scaling(motion, program.bounds))
    if time_scaling > _MAX_TIME_SCALING:
        return "the solution exceeds a limit on a joint's rate", violations
    if motion.duration * time_scaling > longest * (1 + _DURATION_TOLERANCE):
        return f"no motion in {longest:g} s was found", violations
    return "", violations


def _accepted(program: DrakeProgram, motion: SplineMotion) -> SplineMotion | None:
    """Return a motion, slowed until it keeps its rate bounds, if it is not refused."""
    time_scaling = max(1.0, rate_time_scaling(motion, program.bounds))
    slower = SplineMotion(motion.points, motion.duration * time_scaling)
    return None if _refusal(program, slower)[0] else slower


def _is_better(cost: MotionCost, motion: SplineMotion, best: SplineMotion | None) -> bool:
    return best is None or (
        cost.value(motion.points, motion.duration) < cost.value(best.points, best.duration)
    )


def _is_no_gain(objective: RefineObjective, best: SplineMotion, start: _Start) -> bool:
    """Return whether the convex steps have found as quick a motion, where only that counts."""
    is_duration_alone = not (objective.is_gentle or objective.path_length)
    return is_duration_alone and best.duration > start.quickest * (1 - _LEAST_GAIN)


def _fall_back(start: _Start, report: RefineReport) -> tuple[Refined, RefineReport]:
    """Return the curve of the convex steps, if they improved the path; the reason stays."""
    if start.curve is None:
        return None, report
    return start.curve, replace(
        report, improved=True, length_after=curve_length(start.curve), duration_after=start.quickest
    )
