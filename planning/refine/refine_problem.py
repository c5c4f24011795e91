"""RefineProblem: trajectory optimization of one path, and local descents from initial guesses."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.curves.curve import JointSpline
from planning.domain.request.deadline import Deadline
from planning.domain.robot.joints import JointLimits
from planning.domain.robot.manifold import Manifold
from planning.refine.constraints.clearance_objective import ClearanceCost, make_clearance_objective
from planning.refine.constraints.constraint_distances import (
    ConstraintDistanceQuery,
    audit_constraints,
    predicate_constraints,
)
from planning.refine.constraints.distance_buffers import DistanceBuffers
from planning.refine.constraints.distance_query import DistanceQuery, make_distance_query
from planning.refine.constraints.load import Load
from planning.refine.constraints.rate_bounds import RateBounds
from planning.refine.constraints.request_bounds import request_bounds, signed_accelerations
from planning.refine.curve_checks import Auditor, DenseSamples
from planning.refine.curves.bspline_basis import even_positions
from planning.refine.curves.bspline_fit import fit_control_points
from planning.refine.curves.chart import Chart, make_chart
from planning.refine.curves.curve_evaluation import CurveEvaluation
from planning.refine.curves.duration_bound import duration_lower_bound
from planning.refine.curves.path_velocity import duration_of, path_grid
from planning.refine.descents.descent import PREDICATE_REJECTION, Descent
from planning.refine.model.curve_model import CurveModel
from planning.refine.model.load_evaluation import path_velocity_along
from planning.refine.request import RefineRequest
from planning.world.constraints.predicate_constraint import PredicateConstraint
from planning.world.world import World

# Spacing of the instants at which distances are kept (joint-space length), and their number.
_SAMPLE_SPACING = 0.045
_MIN_SAMPLES, _MAX_SAMPLES = 60, 200
# Factor above the least possible duration beyond which other initial guesses are tried.
_RESTART_RATIO = 1.03


@dataclass(frozen=True)
class RefineProblem:
    """Trajectory optimization problem of one path, shared by all descents.

    Attributes:
        request: Refinement request.
        deadline: End of the optimization.
        chart: The coordinates of control points.
        waypoints: Waypoints of the path, in these coordinates.
        limits: The request's limits, tightened by its path constraints.
        chart_limits: The same, with position limits in the chart's coordinates.
        rate_bounds: Bounds on the rates of coordinates and on loads.
        lower_bound: Lower bound of the duration of all motions from start to goal [s].
        distance_query: Distances of pairs of bodies, and signed margins of path constraints.
        clearance_objective: Clearance objective, or None.
        auditor: Checker of the optimized curves.
        predicates: Constraints without gradient, which every sample must satisfy.
        sample_range: Least and largest number of instants in a first model.
    """

    request: RefineRequest
    deadline: Deadline
    chart: Chart
    waypoints: Array
    limits: JointLimits
    chart_limits: JointLimits
    rate_bounds: RateBounds
    lower_bound: float
    distance_query: DistanceQuery
    clearance_objective: ClearanceCost | None
    auditor: Auditor
    predicates: tuple[PredicateConstraint, ...] = ()
    sample_range: tuple[int, int] = (_MIN_SAMPLES, _MAX_SAMPLES)

    @classmethod
    def of(cls, world: World, request: RefineRequest, deadline: Deadline) -> "RefineProblem":
        """Build the problem of a request."""
        group, constraints, limits = request.path.group, request.constraints, request.limits
        chart = make_chart(request.path)
        waypoints = chart.waypoints
        ends = world.embed(group, chart.positions(waypoints[[0, -1]]))
        buffers = DistanceBuffers.from_ends(world, request.margins, ends)
        rate_bounds = request_bounds(world, request)
        distance_query = chart.distance_query_in_chart(make_distance_query(world, group, buffers))
        predicates: tuple[PredicateConstraint, ...] = ()
        if constraints is not None:
            distance_query = ConstraintDistanceQuery(distance_query, constraints, chart)
            limits = constraints.limits_with_locks(limits)
            predicates = predicate_constraints(constraints)
        chart_limits = chart.limits_in_chart(limits)
        clearance_objective = make_clearance_objective(
            world, group, request.margins, request.options.clearance
        )
        if clearance_objective is not None:
            clearance_objective = clearance_objective.with_distance_query(
                chart.distance_query_in_chart(clearance_objective.distance_query)
            )
        return cls(
            request,
            deadline,
            chart,
            waypoints,
            limits,
            _fix_coordinates(chart_limits, waypoints[0], request.fixed_coordinates),
            rate_bounds,
            request_lower_bound(request, rate_bounds.loads),
            distance_query,
            clearance_objective,
            Auditor(world, group, buffers, constraints and audit_constraints(constraints)),
            predicates,
        )

    @property
    def is_static_load_feasible(self) -> bool:
        """Whether the joints can hold the robot still at the start and at the goal."""
        ends = self.waypoints[[0, -1]]
        return all((np.abs(load.static_load(ends)) <= 1).all() for load in self.rate_bounds.loads)

    def needs_another_start(self, best: CurveEvaluation | None) -> bool:
        """Return whether time remains for another guess and the best curve is slow enough."""
        is_good_enough = best is not None and best.objective <= _RESTART_RATIO * self.lower_bound
        return not (is_good_enough or self.deadline.is_over)

    def curve_of(self, evaluation: CurveEvaluation) -> JointSpline:
        """Return a curve as a joint spline."""
        return self.chart.curve(evaluation.points)

    def fit_path(self, tolerance: float) -> Array:
        """Return the control points of a curve near the path."""
        return self.fit_waypoints(self.waypoints, tolerance)

    def fit_waypoints(
        self, waypoints: Float64[np.ndarray, "n nv"], tolerance: float = 0.15
    ) -> Array:
        """Return the control points of a curve near a polyline between the path's ends."""
        limits = self.chart_limits
        guess = fit_control_points(waypoints, self.rate_bounds.velocity, tolerance)
        guess[1:-1] = np.clip(guess[1:-1], limits.lower, limits.upper)
        return guess

    def duration_of(self, points: Array) -> float:
        """Return the least duration of a curve [s], free or not."""
        path_velocity, _ = path_velocity_along(points, self.rate_bounds)
        return duration_of(path_grid(len(points)), path_velocity)

    @property
    def is_over(self) -> bool:
        """Whether the time is used up."""
        return self.deadline.is_over

    def descent(self, guess: Float64[np.ndarray, "k nv"]) -> Descent:
        """Return a descent from a guess, before its first step."""
        length = float(np.linalg.norm(np.diff(self.waypoints, axis=0), axis=1).sum())
        num_samples = int(np.clip(length / _SAMPLE_SPACING, *self.sample_range))
        model = CurveModel(
            self.distance_query,
            self.chart_limits,
            self.rate_bounds,
            len(guess),
            num_samples,
            self.clearance_objective,
        )
        return Descent(self, model, guess)

    def check_curve(self, evaluation: CurveEvaluation) -> tuple[str, Array]:
        """Return why a curve is rejected, or "", and the instants where it is in violation."""
        excess = 0.0 if evaluation.loads is None else evaluation.loads.excess
        return self._check_samples(self.samples_of(evaluation.points), excess)

    def check_points(self, points: Float64[np.ndarray, "k nv"]) -> tuple[str, Array]:
        """Return the same for control points, but for static loads."""
        return self._check_samples(self.samples_of(points), 0.0)

    def samples_of(self, points: Float64[np.ndarray, "k nv"]) -> DenseSamples:
        """Return dense samples of the curve with these control points."""
        if self.predicates:
            # What they are told are positions of the delivered curve, angles on circles included.
            return DenseSamples.of_curve(self.chart.curve(points))
        return DenseSamples.of(lambda n: self.chart.positions(even_positions(points, n)))

    def _check_samples(self, samples: DenseSamples, static_excess: float) -> tuple[str, Array]:
        violations = self.auditor.find_violations(samples)
        if len(violations):
            where = ", ".join(f"{s:.3f}" for s in violations[:5])
            what = "a collision margin"
            what += "" if self.request.constraints is None else " or a path constraint"
            message = f"the optimized curve violates {what} at path parameters s = {where}"
            return message, violations
        if static_excess > 0:
            return "the static torque exceeds an effort limit on the optimized curve", violations
        if not samples.is_within_limits(self.limits):
            return "the optimized curve violates position limits", violations
        if not samples.satisfy(self.predicates):
            return PREDICATE_REJECTION, violations
        return "", violations


def request_lower_bound(request: RefineRequest, loads: tuple[Load, ...] = ()) -> float:
    """Return a lower bound of the duration of motions between the path's ends [s]."""
    group, ends = request.path.group, request.path.waypoints[[0, -1]]
    displacement = Manifold.of(group.joints).minus(ends[1], ends[0])
    acceleration_bounds = signed_accelerations(group, request.motion_limits.acceleration_bounds)
    joint_bound = duration_lower_bound(
        request.limits,
        displacement,
        limits_jerk=request.limits_jerk,
        acceleration_bounds=acceleration_bounds,
    )
    return max(joint_bound, *(load.duration_lower_bound(ends) for load in loads), 0.0)


def _fix_coordinates(limits: JointLimits, q: Array, fixed: tuple[int, ...]) -> JointLimits:
    """Return limits that fix some coordinates at their values in q."""
    lower, upper = np.array(limits.lower), np.array(limits.upper)
    lower[list(fixed)] = upper[list(fixed)] = q[list(fixed)]
    return replace(limits, lower=lower, upper=upper)
