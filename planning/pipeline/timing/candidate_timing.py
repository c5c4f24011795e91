"""CandidateMotion: a timed motion that is not certified yet; and how curves become candidates."""

from dataclasses import dataclass, field, replace

from planning.domain.curves.curve import JointSpline, TimedTrajectory
from planning.domain.report.objective_values import ObjectiveValues
from planning.domain.report.stage_reports import RefineReport, RetimeReport
from planning.domain.request.deadline import Deadline
from planning.domain.request.options import RefineOptions, RetimeOptions
from planning.domain.request.refine_objective import QUICKEST
from planning.domain.request.stopwatch import Stopwatch
from planning.domain.robot.joints import JointGroup, JointLimits
from planning.errors import RetimingFailed
from planning.pipeline.timing.path_curves import PathCurve
from planning.pipeline.timing.path_duration_bound import path_duration_bound
from planning.refine.motion.motion_objectives import MotionObjectives
from planning.retime.limits.path_limit import PathLimit
from planning.retime.retimer import keep_timing, retime
from planning.world.world import World

# Name of the candidate along the refined curve.
REFINED_CURVE = "refined curve"
# Share of the time for timing another curve when there is a timed motion already.
_COMPARISON_TIME_FRACTION = 0.5
# Relative difference up to which durations count as equal.
_DURATION_TOLERANCE = 1e-6


@dataclass(frozen=True)
class CandidateMotion:
    """Timed motion that is not certified yet.

    Attributes:
        name: Name of the curve, for messages and reports.
        curve: Geometric curve that the motion follows.
        trajectory: The motion.
        refine: Report of the refinement.
        retime: Report of the retiming.
        clearance_penalty: Cost of clearance below the clearance objective's distance [s].
        objective_cost: Cost by the refinement's objective; None where that is the duration [s].
    """

    name: str
    curve: JointSpline
    trajectory: TimedTrajectory
    refine: RefineReport
    retime: RetimeReport
    clearance_penalty: float = 0.0
    objective_cost: float | None = None

    @property
    def cost(self) -> float:
        """Cost by which candidates are compared: of the objective, or duration plus penalty [s]."""
        if self.objective_cost is not None:
            return self.objective_cost
        return self.trajectory.duration + self.clearance_penalty


@dataclass(frozen=True)
class CandidateTiming:
    """Inputs of the timing of every curve along one path, and the failures so far.

    Attributes:
        world: The scene, loaded.
        group: The group that moves.
        path_limits: Limits other than those of joints.
        options: Options of the timing.
        refine: Options of the refinement, for its objective.
        watch: Times the work.
        deadline: Time limit.
        longest: Time that the request leaves for the motion, besides the objective's bound [s];
            None for no such limit.
        failures: Why curves were not timed, in order.
    """

    world: World
    group: JointGroup
    path_limits: tuple[PathLimit, ...]
    options: RetimeOptions
    refine: RefineOptions
    watch: Stopwatch
    deadline: Deadline
    longest: float | None = None
    failures: list[RetimingFailed] = field(default_factory=list[RetimingFailed])

    @property
    def for_comparison(self) -> "CandidateTiming":
        """The same inputs with less time, for curves that may only improve on a timed motion."""
        return replace(self, deadline=self.deadline.at_fraction(_COMPARISON_TIME_FRACTION))

    def refined(
        self, curve: JointSpline | TimedTrajectory | None, report: RefineReport
    ) -> list[CandidateMotion]:
        """Return the candidate along a refined curve; with its own time where that is admissible.

        If it cannot be timed, the failure is stored and there is none.
        """
        if curve is None:
            return []
        if not isinstance(curve, TimedTrajectory):
            return self._retimed(REFINED_CURVE, curve, report)
        spline = _geometry(curve)
        with self.watch.stage("retime"):
            try:
                kept = keep_timing(
                    curve, self._limits, self.options, self.path_limits, self.deadline
                )
            except RetimingFailed as failure:
                self.failures.append(failure)
                return []
        if kept is None:
            return self._retimed(REFINED_CURVE, spline, report)
        return [CandidateMotion(REFINED_CURVE, spline, kept[0], report, kept[1])]

    def is_certainly_slower(self, curve: PathCurve, motion: CandidateMotion) -> bool:
        """Return whether a curve along the path costs more than a motion, however it is timed.

        Never where the cost is not the duration alone, where the motion along the path is reported,
        and where a duration is requested.
        """
        refine = self.refine
        if refine.reports_objectives or refine.clearance is not None or self.options.duration:
            return False
        with self.watch.stage("retime"):
            bound = path_duration_bound(curve.spline, self._limits, self.options)
        return bound > motion.trajectory.duration

    def along_path(self, curve: PathCurve, report: RefineReport) -> list[CandidateMotion]:
        """Return the candidate along a curve near the path, or none and store the failure."""
        return self._retimed(curve.name, curve.spline, report, curve.deviation)

    def values(self, candidates: list[CandidateMotion]) -> ObjectiveValues | None:
        """Return the objectives of the first candidate, if they are to be reported."""
        if not self.refine.reports_objectives or not candidates:
            return None
        return self._objectives(candidates[0]).values()

    def weighed(
        self, candidates: list[CandidateMotion], before: ObjectiveValues | None
    ) -> list[CandidateMotion]:
        """Return candidates with their cost by the objective, each slowed to where that is least.

        Candidates that take longer than the objective permits are left out, and stored as failures.

        Args:
            candidates: Timed motions.
            before: Objectives of the motion along the path, for the report.
        """
        if not self.refine.reports_objectives:
            return candidates
        objective = self.refine.objective or QUICKEST
        found: list[CandidateMotion] = []
        for candidate in candidates:
            measured = self._objectives(candidate)
            longest = objective.max_duration
            if longest is not None and measured.duration > longest * (1 + _DURATION_TOLERANCE):
                self.failures.append(_too_slow(measured.duration, longest))
                continue
            # A slower motion may break a constraint of a term, on its duration say.
            keeps_time = self.options.duration is not None or bool(self.refine.terms)
            slowdown = 1.0 if keeps_time else measured.best_slowdown
            duration = slowdown * measured.duration
            slowed = candidate if slowdown == 1 else self._slowed(candidate, duration)
            # Where it could not be slowed, a limit on torques say, it is as it was.
            after = measured.values(slowed.trajectory.duration / measured.duration)
            report = replace(candidate.refine, before=before, after=after)
            found.append(replace(slowed, refine=report, objective_cost=after.cost(objective)))
        return found

    @property
    def failure(self) -> RetimingFailed:
        """Failure of all curves; the last one is that of the path itself.

        If that is only slower than requested, because of its rests at corners, it is the failure of
        the curve with the least duration.
        """
        last = self.failures[-1]
        if "least" not in last.evidence:
            message = f"the path cannot be timed, even with a rest at every corner: {last.detail}"
            return RetimingFailed(message, last.evidence)
        too_slow = [failure for failure in self.failures if "least" in failure.evidence]
        quickest = min(too_slow, key=lambda failure: failure.evidence["least"])
        message = f"no curve along the path can be timed as requested: {quickest.detail}"
        return RetimingFailed(message, quickest.evidence)

    def _retimed(
        self, name: str, spline: JointSpline, report: RefineReport, deviation: float = 0.0
    ) -> list[CandidateMotion]:
        with self.watch.stage("retime"):
            try:
                trajectory, retime_report = retime(
                    spline, self._limits, self.options, self.path_limits, self.deadline
                )
            except RetimingFailed as failure:
                self.failures.append(failure)
                return []
        if deviation:
            retime_report = replace(retime_report, blend_deviation=deviation)
        return [CandidateMotion(name, spline, trajectory, report, retime_report)]

    def _slowed(self, candidate: CandidateMotion, duration: float) -> CandidateMotion:
        """Return a candidate that takes longer, with the utilization of limits that it has then."""
        options = replace(self.options, duration=duration)
        kept = keep_timing(
            candidate.trajectory, self._limits, options, self.path_limits, self.deadline
        )
        if kept is None:
            return candidate
        before = candidate.retime
        report = replace(
            kept[1],
            slowed=before.slowed,
            stops=before.stops,
            blend_deviation=before.blend_deviation,
        )
        return replace(candidate, trajectory=kept[0], retime=report)

    def _objectives(self, candidate: CandidateMotion) -> MotionObjectives:
        objective = self.refine.objective
        return MotionObjectives.of(
            self.world,
            self.group,
            candidate.trajectory,
            objective and objective.within(self.longest),
            self.options.payload,
        )

    @property
    def _limits(self) -> JointLimits:
        return self.world.limits(self.group)


def _geometry(trajectory: TimedTrajectory) -> JointSpline:
    """Return the curve of a motion, over s = t / T."""
    unit = trajectory.time_scaled(1 / trajectory.duration)
    breaks = unit.breaks.copy()
    breaks[-1] = 1.0
    return JointSpline(unit.joints, breaks, unit.bases, unit.coefficients)


def _too_slow(duration: float, longest: float) -> RetimingFailed:
    message = (
        f"refine.objective.max_duration of {longest:.4g} s is shorter than the {duration:.4g} s "
        "of the motion within the limits"
    )
    return RetimingFailed(message, {"max_duration": longest, "least": duration})
