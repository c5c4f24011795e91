"""PlanRequest: what to plan."""

from typing import Annotated, Any, Literal, Self

from pydantic import ConfigDict, Field, Strict, model_validator

from planning.domain.request import options as domain
from planning.domain.request.problem import PlanningProblem
from service.api.arrays import vector
from service.api.fingerprint import ADDED
from service.api.models import (
    GROUP,
    PRIORITY,
    WHOLE,
    Boolean,
    GroupName,
    GroupPositions,
    Identifier,
    NonNegative,
    Real,
    RequestModel,
)
from service.jobs.job import Priority
from service.plans.models.constraints import Constraint, constraints_to_domain
from service.plans.models.goals import Goal
from service.plans.models.ik import Ik
from service.plans.models.line_goals import LineGoal, PathGoal
from service.plans.models.motion_limits import ScaledLimits
from service.plans.models.refine import Refine
from service.plans.models.sampling import Sampling
from service.plans.models.search import Search

EXAMPLE: dict[str, Any] = {
    "scene": "scn_3f0c5b1e9a7d4c62",
    "group": "arm",
    "start": None,
    "goal": {
        "type": "pose",
        "poses": [{"position": [0.4, 0.2, 0.3], "quaternion": [0, 1, 0, 0]}],
        "frame": "arm::tool0",
    },
    "search": {"planner": "RRTConnect", "allowed_planning_time": 5.0},
    "retime": {"method": "toppra", "velocity_scale": 0.5},
    "seed": 7,
}


class Retime(Sampling, ScaledLimits):
    """Options for timing the path."""

    method: Literal["toppra", "ruckig"] = Field(
        default="toppra",
        description="Method of timing: toppra keeps velocity and acceleration limits; "
        "ruckig keeps jerk limits too",
    )
    duration: Annotated[Real, Field(gt=0, le=86_400)] | None = Field(
        default=None,
        description="Duration of the motion [s]; null for the least that the limits "
        "allow, and less than that is `retiming_failed`",
    )
    deviation: Annotated[NonNegative, Field(le=10)] | None = Field(
        default=None,
        description="Largest distance by which corners of the path may be rounded [rad or "
        "m, joint-space length]; 0 to follow the very path with a rest at "
        "every corner, null for at most 0.1. Refined paths have no corners",
    )
    explain: Boolean = Field(
        default=False,
        description="Whether to report which limit binds when, and what relaxing it would "
        "save (`stages.retime.explanation`), once the motion is proven and if "
        "there is time. It takes about 20 ms for each part; with ruckig as "
        "long as timing it once more for each limit that binds, six at most",
    )

    def to_domain(self) -> domain.RetimeOptions:
        """Return the domain's options of the timing."""
        return domain.RetimeOptions(
            method=self.method,
            sample_period=self.sampling.period,
            duration=self.duration,
            deviation=self.deviation,
            explain=self.explain,
            **self.limit_fields(),
        )


class Certify(RequestModel):
    """Computations on the motion once it is proven; the report on `certify` has their results."""

    stop_anywhere: Boolean = Field(
        default=False,
        description="Whether to bound the longest stop along the path, from any instant: "
        "a check `stop`, and `stop` in the report. It takes about 0.1 s, 0.5 "
        "s with jerk limits, and as much again with `effort` or accelerations "
        "in `tool_limits`",
    )
    max_stopping_time: Annotated[Real, Field(gt=0, le=86_400)] | None = Field(
        default=None,
        description="Longest time that a stop may take [s]; it implies `stop_anywhere`; "
        "null for no bound",
    )
    robustness: Boolean = Field(
        default=False,
        description="Whether to bound how far off obstacles and joints may be: "
        "`robustness` in the report; takes about 0.2 s",
    )

    def to_domain(self) -> domain.CertifyOptions:
        """Return the domain's options of the proof."""
        return domain.CertifyOptions(self.stop_anywhere, self.max_stopping_time, self.robustness)


class PlanRequest(RequestModel):
    """Move a group of a scene from a start to a goal."""

    model_config = ConfigDict(json_schema_extra={"examples": [EXAMPLE]})

    scene: Identifier = Field(description="Id of a scene")
    revision: Annotated[int, Strict(), Field(ge=1), WHOLE] | None = Field(
        default=None, description="Revision of the scene; null for its latest"
    )
    group: GroupName = Field(description=GROUP)
    start: GroupPositions | None = Field(
        default=None,
        description="The group's positions [rad or m]; null for the scene's current state",
    )
    goal: Goal = Field(description="Goal of the motion")
    path_constraints: Annotated[list[Constraint], Field(max_length=64)] = Field(
        default=[],
        description="Constraints that the whole motion shall keep, all of them; each has "
        "a check of its own in the certificate",
    )
    ik: Ik = Field(default_factory=Ik, description="Options of the goals stage")
    search: Search = Field(default_factory=Search, description="Options of the search")
    refine: Refine = Field(default_factory=Refine, description="Options of the refinement")
    retime: Retime = Field(default_factory=Retime, description="Options of the timing")
    certify: Certify = Field(default_factory=Certify, description="Computations besides the proof")
    margin: Annotated[NonNegative, Field(le=10)] | None = Field(
        default=None, description="Distance that everything keeps [m]; null for the scene's"
    )
    seed: Annotated[int, Strict(), Field(ge=0, le=2**32 - 1), WHOLE] = Field(
        default=0, description="Seed of all randomness: the same seed gives the same bytes"
    )
    priority: Annotated[Priority, ADDED] = Field(default=Priority.NORMAL, description=PRIORITY)

    @model_validator(mode="after")
    def _know_no_lines_in_roadmaps(self) -> Self:
        if self.search.roadmap is not None and isinstance(self.goal, LineGoal | PathGoal):
            message = "search.roadmap: goals `line` and `path` are not searched for; leave it out"
            raise ValueError(message)
        return self

    @model_validator(mode="after")
    def _can_be_optimized(self) -> Self:
        if self.refine.objective is not None:
            objective = self.refine.objective.to_domain()
            fault = objective.fault_beside(self.goal.to_domain(), self.retime.duration)
            if fault:
                message = f"refine.objective: {fault}"
                raise ValueError(message)
        return self

    def to_domain(self) -> PlanningProblem:
        """Return the domain's problem; every field is in it but for scene and priority."""
        return PlanningProblem(
            group=self.group,
            goal=self.goal.to_domain(),
            start=None if self.start is None else vector(self.start),
            ik=self.ik.to_domain(),
            search=self.search.to_domain(),
            refine=self.refine.to_domain(),
            retime=self.retime.to_domain(),
            margin=self.margin,
            seed=self.seed,
            constraints=constraints_to_domain(self.path_constraints),
            certify=self.certify.to_domain(),
        )
