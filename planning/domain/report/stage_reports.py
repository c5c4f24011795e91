"""Reports of the refine, retime and certify stages."""

from dataclasses import dataclass, field

from planning.domain.report.duration import DurationExplanation
from planning.domain.report.objective_values import ObjectiveValues
from planning.domain.report.stop_report import StopReport
from planning.domain.request.robustness import Robustness
from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class RefineReport(Value):
    """Report of the refine stage (trajectory optimization).

    Attributes:
        method: "trajopt", "drake", "auto" or "none".
        improved: Whether the refined curve replaces the path.
        reason: Why not, or "".
        solver: Name of the solver, or "".
        rounds: Trust-region steps tried, each the solution of a convex program; of "drake" the
            number of nonlinear programs solved.
        length_before: Joint-space length of the path.
        length_after: Joint-space length of the refined curve.
        duration_before: Optimizer's estimate for its initial guess [s].
        duration_after: Optimizer's estimate for its solution [s].
        lower_bound: Lower bound on the duration of any motion between the two ends [s].
        shortfall: Mean over time of the clearance missing from the clearance objective's distance
            [m]; None without such an objective, or without refinement.
        before: Values of all objectives for the motion along the path, as quick as the limits
            allow; None unless an objective was stated or the method is "drake".
        after: The same for the motion that is delivered.
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
    before: ObjectiveValues | None = None
    after: ObjectiveValues | None = None


@dataclass(frozen=True, eq=False)
class RetimeReport(Value):
    """Report of the retime stage (time parametrization).

    Attributes:
        method: "toppra" or "ruckig".
        duration: Of the trajectory [s].
        slowed: Factor by which the audit stretched the retimer's own trajectory (1 is not at all).
        binding: Name of the coordinate, frame or zone that is nearest its bound, per limit kind.
        utilisation: Peak over limit, per limit kind.
        stops: Instants of rest between start and goal.
        blend_deviation: Largest deviation by rounding corners, or of the smoothed curve from
            the path (joint-space length); 0 for neither.
        explanation: Explanation of the duration, if it was requested and there was time.
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
    """Report of the certify stage.

    Attributes:
        intervals: Intervals on which clearance was bounded.
        distance_queries: Configurations at which distances were measured.
        candidates: Number of candidate motions examined, this one included.
        refused: Reason of rejection of each candidate before it, a line each.
        stop: Bounds on stops, if requested and there was time; the motion is proven without them as
            well.
        robustness: Tolerated obstacle displacement and joint error, if requested and there was
            time.
    """

    intervals: int
    distance_queries: int
    candidates: int = 1
    refused: tuple[str, ...] = ()
    stop: StopReport | None = None
    robustness: Robustness | None = None
