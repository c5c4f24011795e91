"""Request and answer about when the motions of several plans begin."""

from typing import Annotated, Any, Self

from pydantic import ConfigDict, Field, Strict

from planning.domain.report import motion_schedule as domain
from service.api.failures.failure import Failure
from service.api.models import (
    WHOLE,
    Boolean,
    Identifier,
    NonNegative,
    Real,
    RequestModel,
    ResponseModel,
)
from service.plans.models.reports import CertifyReport
from service.plans.models.result import Certificate
from service.plans.models.trajectory import Polynomial

_EXAMPLE: dict[str, Any] = {
    "scene": "scn_3f0c5b1e9a7d4c62",
    "plans": ["job_1f0e8a52c7b94d36", "job_92ab3c44de5f4a10"],
}


class ScheduleMotionsRequest(RequestModel):
    """Find when to begin the motions of several plans, so that all of them together are proven."""

    model_config = ConfigDict(json_schema_extra={"examples": [_EXAMPLE]})

    scene: Identifier = Field(description="Id of the scene that all the plans are of")
    revision: Annotated[int, Strict(), Field(ge=1), WHOLE] | None = Field(
        default=None, description="Revision of the scene; null for its latest"
    )
    plans: Annotated[list[Identifier], Field(min_length=1, max_length=16)] = Field(
        description="Ids of plans of groups without a common joint, the most urgent first: the "
        "first one waits least"
    )
    margin: Annotated[NonNegative, Field(le=10)] | None = Field(
        default=None, description="Distance that everything keeps [m]; null for the scene's"
    )
    limit_jerk: Boolean = Field(
        default=False, description="Whether to check the whole against the limits on jerk as well"
    )
    polynomial: Boolean = Field(
        default=False,
        description="Whether to add all motions as one, as an exact piecewise polynomial",
    )
    allowed_time: Annotated[Real, Field(gt=0, le=60)] = Field(
        default=10.0, description="Time after which to give up [s]"
    )


class Wait(ResponseModel):
    """Who waits for whom, and why."""

    group: str = Field(description="Group of the motion that waits")
    for_group: str = Field(
        description="Group of the motion that it waits for: begun earlier, it would meet this one"
    )
    delay: float = Field(description="Time that it waits, from the beginning of the schedule [s]")
    pair: list[str] = Field(description="The two bodies that would be nearer than their margin")
    time: float = Field(
        description="Time on the schedule at which they would, if it began a little earlier [s]"
    )


class MotionSchedule(ResponseModel):
    """Time at which each motion begins, and the proof of all together."""

    group: str = Field(description="Group that spans all the plans' groups")
    groups: list[str] = Field(description="Group of each plan, in their order")
    delays: list[float] = Field(
        description="Time at which each motion begins, in the order of the plans [s]: the "
        "first is as small as it can be, then the second, and so on"
    )
    waits: list[Wait] = Field(description="Each motion that waits, in the order of the plans")
    duration: float = Field(
        description="Time from the beginning of the first motion to the end of the last [s]"
    )
    certificate: Certificate = Field(description="The proof of all motions as one")
    stage: CertifyReport = Field(description="Report of the proof")
    polynomial: Polynomial | None = Field(
        default=None, description="All motions as one, if the request wants it"
    )

    @classmethod
    def from_domain(cls, schedule: domain.MotionSchedule, *, polynomial: bool) -> Self:
        """Return the model of a schedule."""
        motion = schedule.motion
        return cls(
            group=motion.group,
            groups=list(schedule.groups),
            delays=list(schedule.delays),
            waits=[Wait.model_validate(wait) for wait in schedule.waits],
            duration=schedule.duration,
            certificate=Certificate.from_domain(schedule.certificate),
            stage=CertifyReport.model_validate(schedule.report),
            polynomial=Polynomial.from_domain(motion.trajectory) if polynomial else None,
        )


class ScheduleMotionsResponse(ResponseModel):
    """A proven schedule, or why there is none."""

    schedule: MotionSchedule | None = Field(description="The schedule; null if there is none")
    failure: Failure | None = Field(
        description="Reason why there is none: `schedule_not_found` with the pair that "
        "meets, `not_certified` with the failed checks, `deadline_exceeded`; "
        "null if there is one"
    )
