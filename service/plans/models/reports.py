"""What every stage of a plan says about its work."""

from typing import Annotated, Literal, Self

from pydantic import Field

from planning.domain.goals.funnel import funnel_evidence
from planning.domain.report.motion_plan import StageReports
from service.api.document.known_values import RefineSolver
from service.api.document.open_enums import OneOf
from service.api.models import ResponseModel
from service.plans.models.ik import IkFunnel
from service.plans.models.search_reports import SearchReport


class GoalsReport(ResponseModel):
    """Report of the goals stage."""

    num_configurations: int = Field(
        description="Number of goal configurations that were offered to search"
    )
    funnel: IkFunnel = Field(description="Number of samples that passed each test")


class ObjectiveValues(ResponseModel):
    """Costs of one motion by each objective."""

    duration: float = Field(description="Duration of the motion [s]")
    smoothness: float | None = Field(
        description="Integral over time of squared accelerations [rad^2/s^3], or of jerks if the "
        "objective says so [rad^2/s^5]; null where accelerations jump, so that jerks are infinite"
    )
    energy: float | None = Field(
        description="Integral over time of squared torques and forces [N^2 m^2 s]; null for groups "
        "with a floating joint"
    )
    path_length: float = Field(description="Joint-space length [rad or m]")


class RefineReport(ResponseModel):
    """Report of the refine stage."""

    method: Literal["trajopt", "drake", "auto", "none"] = Field(
        description="Method that was requested"
    )
    improved: bool = Field(description="Whether the refined curve is what was delivered")
    reason: str = Field(description="Reason why it was not delivered, or empty")
    solver: RefineSolver = Field(description="Name of the solver, or empty")
    rounds: int = Field(
        description="Number of steps tried, each a convex program; of `drake` nonlinear programs"
    )
    length_before: float = Field(description="Length of the path [rad or m]")
    length_after: float = Field(description="Length of the refined curve [rad or m]")
    duration_before: float = Field(description="Estimate for the initial guess [s]")
    duration_after: float = Field(description="Estimate for the solution [s]")
    lower_bound: float = Field(
        description="Time that the slowest joint alone takes from start to goal [s]; "
        "nothing is quicker"
    )
    shortfall: float | None = Field(
        default=None,
        description="Shortfall of the clearance from the preferred one, on average over "
        "the motion [m]; null if none was preferred or nothing was refined",
    )
    before: ObjectiveValues | None = Field(
        default=None,
        description="Objectives of the motion along the path as the search left it, as "
        "quick as the limits allow; null unless the request states an "
        "objective or the method is `drake`",
    )
    after: ObjectiveValues | None = Field(
        default=None, description="Objectives of the motion that is delivered; null as for `before`"
    )


LIMITS = (
    "velocity",
    "acceleration",
    "jerk",
    "torque",
    "tool_speed",
    "tool_acceleration",
    "speed_zone",
    "acceleration_bounds",
)
Limit = Annotated[str, OneOf("Limit", "Limits on a motion.", LIMITS)]
AnyLimit = Annotated[
    str,
    OneOf("AnyLimit", "Limit that keeps a motion from being quicker.", (*LIMITS, "duration", "")),
]


class BindingInterval(ResponseModel):
    """Interval of the motion, with the limit that keeps it from being quicker."""

    begin: float = Field(description="First instant [s]")
    end: float = Field(description="Last instant [s]")
    limit: AnyLimit = Field(
        description="Limit that is used the most: velocity, acceleration, jerk, torque, "
        "tool_speed, tool_acceleration, speed_zone or acceleration_bounds. It "
        "is `duration` where the request asks for a longer motion than it "
        "must be, and empty while nothing moves"
    )
    where: str = Field(description="The joint, block, frame or zone whose limit it is, or empty")
    share: float = Field(
        description="Largest share of the limit that is used, 0 to 1; 1 where it is met [1]"
    )


class Saving(ResponseModel):
    """Time that the motion would save with one limit relaxed."""

    limit: Limit = Field(description="Name of the limit, as in the intervals")
    where: str = Field(description="The joint, block, frame or zone whose limit it is")
    seconds: float = Field(description="Time that is saved [s]")


class DurationExplanation(ResponseModel):
    """Why the motion takes as long as it does."""

    intervals: list[BindingInterval] = Field(
        description="Intervals with the limit that binds in each; together they cover the motion"
    )
    relaxed: float = Field(description="The factor by which limits were relaxed, one at a time")
    savings: list[Saving] = Field(
        description="Time that this saved, the most first; measured for limits that are met"
    )


class RetimeReport(ResponseModel):
    """Report of the retime stage."""

    method: Literal["toppra", "ruckig"] = Field(description="Method that was requested")
    duration: float = Field(description="Duration of the trajectory [s]")
    slowed: float = Field(description="Factor by which the audit stretched it [1]; 1 is not at all")
    binding: dict[str, str] = Field(description="Name of what is nearest its bound, per limit")
    utilisation: dict[str, float] = Field(description="Peak over limit, per limit [1]")
    stops: int = Field(description="Instants of rest between start and goal")
    blend_deviation: float = Field(
        description="Distance by which corners were rounded, or by which the smoothed "
        "curve may be off the path [rad or m]"
    )
    explanation: DurationExplanation | None = Field(
        default=None,
        description="Explanation of the duration; null if not requested, or no time was left",
    )


class StopReport(ResponseModel):
    """Stops along the path within limits, from every instant: guaranteed upper bounds."""

    time: float = Field(description="Duration of the longest stop [s]")
    begin: float = Field(description="Time at which it begins [s]")
    distance: float = Field(description="Longest way of a joint until it stands [rad or m]")
    joint: str = Field(description="Name of that joint, or block of a planar or floating one")
    tool_distance: float | None = Field(
        description="Longest way of the tool frame until it stands [m]; null without a tool frame"
    )
    frame: str = Field(description="The tool frame, or empty")
    unheld: str = Field(
        default="",
        description="With `effort`: `torque` and the joint that cannot hold the robot still "
        "somewhere, so that no stop ends there; empty if there is none",
    )
    unheld_at: float | None = Field(
        default=None,
        description="Time along the motion at which that is worst [s]; null for nowhere",
    )


class Robustness(ResponseModel):
    """Errors that the proof of clearance survives: guaranteed lower bounds, each by itself."""

    obstacle_displacement: float = Field(
        description="Distance that all points of all obstacles may have from where the scene has "
        "them, at most 1 [m]"
    )
    obstacle_pair: tuple[str, str] = Field(description="The two bodies that allow no more")
    obstacle_time: float = Field(description="Time at which these two allow no more [s]")
    joint_error: float = Field(
        description="Error that every joint may have at once, at most 0.5 [rad or m]"
    )
    joint_pair: tuple[str, str] = Field(description="The two bodies that allow no more")
    joint_time: float = Field(description="Time at which these two allow no more [s]")


class CertifyReport(ResponseModel):
    """Report of the certify stage."""

    intervals: int = Field(description="Intervals on which clearance was bounded")
    distance_queries: int = Field(description="Configurations at which distances were measured")
    candidates: int = Field(description="Candidate motions that were looked at")
    refused: list[str] = Field(description="Faults of the candidates before the delivered one")
    stop: StopReport | None = Field(
        default=None,
        description="Bounds on stops along the path; null if not requested, or no time was left",
    )
    robustness: Robustness | None = Field(
        default=None,
        description="Bounds on how far off obstacles and joints may be; null if not "
        "requested, or no time was left",
    )


class Stages(ResponseModel):
    """One report per stage."""

    goals: GoalsReport = Field(description="Report of the goal configurations")
    search: SearchReport = Field(description="Report of the search")
    refine: RefineReport = Field(description="Report of the optimisation")
    retime: RetimeReport = Field(description="Report of the timing")
    certify: CertifyReport = Field(description="Report of the proof")

    @classmethod
    def from_domain(cls, stages: StageReports) -> Self:
        """Return the reports of all stages."""
        return cls.model_validate({
            "goals": {
                "num_configurations": len(stages.goals.positions),
                "funnel": funnel_evidence(stages.goals.funnel),
            },
            "search": stages.search,
            "refine": stages.refine,
            "retime": stages.retime,
            "certify": stages.certify,
        })
