"""DrakeProgram: Drake's kinematic trajectory optimization of one path, solved by SNOPT.

Variables are the control points of a cubic spline and its duration. Velocities, accelerations and
jerks are bounded by the hulls of their control points, which for accelerations and jerks of cubics
are exact; margins, path constraints and loads at instants.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64
from pydrake.planning import KinematicTrajectoryOptimization
from pydrake.solvers import SnoptSolver, SolverOptions

from planning.domain.arrays import Array
from planning.domain.request.drake_term import DrakeTerm
from planning.refine.curves.bspline_basis import ORDER, make_bspline
from planning.refine.drake.autodiff import constraint_evaluator, cost_evaluator
from planning.refine.drake.margin_rows import MarginRows
from planning.refine.motion.load_rows import LoadRows
from planning.refine.motion.motion_cost import LEAST_COST
from planning.refine.motion.motion_program import OUT_OF_TIME, MotionTask, Solution
from planning.refine.motion.spline_matrices import rate_maps, split
from planning.refine.motion.spline_motion import SplineMotion

SOLVER_NAME = "SNOPT"
# Iterations, not seconds, end a solve, so that the same request gives the same bytes.
_SNOPT_OPTIONS = {
    "Major iterations limit": 60,
    "Major optimality tolerance": 1e-4,
    "Major feasibility tolerance": 1e-6,
}
# Relative reserve to rate bounds, beyond the solver's tolerance.
_RATE_RESERVE = 1e-5
# Shortest duration that the program considers [s].
_LEAST_DURATION = 1e-3


class OutOfTimeError(Exception):
    """The deadline passed, or the plan was canceled, during a solve."""


@dataclass(frozen=True)
class DrakeProgram:
    """The program of one problem, but for the instants at which margins are kept.

    Attributes:
        task: What is optimized.
        plant: The scene's `MultibodyPlant`, for terms.
        terms: Costs and constraints of the user.
    """

    task: MotionTask
    plant: Any
    terms: tuple[DrakeTerm, ...] = ()

    def solve(self, guess: SplineMotion, instants: Float64[np.ndarray, " m"]) -> Solution:
        """Return the motion where SNOPT ended; `MotionProgram` says more."""
        trajopt: Any = KinematicTrajectoryOptimization(make_bspline(guess.points, guess.duration))
        variables = np.append(trajopt.control_points().T.ravel(), trajopt.duration())
        self._add_ends(trajopt)
        self._add_bounds(trajopt)
        self._add_rows(trajopt.get_mutable_prog(), variables, instants)
        latest = self._add_cost(trajopt, guess)
        for term in self.terms:
            term.add(trajopt, self.plant)
        try:
            x, ending = _solve(trajopt.get_mutable_prog(), variables)
            solution = SplineMotion(*split(x, len(guess.points)))
        except OutOfTimeError:
            solution, ending = latest[-1], OUT_OF_TIME
        task = self.task
        motion = solution.with_ends_of(task.problem.waypoints, task.num_rest_points)
        return Solution(motion, ending, 1)

    def _add_ends(self, trajopt: Any) -> None:
        """Add rest at the path's ends; without acceleration where there are three rest points."""
        zero = np.zeros(self.task.problem.waypoints.shape[1])
        for s, row in ((0.0, 0), (1.0, -1)):
            end = self.task.problem.waypoints[row]
            trajopt.AddPathPositionConstraint(end, end, s)
            trajopt.AddPathVelocityConstraint(zero, zero, s)
            if self.task.num_rest_points >= ORDER - 1:
                trajopt.AddPathAccelerationConstraint(zero, zero, s)

    def _add_bounds(self, trajopt: Any) -> None:
        """Add bounds on positions, velocities, accelerations, jerks and the duration."""
        limits, ends = self.task.problem.chart_limits, self.task.problem.waypoints[[0, -1]]
        trajopt.AddPositionBounds(
            np.minimum(limits.lower, ends.min(axis=0)), np.maximum(limits.upper, ends.max(axis=0))
        )
        bounds, reserve = self.task.bounds, 1 - _RATE_RESERVE
        trajopt.AddVelocityBounds(-reserve * bounds.velocity, reserve * bounds.velocity)
        low, high = reserve * bounds.acceleration_range * bounds.acceleration
        trajopt.AddAccelerationBounds(low, high)
        if bounds.jerk is not None:
            trajopt.AddJerkBounds(-reserve * bounds.jerk, reserve * bounds.jerk)
        longest = self.task.cost.objective.max_duration
        trajopt.AddDurationConstraint(_LEAST_DURATION, np.inf if longest is None else longest)

    def _add_rows(self, program: Any, variables: Array, instants: Array) -> None:
        """Add margins at instants, and loads."""
        count, num_coordinates = (
            self.task.cost.num_control_points,
            self.task.problem.waypoints.shape[1],
        )
        margins = MarginRows.at(instants, self.task.problem.distance_query, count)
        binding = program.AddConstraint(
            constraint_evaluator(margins),
            lb=np.zeros(margins.num_rows),
            ub=np.full(margins.num_rows, np.inf),
            vars=variables,
        )
        binding.evaluator().SetGradientSparsityPattern(margins.sparsity(num_coordinates))
        for load in self.task.bounds.loads:
            rows = LoadRows.of(load, count)
            num_rows = rows.num_rows(num_coordinates)
            lower, upper = np.full(num_rows, -np.inf), np.full(num_rows, 1 - _RATE_RESERVE)
            program.AddConstraint(constraint_evaluator(rows), lb=lower, ub=upper, vars=variables)

    def _add_cost(self, trajopt: Any, guess: SplineMotion) -> list[SplineMotion]:
        """Add the cost, relative to that of the guess; return a list with the last one evaluated.

        The cost is a function of scaled rates of the spline. SNOPT knows no second derivatives, and
        those by control points are ill-conditioned; those by rates are not: with them as variables
        it needs a few steps instead of hundreds.
        """
        program, points = trajopt.get_mutable_prog(), trajopt.control_points().T
        rates_of, points_of = rate_maps(len(guess.points), self.task.cost.rate_order)
        at_guess = rates_of @ guess.points
        size = max(float(np.sqrt((at_guess**2).mean())), 1e-9)
        rates = program.NewContinuousVariables(*at_guess.shape, "rate")
        program.SetInitialGuess(rates, at_guess / size)
        for j in range(points.shape[1]):
            program.AddLinearEqualityConstraint(
                np.hstack([rates_of / size, -np.eye(len(rates_of))]),
                np.zeros(len(rates_of)),
                np.concatenate([points[:, j], rates[:, j]]),
            )
        offset = guess.points - points_of @ at_guess
        latest = [guess]
        scale = 1 / max(self.task.cost.value(guess.points, guess.duration), LEAST_COST)

        def scaled(x: Array) -> tuple[float, Array]:
            self._check_time()
            at = offset + size * (points_of @ x[:-1].reshape(at_guess.shape))
            latest[0] = SplineMotion(at, float(x[-1]))
            value, by_points, by_time = self.task.cost.gradient(at, latest[0].duration)
            by_rates = size * (points_of.T @ by_points)
            return scale * value, scale * np.append(by_rates.ravel(), by_time)

        variables = np.append(rates.ravel(), trajopt.duration())
        program.AddCost(cost_evaluator(scaled), vars=variables)
        return latest

    def _check_time(self) -> None:
        """Raise once the deadline is over.

        Raises:
            OutOfTimeError: It is.
        """
        if self.task.problem.deadline.is_over:
            raise OutOfTimeError


def _solve(program: Any, variables: Array) -> tuple[Array, str]:
    """Return the values of the variables where SNOPT ended, and why if they are not optimal.

    Raises:
        OutOfTimeError: An evaluation found the deadline over; Drake passes that on as text.
    """
    solver, options = SnoptSolver(), SolverOptions()
    for name, number in _SNOPT_OPTIONS.items():
        options.SetOption(solver.id(), name, number)
    try:
        result = solver.Solve(program, None, options)
    except RuntimeError as error:
        if OutOfTimeError.__name__ in str(error):
            raise OutOfTimeError from error
        raise
    ending = "" if result.is_success() else f"SNOPT ended with {result.get_solution_result().name}"
    return np.asarray(result.GetSolution(variables), dtype=np.float64), ending
