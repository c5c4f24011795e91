"""The trajectory optimisation: Drake's KinematicTrajectoryOptimization, solved by SNOPT.

Decision variables are the control points of a cubic B-spline q(t) and its duration T. The cost is
T plus a little of the length; rates are bounded on control points, which bounds them everywhere;
distances are bounded at instants, to which the caller adds.

The curve is one of the whole plant's positions, because Drake's distance constraint is: joints
outside the group are held by equal bounds, mimic joints by linear equations. So all gradients stay
in C++, where a sample costs tens of microseconds; a constraint in the group's own coordinates
would have to be evaluated in Python, at several times that. The price is a few idle variables.

The velocity at the ends is free: r'(s) then vanishes nowhere, so that a retimer can bring the
curve to rest at its ends, and the power basis of the very solution can go on without a refit.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64
from pydrake.multibody.inverse_kinematics import MinimumDistanceLowerBoundConstraint
from pydrake.planning import KinematicTrajectoryOptimization
from pydrake.solvers import SnoptSolver, SolverOptions

from planning.domain.joints import JointGroup, JointLimits
from planning.domain.value import Value
from planning.refine.buffers import Buffers
from planning.refine.distances import group_checker
from planning.refine.fit import spline_of
from planning.world.world import World

type Array = np.ndarray[Any, np.dtype[np.float64]]

SOLVER = "SNOPT"
# Beside a duration of seconds, a radian of length costs this [s/rad].
_LENGTH_WEIGHT = 0.05
# Pairs that are this much farther than demanded count for nothing [m].
_INFLUENCE = 0.03
# Relative to its guess; keeps the optimiser from wandering off to where it cannot come back.
_LONGEST, _BRIEFEST = 1.5, 0.01
# Found by measurement: short steps from a guess that is nearly free solve problems that long
# steps leave by a jump through an obstacle.
_OPTIONS = {
    "Major iterations limit": 15,
    "Major step limit": 0.05,
    "Major feasibility tolerance": 1e-4,
    "Major optimality tolerance": 1e-3,
    "Superbasics limit": 500,
}
_TIMED_OUT = 34
# An infinite bound times the duration would be no number.
_UNBOUNDED_RATE = 1e3


@dataclass(frozen=True, eq=False)
class Solution(Value):
    """Where the solver stopped.

    Attributes:
        control_points: Of the group's q, the ends exactly as given, shape (n, nq).
        duration: T [s].
        converged: Whether the solver calls it optimal.
        cut_short: Whether time stopped it, so that it is not repeatable.
    """

    control_points: Float64[np.ndarray, "n nq"]
    duration: float
    converged: bool
    cut_short: bool


class CurveProgram:
    """One optimisation problem, solved again and again with more instants."""

    def __init__(
        self,
        world: World,
        group: JointGroup,
        limits: JointLimits,
        buffers: Buffers,
        guess: Float64[np.ndarray, "n nq"],
        *,
        jerk: bool,
    ) -> None:
        """Pose the problem without instants; `guess` are control points, whose ends stay."""
        self._limits = limits
        self.guess = guess
        self._jerk = jerk
        self._model = world.drake
        self._box: Any = None
        self._indices = world.drake.position_indices(group)
        self._full = world.embed(group, guess)
        self.guessed_duration = _least_duration(guess, limits, jerk=jerk)
        self._checker = group_checker(world.drake, group, buffers)
        self._context = self._checker.MakeStandaloneModelContext()
        self._kto = KinematicTrajectoryOptimization(spline_of(self._full, self.guessed_duration))
        self._x = np.array(self._kto.prog().initial_guess())
        self._hold_others()
        self._bound_positions()
        self._bound_rates()
        self._kto.AddDurationCost(1.0)
        self._kto.AddPathLengthCost(_LENGTH_WEIGHT)

    def keep_distance_at(self, instants: Float64[np.ndarray, " m"]) -> None:
        """Demand the buffered distances at s in (0, 1) from now on."""
        for s in instants:
            distance = MinimumDistanceLowerBoundConstraint(
                collision_checker=self._checker,
                bound=0.0,
                collision_checker_context=self._context,
                influence_distance_offset=_INFLUENCE,
            )
            self._kto.AddPathPositionConstraint(distance, float(s))

    def stay_near(self, points: Float64[np.ndarray, "n nq"], seconds: float) -> None:
        """Start again from control points, and keep each within a box around them.

        Args:
            points: Of the group's q.
            seconds: Half of the box's sides, as the time to cross it at the velocity limit.
        """
        program = self._kto.get_mutable_prog()
        if self._box is not None:
            program.RemoveConstraint(self._box)
        reach = seconds * _rate_bounds(self._limits)[0]
        inner = self._kto.control_points()[self._indices, 1:-1].T
        self._box = program.AddBoundingBoxConstraint(
            (points[1:-1] - reach).ravel(), (points[1:-1] + reach).ravel(), inner.ravel()
        )
        duration = _least_duration(points, self._limits, jerk=self._jerk)
        full = np.repeat(self._full[:1], len(points), axis=0)
        full[:, self._indices] = points
        self._kto.SetInitialGuess(spline_of(self._model.follow(full), duration))
        self._x = np.array(self._kto.prog().initial_guess())

    def solve(self, seconds: float) -> Solution:
        """Solve from where the last call stopped; `seconds` is only a safety net.

        Raises:
            RuntimeError: A constraint could not be evaluated.
        """
        options = SolverOptions()
        for name, value in {**_OPTIONS, "Time limit": max(seconds, 0.01)}.items():
            options.SetOption(SnoptSolver.id(), name, value)
        solved = SnoptSolver().Solve(self._kto.prog(), self._x, options)
        self._x = np.array(solved.get_x_val())
        spline = self._kto.ReconstructTrajectory(solved)
        details: Any = solved.get_solver_details()
        points = np.array(spline.control_points())[:, self._indices, 0]
        # The solver keeps linear bounds to its tolerance only; the hull must lie within.
        points = np.clip(points, self._limits.lower, self._limits.upper)
        points[[0, -1]] = self.guess[[0, -1]]
        return Solution(
            points,
            float(spline.end_time()),
            bool(solved.is_success()),
            bool(details.info == _TIMED_OUT),
        )

    def _hold_others(self) -> None:
        """Fix what is not the group's, and let mimic joints follow."""
        program, points = self._kto.get_mutable_prog(), self._kto.control_points()
        followers: set[int] = set()
        for coupling in self._model.couplings:
            follower, leader = coupling.follower_position, coupling.leader_position
            if leader in self._indices:
                followers.add(follower)
                for point in points.T:
                    program.AddLinearEqualityConstraint(
                        np.array([[1.0, -coupling.multiplier]]),
                        np.array([coupling.offset]),
                        np.array([point[follower], point[leader]]),
                    )
        free = followers.union(self._indices.tolist())
        for i in range(len(points)):
            if i not in free:
                held = np.full(points.shape[1], self._full[0, i])
                program.AddBoundingBoxConstraint(held, held, points[i])

    def _bound_positions(self) -> None:
        program, points = self._kto.get_mutable_prog(), self._kto.control_points()
        for row, i in enumerate(self._indices):
            lower = np.full(points.shape[1], self._limits.lower[row])
            upper = np.full(points.shape[1], self._limits.upper[row])
            lower[[0, -1]] = upper[[0, -1]] = self.guess[[0, -1], row]
            program.AddBoundingBoxConstraint(lower, upper, points[i])

    def _bound_rates(self) -> None:
        """Bound the derivatives of the group's coordinates, and of no others."""
        held = np.delete(self._kto.control_points(), self._indices, axis=0)
        held_ids = {variable.get_id() for variable in held.ravel()}
        program = self._kto.get_mutable_prog()
        velocity, acceleration, jerks = _rate_bounds(self._limits)
        added: list[Any] = list(self._kto.AddVelocityBounds(*self._both_ways(velocity)))
        added += self._kto.AddAccelerationBounds(*self._both_ways(acceleration))
        if self._jerk:
            added += self._kto.AddJerkBounds(*self._both_ways(jerks))
        for binding in added:
            if any(variable.get_id() in held_ids for variable in binding.variables()):
                program.RemoveConstraint(binding)
        shortest, longest = _BRIEFEST * self.guessed_duration, _LONGEST * self.guessed_duration
        self._kto.AddDurationConstraint(shortest, longest)

    def _both_ways(self, bound: Float64[np.ndarray, " nq"]) -> tuple[Array, Array]:
        full = np.full(self._full.shape[1], 1.0)
        full[self._indices] = bound
        return -full, full


def _rate_bounds(limits: JointLimits) -> tuple[Array, Array, Array]:
    """Return bounds per coordinate on velocity, acceleration and jerk, finite."""
    velocity, acceleration, jerk = (
        np.minimum(limits.per_coordinate(rates), _UNBOUNDED_RATE)
        for rates in (limits.velocity, limits.acceleration, limits.jerk)
    )
    return velocity, acceleration, jerk


def _least_duration(
    control_points: Float64[np.ndarray, "n nq"], limits: JointLimits, *, jerk: bool
) -> float:
    """Return the least T [s] in which the B-spline over [0, T] keeps its rate limits.

    The k-th derivative of r(t / T) is r^(k) / T^k and lies in the hull of its control points, so
    T is the largest k-th root of |r^(k)| / bound.
    """
    spline = spline_of(control_points)
    longest = 0.0
    for k, bound in enumerate(_rate_bounds(limits)[: 3 if jerk else 2], start=1):
        derivative: Any = spline.MakeDerivative(k)
        points = np.array(derivative.control_points())[..., 0]
        longest = max(longest, float(np.max(np.abs(points) / bound)) ** (1 / k))
    return longest
