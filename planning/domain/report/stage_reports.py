"""What the stages after the search say about their work."""

from dataclasses import dataclass, field

from planning.domain.report.duration import DurationExplanation
from planning.domain.report.stop_report import StopReport
from planning.domain.request.robustness import Robustness
from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class RefineReport(Value):
    """What the refine stage did.

    Attributes:
        method: "trajopt", "auto" or "none".
        improved: Whether the refined curve is what goes on.
        reason: Why not, or "".
        solver: Name of the solver, or "".
        rounds: Steps that were tried, each the solution of a convex program.
        length_before: Joint-space length of the path.
        length_after: Joint-space length of the refined curve.
        duration_before: Optimiser's estimate for its initial guess [s].
        duration_after: Optimiser's estimate for its solution [s].
        lower_bound: No motion between the two ends takes less, whatever its way [s].
        shortfall: By how much the clearance of the motion falls short of what was wished for, on
            average over its time [m]; None if nothing was, or nothing was refined.
    """

    method: str
    improved: bool
    reason: str = ""
    solver: str = ""
    rounds: int = 0
    length_before: float = 0.0
    length_after: float = 0.0
    duration_before: float = 0.0
    duration_after: float = 0.0
    lower_bound: float = 0.0
    shortfall: float | None = None


@dataclass(frozen=True, eq=False)
class RetimeReport(Value):
    """What the retime stage did.

    Attributes:
        method: "toppra" or "ruckig".
        duration: Of the trajectory [s].
        slowed: Factor by which the audit stretched the retimer's own answer (1 is not at all).
        binding: Name of the coordinate, frame or zone that is nearest its bound, per limit kind.
        utilisation: Peak over limit, per limit kind.
        stops: Instants of rest between start and goal.
        blend_deviation: How far corners were rounded, or the curve that was smoothed may be from
            the path (joint-space length); 0 for neither.
        explanation: Why it takes that long, if that was asked for and there was time.
    """

    method: str
    duration: float
    slowed: float
    binding: dict[str, str] = field(default_factory=dict)
    utilisation: dict[str, float] = field(default_factory=dict)
    stops: int = 0
    blend_deviation: float = 0.0
    explanation: DurationExplanation | None = None


@dataclass(frozen=True, eq=False)
class CertifyReport(Value):
    """What the certify stage did.

    Attributes:
        intervals: Intervals on which clearance was bounded.
        distance_queries: Configurations at which distances were measured.
        candidates: How many candidate motions were looked at, this one included.
        refused: What was wrong with those before it, a line each.
        stop: How the motion can be stopped anywhere, if that was asked and there was time; without
            a bound on stops the motion is proven without.
        robustness: How wrong world and robot may be, if that was asked and there was time.
    """

    intervals: int
    distance_queries: int
    candidates: int = 1
    refused: tuple[str, ...] = ()
    stop: StopReport | None = None
    robustness: Robustness | None = None
