"""Plan: a requested motion, how far its job is, and what it gave."""

from datetime import datetime

from pydantic import Field

from service.api.document.open_enums import AnyStage
from service.api.failures.failure import Failure
from service.api.models import (
    ATTEMPTS,
    CANCEL_REQUESTED_AT,
    UNRECORDED,
    ResponseModel,
    Timings,
    Versions,
)
from service.jobs.states import JobState
from service.plans.models.request import PlanRequest
from service.plans.models.result import PlanResult


class BestPath(ResponseModel):
    """The best path that a search has found so far."""

    length: float = Field(description="Weighted length of the path")
    seconds: float | None = Field(
        default=None,
        description="Time at which it was found, since the worker began with the plan [s]",
    )
    waypoints: list[list[float]] | None = Field(
        default=None,
        description="Configurations along the path from the start to a goal, at most 64 of its "
        "waypoints; to look at, not to move along: nothing is proven of it, and a path that is "
        "still improved is checked coarsely. Null where the planner tells the length only",
    )


class PlanSummary(ResponseModel):
    """A plan without its result."""

    id: str = Field(description="Id of the plan")
    batch: str | None = Field(description="Id of its batch; null for none")
    state: JobState = Field(description="State of the plan; succeeded, failed, canceled are final")
    stage: AnyStage = Field(description="The stage that it is in or ended in, or empty")
    progress: float = Field(
        description="Share of the whole plan, 0 to 1; within a stage it grows with the "
        "used share of the allowed time. A plan that failed or was canceled "
        "keeps the share that it reached",
        ge=0,
        le=1,
    )
    best: BestPath | None = Field(
        default=None,
        description="The best path of the search so far, while the plan runs; null before one is "
        "found, and once the plan has ended",
    )
    created_at: datetime = Field(description="Time of the request (UTC)")
    started_at: datetime | None = Field(description="Time at which a worker took it (UTC)")
    finished_at: datetime | None = Field(description="Time at which it ended (UTC)")
    cancel_requested_at: datetime | None = Field(description=CANCEL_REQUESTED_AT)
    attempts: int = Field(description=ATTEMPTS)
    request: PlanRequest = Field(
        description="The request with its defaults, and the scene's latest `revision` and "
        "the newest `search.regions` where they were left open. Posted again, "
        "it gives the same plan"
    )
    failure: Failure | None = Field(description="Reason why there is no result")
    seed: int = Field(description="Seed of all randomness")
    digest: str | None = Field(description="sha256 over the delivered numbers")
    versions: Versions = Field(
        description="Versions of everything that the numbers depend on, in the server that ran it "
        "last; empty before it runs, and for plans of versions that did not keep it"
    )
    timings: Timings = Field(
        description="Seconds per stage, once it has ended; of a failure those of `failure` [s]"
    )
    unrecorded: list[str] = Field(description=UNRECORDED)


class Plan(PlanSummary):
    """A plan; poll it until its state is final."""

    result: PlanResult | None = Field(description="Result of the plan, once it succeeded")


class PlanPage(ResponseModel):
    """Plans, newest first."""

    items: list[PlanSummary] = Field(description="Plans on this page, without their results")
    next: str | None = Field(description="Cursor of the next page; null on the last one")
