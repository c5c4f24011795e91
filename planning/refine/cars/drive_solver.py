"""DriveSolver: optimization of one car path, with audits and fewer segments.

The result of each descent is audited densely, as every refined curve is; where it violates a margin
between the samples at which distances are kept, samples are added and the descent repeats.
"""

from dataclasses import dataclass

from planning.domain.arrays import Array
from planning.domain.curves.path import JointPath
from planning.domain.request.deadline import Deadline
from planning.domain.robot.joints import JointLimits
from planning.refine.cars.arc_segments import NO_SAMPLES, ArcSegments
from planning.refine.cars.drive_evaluation import DriveEvaluation
from planning.refine.cars.drive_model import DriveModel
from planning.refine.cars.drive_problem import DriveProblem
from planning.refine.cars.drive_trust_region import DriveTrustRegion
from planning.refine.cars.segment_times import SegmentTimes
from planning.refine.constraints.clearance_objective import make_clearance_objective
from planning.refine.constraints.constraint_distances import (
    ConstraintDistanceQuery,
    audit_constraints,
    predicate_constraints,
)
from planning.refine.constraints.distance_buffers import DistanceBuffers
from planning.refine.constraints.distance_query import make_distance_query
from planning.refine.curve_checks import Auditor, DenseSamples
from planning.refine.curves.chart import FlatChart
from planning.refine.request import RefineRequest
from planning.world.constraints.predicate_constraint import PredicateConstraint
from planning.world.world import World

# Most rounds of additional samples after an audit.
_MAX_REPAIR_ROUNDS = 4
# Most paths of one segment less that are tried from each path.
_MAX_REDUCTIONS = 5
# Least gain for a result to count, as a share of the duration.
_MIN_GAIN = 1e-3


@dataclass(frozen=True)
class DriveResult:
    """Result of the optimization.

    Attributes:
        path: Arcs and lines, or None if no faster path was found.
        duration_before: Duration of the given path [s].
        duration_after: Duration of the result [s].
        num_steps: Number of trust-region steps.
        reason: Why there is no result, or "".
    """

    path: JointPath | None
    duration_before: float
    duration_after: float
    num_steps: int
    reason: str


@dataclass(frozen=True)
class DriveSolver:
    """Optimization of one car path: model, audit and trust region."""

    problem: DriveProblem
    limits: JointLimits
    model: DriveModel
    auditor: Auditor
    predicates: tuple[PredicateConstraint, ...]
    trust_region: DriveTrustRegion

    @classmethod
    def of(cls, world: World, request: RefineRequest, deadline: Deadline) -> "DriveSolver":
        """Build the solver for a request."""
        path, constraints = request.path, request.constraints
        group, problem = path.group, DriveProblem.of(path)
        ends = world.embed(group, problem.waypoints[[0, -1]])
        distance_buffers = DistanceBuffers.from_ends(world, request.margins, ends)
        distance_query = make_distance_query(world, group, distance_buffers)
        limits = request.limits
        if constraints is not None:
            distance_query = ConstraintDistanceQuery(distance_query, constraints, FlatChart(path))
            limits = constraints.limits_with_locks(limits)
        limits = problem.limits_near_start(limits, request.fixed_coordinates)
        segment_times = SegmentTimes.of(limits, problem.car_index, limits_jerk=request.limits_jerk)
        clearance_objective = make_clearance_objective(
            world, group, request.margins, request.options.clearance
        )
        model = DriveModel(problem, distance_query, limits, segment_times, clearance_objective)
        return cls(
            problem,
            limits,
            model,
            Auditor(world, group, distance_buffers, constraints and audit_constraints(constraints)),
            () if constraints is None else predicate_constraints(constraints),
            DriveTrustRegion(model, deadline),
        )

    def run(self) -> DriveResult:
        """Return the best path found."""
        initial = self.problem.segments
        first_evaluation = self.model.evaluate(initial)
        current, reason = self._repaired(self.trust_region.optimize(initial))
        best = None if reason else current
        while not self.trust_region.is_over:
            better, reduction_reason = self._reduced(current)
            reason = reason or reduction_reason
            if better is None:
                break
            current = best = better
        num_steps = self.trust_region.num_steps
        if best is None or best.objective > first_evaluation.objective * (1 - _MIN_GAIN):
            reason = reason or "no faster car path was found"
            return DriveResult(
                None, first_evaluation.duration, first_evaluation.duration, num_steps, reason
            )
        return DriveResult(
            self.problem.to_path(best.segments),
            first_evaluation.duration,
            best.duration,
            num_steps,
            "",
        )

    def _reduced(self, current: DriveEvaluation) -> tuple[DriveEvaluation | None, str]:
        """Return a free path of fewer segments and less cost; or None, with a reason if known."""
        target, first_reason = current.merit * (1 - _MIN_GAIN), ""
        for segments in self.trust_region.reductions(current)[:_MAX_REDUCTIONS]:
            trial = self.trust_region.optimize(segments, target=target)
            if trial.merit < target:
                trial, reason = self._repaired(trial)
                if not reason and trial.merit < target:
                    return trial, ""
                first_reason = first_reason or reason
        return None, first_reason

    def _repaired(self, evaluation: DriveEvaluation) -> tuple[DriveEvaluation, str]:
        """Return this or a nearby path that is free by the audit; or the reason without one."""
        extra_samples = NO_SAMPLES
        reason, violations = self.check_path(evaluation.segments)
        for _ in range(_MAX_REPAIR_ROUNDS):
            if not len(violations) or self.trust_region.is_over:
                break
            extra_samples = extra_samples.followed_by(evaluation.segments.samples_at(violations))
            repaired = self.trust_region.optimize(evaluation.segments, extra_samples)
            if len(repaired.segments) != len(evaluation.segments):
                extra_samples = NO_SAMPLES
            evaluation = repaired
            reason, violations = self.check_path(evaluation.segments)
        return evaluation, reason

    def check_path(self, segments: ArcSegments) -> tuple[str, Array]:
        """Return why a path is rejected, or "", and the path parameters of its violations."""
        samples = DenseSamples.of_curve(self.problem.to_path(segments).spline)
        violations = self.auditor.find_violations(samples)
        if len(violations):
            where = ", ".join(f"{s:.3f}" for s in violations[:5])
            what = "violates a collision margin or a path constraint"
            return f"the faster car path {what} at path parameters s = {where}", violations
        if not samples.is_within_limits(self.limits):
            return "the faster car path violates position limits", violations
        if not samples.satisfy(self.predicates):
            return "the faster car path violates a path predicate", violations
        return "", violations
