"""Job: a plan that was asked for, and how far it is."""

from datetime import datetime
from enum import StrEnum

from pydantic import Field

from service.api.models import UNRECORDED, Failure, ResponseModel
from service.plans.models.request import PlanRequest
from service.plans.models.result import PlanResult


class JobState(StrEnum):
    """States of a job; the last three are final."""

    QUEUED = "queued"
    RUNNING = "running"
    SUCCEEDED = "succeeded"
    FAILED = "failed"
    CANCELED = "canceled"


class JobBrief(ResponseModel):
    """A plan without its result."""

    id: str = Field(description="Of the plan")
    state: JobState = Field(description="Where it stands; succeeded, failed, canceled are final")
    stage: str = Field(description="The stage that it is in or ended in, or empty")
    progress: float = Field(description="Of the whole plan, 0 to 1", ge=0, le=1)
    created_at: datetime = Field(description="When it was asked for (UTC)")
    started_at: datetime | None = Field(description="When a worker took it (UTC)")
    finished_at: datetime | None = Field(description="When it ended (UTC)")
    request: PlanRequest = Field(
        description="What was asked for, defaults filled in, and the scene's latest `revision` and "
        "the newest `search.regions` where they were left open: asked again, it gives the same plan"
    )
    failure: Failure | None = Field(description="Why there is no result")
    seed: int = Field(description="Of all randomness")
    digest: str | None = Field(description="sha256 over the delivered numbers")
    versions: dict[str, str] = Field(
        description="Of everything that the numbers depend on, in the server that ran it last; "
        "empty before it runs, and for plans of versions that did not keep it"
    )
    timings: dict[str, float] = Field(
        description="Seconds per stage, once it has ended; of a failure those of `failure` [s]"
    )
    unrecorded: list[str] = Field(description=UNRECORDED)


class Job(JobBrief):
    """A plan that was asked for; poll it until its state is final."""

    result: PlanResult | None = Field(description="What it gave, once it succeeded")


class JobPage(ResponseModel):
    """Plans, newest first."""

    items: list[JobBrief] = Field(description="On this page, without their results")
    next: str | None = Field(description="Cursor of the next page; null on the last one")
