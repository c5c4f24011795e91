"""DriveSolver: optimisation of one car path, with audits and fewer segments.

The result of each descent is audited densely, as every refined curve is; where it is too near to an
obstacle between the samples at which distances are kept, samples are added and the descent repeats.
"""

from dataclasses import dataclass

from planning.domain.curves.path import JointPath
from planning.domain.request.deadline import Deadline
from planning.domain.robot.joints import JointLimits
from planning.refine.audit import Auditor, is_accepted, within_limits
from planning.refine.cars.arc_segments import NOWHERE, ArcSegments
from planning.refine.cars.drive_evaluation import DriveEvaluation
from planning.refine.cars.drive_model import DriveModel
from planning.refine.cars.drive_problem import DriveProblem
from planning.refine.cars.drive_trust_region import DriveTrustRegion
from planning.refine.cars.segment_times import SegmentTimes
from planning.refine.constraints.clearance_objective import clearance_objective
from planning.refine.constraints.constraint_distances import RuledNearness, audited, predicates
from planning.refine.constraints.distance_buffers import DistanceBuffers
from planning.refine.constraints.distance_query import nearness_of
from planning.refine.curves.chart import FlatChart
from planning.refine.request import RefineRequest
from planning.world.constraints.predicate_constraint import PredicateConstraint
from planning.world.world import Array, World

# Most rounds of additional samples after an audit.
_MOST_CLOSER = 4
# Most paths of one segment less that are tried from each path.
_MOST_TRIALS = 5
# Least gain for a result to count, as a share of the duration.
_GAIN = 1e-3


@dataclass(frozen=True)
class DriveResult:
    """Result of the optimisation.

    Attributes:
        path: Arcs and lines, or None if nothing is quicker.
        before: Duration of the given path [s].
        after: Duration of the result [s].
        steps: Number of trust-region steps.
        reason: Why there is no result, or "".
    """

    path: JointPath | None
    before: float
    after: float
    steps: int
    reason: str


@dataclass(frozen=True)
class DriveSolver:
    """Optimisation of one car path: model, audit and trust region."""

    course: DriveProblem
    limits: JointLimits
    model: DriveModel
    auditor: Auditor
    predicates: tuple[PredicateConstraint, ...]
    descent: DriveTrustRegion

    @classmethod
    def of(cls, world: World, request: RefineRequest, share: Deadline) -> "DriveSolver":
        """Build the solver for a request."""
        path, rules = request.path, request.rules
        group, course = path.group, DriveProblem.of(path)
        ends = world.embed(group, course.rows[[0, -1]])
        buffers = DistanceBuffers.between(world, request.margins, ends)
        nearness = nearness_of(world, group, buffers)
        limits = request.limits
        if rules is not None:
            nearness = RuledNearness(nearness, rules, FlatChart(path))
            limits = rules.fixing(limits)
        limits = course.about_start(limits, request.held)
        times = SegmentTimes.of(limits, course.at, jerk=request.jerk)
        wish = clearance_objective(world, group, request.margins, request.options.clearance)
        model = DriveModel(course, nearness, limits, times, wish)
        return cls(
            course,
            limits,
            model,
            Auditor(world, group, buffers, rules and audited(rules)),
            () if rules is None else predicates(rules),
            DriveTrustRegion(model, share),
        )

    def run(self) -> DriveResult:
        """Return the best path found."""
        given = self.course.letters
        first = self.model.look(given)
        current, reason = self._free(self.descent.settled(given))
        best = None if reason else current
        while not self.descent.is_over:
            better, why = self._with_fewer(current)
            reason = reason or why
            if better is None:
                break
            current = best = better
        steps = self.descent.num_steps
        if best is None or best.worth > first.worth * (1 - _GAIN):
            reason = reason or "no quicker drive was found"
            return DriveResult(None, first.duration, first.duration, steps, reason)
        return DriveResult(
            self.course.path_of(best.letters), first.duration, best.duration, steps, ""
        )

    def _with_fewer(self, current: DriveEvaluation) -> tuple[DriveEvaluation | None, str]:
        """Return a free path of fewer segments and less cost; or None, with a reason if known."""
        target, why = current.cost * (1 - _GAIN), ""
        for letters in self.descent.fewer(current)[:_MOST_TRIALS]:
            tried = self.descent.settled(letters, target=target)
            if tried.cost < target:
                tried, reason = self._free(tried)
                if not reason and tried.cost < target:
                    return tried, ""
                why = why or reason
        return None, why

    def _free(self, seen: DriveEvaluation) -> tuple[DriveEvaluation, str]:
        """Return this or a nearby path that is free by the audit; or the reason without one."""
        watched = NOWHERE
        reason, violated = self.refused(seen.letters)
        for _ in range(_MOST_CLOSER):
            if not len(violated) or self.descent.is_over:
                break
            watched = watched.and_then(seen.letters.spots_at(violated))
            closer = self.descent.settled(seen.letters, watched)
            if len(closer.letters) != len(seen.letters):
                watched = NOWHERE
            seen = closer
            reason, violated = self.refused(seen.letters)
        return seen, reason

    def refused(self, letters: ArcSegments) -> tuple[str, Array]:
        """Return why a path is rejected, or "", and where it is too near to obstacles."""
        curve = self.course.path_of(letters).spline
        violated = self.auditor.violated(curve)
        if len(violated):
            where = ", ".join(f"{s:.3f}" for s in violated[:5])
            what = "is too near to something or breaks a path constraint"
            return f"the quicker drive {what} at s = {where}", violated
        if not within_limits(curve, self.limits):
            return "the quicker drive leaves the position limits", violated
        if not is_accepted(curve, self.predicates):
            return "a predicate rejects the quicker drive", violated
        return "", violated
