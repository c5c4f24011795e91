"""RefineProblem: trajectory optimisation of one path, and local descents from initial guesses."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float64

from planning.domain.curves.curve import JointSpline
from planning.domain.request.deadline import Deadline
from planning.domain.robot.joints import JointLimits
from planning.domain.robot.manifold import Manifold
from planning.refine.audit import Auditor, is_accepted, within_limits
from planning.refine.constraints.clearance_objective import ClearanceObjective, clearance_objective
from planning.refine.constraints.constraint_distances import RuledNearness, audited, predicates
from planning.refine.constraints.distance_buffers import DistanceBuffers
from planning.refine.constraints.distance_query import DistanceQuery, nearness_of
from planning.refine.constraints.load import Load
from planning.refine.constraints.rate_bounds import RateBounds
from planning.refine.constraints.request_bounds import request_bounds, signed_accelerations
from planning.refine.curves.chart import Chart, chart_of
from planning.refine.curves.curve_evaluation import CurveEvaluation
from planning.refine.curves.duration_bound import least_duration
from planning.refine.curves.fit import fit_control_points
from planning.refine.curves.path_velocity import duration_of, grid_of
from planning.refine.model.curve_model import CurveModel
from planning.refine.model.load_evaluation import path_velocity_along
from planning.refine.request import RefineRequest
from planning.refine.trust_region import TrustRegion
from planning.world.constraints.predicate_constraint import PredicateConstraint
from planning.world.world import Array, World

# Iterations, not seconds, decide when to give up, so that the same request gives the same bytes.
_MAX_STEPS = 25
# Spacing of the instants at which distances are kept (joint-space length), and their number.
_APART = 0.045
_FEWEST, _MOST = 60, 200
# Factor above the least possible duration at which the optimisation stops.
_OPTIMAL = 1.002
# Factor above the least possible duration beyond which other initial guesses are tried.
_SATISFYING = 1.03
# Number of curves rejected by a predicate that ends a descent: no gradient leads to others.
_MOST_REJECTED = 2
_REJECTED = "a predicate rejects the optimised curve"


@dataclass(frozen=True)
class RefineProblem:
    """Trajectory optimisation problem of one path, shared by all descents.

    Attributes:
        request: Refinement request.
        share: End of the optimisation.
        chart: The coordinates of control points.
        waypoints: Of the path, in these coordinates.
        limits: The request's limits, tightened by its path constraints.
        box: The same with coordinates for positions.
        bounds: Bounds on the rates of coordinates and on loads.
        least: The duration that no motion beats [s].
        nearness: Distances of pairs of bodies, and signed margins of path constraints.
        wish: Clearance objective, or None.
        auditor: Checker of the optimised curves.
        predicates: Constraints without gradient, which every sample must satisfy.
        instants: Least and largest number of instants in a first model.
    """

    request: RefineRequest
    share: Deadline
    chart: Chart
    waypoints: Array
    limits: JointLimits
    box: JointLimits
    bounds: RateBounds
    least: float
    nearness: DistanceQuery
    wish: ClearanceObjective | None
    auditor: Auditor
    predicates: tuple[PredicateConstraint, ...] = ()
    instants: tuple[int, int] = (_FEWEST, _MOST)

    @classmethod
    def of(cls, world: World, request: RefineRequest, share: Deadline) -> "RefineProblem":
        """Build the problem of a request."""
        group, rules, limits = request.path.group, request.rules, request.limits
        chart = chart_of(request.path)
        waypoints = chart.waypoints
        ends = world.embed(group, chart.positions(waypoints[[0, -1]]))
        buffers = DistanceBuffers.between(world, request.margins, ends)
        bounds = request_bounds(world, request)
        nearness = chart.measured(nearness_of(world, group, buffers))
        tight = limits if rules is None else rules.fixing(limits)
        wish = clearance_objective(world, group, request.margins, request.options.clearance)
        return cls(
            request,
            share,
            chart,
            waypoints,
            tight,
            _holding(chart.box(tight), waypoints[0], request.held),
            bounds,
            least_of(request, bounds.loads),
            nearness if rules is None else RuledNearness(nearness, rules, chart),
            wish and wish.along(chart.measured(wish.nearness)),
            Auditor(world, group, buffers, rules and audited(rules)),
            () if rules is None else predicates(rules),
        )

    @property
    def is_held(self) -> bool:
        """Whether the joints can hold the robot still at the start and at the goal."""
        ends = self.waypoints[[0, -1]]
        return all((np.abs(load.held(ends)) <= 1).all() for load in self.bounds.loads)

    def wants_more_than(self, best: CurveEvaluation | None) -> bool:
        """Return whether there is time for another guess and the best curve is slow enough."""
        is_near = best is not None and best.worth <= _SATISFYING * self.least
        return not (is_near or self.share.is_over)

    def curve_of(self, seen: CurveEvaluation) -> JointSpline:
        """Return a curve as a joint spline."""
        return self.chart.curve(seen.points)

    def fitted(self, closeness: float) -> Array:
        """Return the control points of a curve near the path."""
        return self.near(self.waypoints, closeness)

    def near(self, waypoints: Float64[np.ndarray, "n nv"], closeness: float = 0.15) -> Array:
        """Return the control points of a curve near a polyline between the path's ends."""
        limits = self.box
        guess = fit_control_points(waypoints, self.bounds.velocity, closeness)
        guess[1:-1] = np.clip(guess[1:-1], limits.lower, limits.upper)
        return guess

    def duration_of(self, points: Array) -> float:
        """Return the least duration of a curve [s], free or not."""
        _, pace, _ = path_velocity_along(points, self.bounds)
        return duration_of(grid_of(len(points)), pace)

    def descend(self, guess: Array) -> tuple[CurveEvaluation | None, int, str]:
        """Return the best free curve of a descent from a guess, or None.

        Also the number of steps, and why the last curve was rejected.
        """
        length = float(np.linalg.norm(np.diff(self.waypoints, axis=0), axis=1).sum())
        count = int(np.clip(length / _APART, *self.instants))
        model = CurveModel(self.nearness, self.box, self.bounds, len(guess), count, self.wish)
        descent = TrustRegion(model, guess)
        best: CurveEvaluation | None = None
        reason, rejected = "no time was left", 0
        for seen in descent.run(_MAX_STEPS):
            if best is None or seen.worth < best.worth:
                reason, violated = self.refused(seen)
                rejected += reason == _REJECTED
                if not reason:
                    best = seen
                if len(violated):
                    descent.keep_distance_at(violated, best)
            if (
                self.share.is_over
                or rejected >= _MOST_REJECTED
                or (best is not None and best.worth < _OPTIMAL * self.least)
            ):
                break
        return best, descent.num_steps, reason

    def refused(self, seen: CurveEvaluation) -> tuple[str, Array]:
        """Return why a curve is rejected, or "", and the instants where it is in violation."""
        curve = self.curve_of(seen)
        violated = self.auditor.violated(curve)
        if len(violated):
            where = ", ".join(f"{s:.3f}" for s in violated[:5])
            what = "is too near to something"
            what += "" if self.request.rules is None else " or breaks a path constraint"
            return f"the optimised curve {what} at s = {where}", violated
        if seen.felt is not None and seen.felt.excess > 0:
            return "gravity is more than a joint can hold on the optimised curve", violated
        if not within_limits(curve, self.limits):
            return "the optimised curve leaves the position limits", violated
        if not is_accepted(curve, self.predicates):
            return _REJECTED, violated
        return "", violated


def least_of(request: RefineRequest, loads: tuple[Load, ...] = ()) -> float:
    """Return a lower bound of the duration of motions between the path's ends [s]."""
    group, ends = request.path.group, request.path.waypoints[[0, -1]]
    moved = Manifold.of(group.joints).minus(ends[1], ends[0])
    signed = signed_accelerations(group, request.others.acceleration_bounds)
    least = least_duration(request.limits, moved, jerk=request.jerk, signed=signed)
    return max(least, *(load.least_duration(ends) for load in loads), 0.0)


def _holding(box: JointLimits, q: Array, held: tuple[int, ...]) -> JointLimits:
    """Return limits that fix some coordinates at their values in q."""
    lower, upper = np.array(box.lower), np.array(box.upper)
    lower[list(held)] = upper[list(held)] = q[list(held)]
    return replace(box, lower=lower, upper=upper)
