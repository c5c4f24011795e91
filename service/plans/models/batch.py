"""Batch: problems that are asked for in one request, each of which is a plan of its own."""

from datetime import datetime
from typing import Annotated

from pydantic import ConfigDict, Field

from service.api.models import RequestModel, ResponseModel
from service.plans.models.request import EXAMPLE, PlanRequest

MOST_PROBLEMS = 256


class BatchRequest(RequestModel):
    """Problems to plan, all of which are queued, or none."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"problems": [EXAMPLE, {**EXAMPLE, "seed": 8}]}]}
    )

    problems: Annotated[list[PlanRequest], Field(min_length=1, max_length=MOST_PROBLEMS)] = Field(
        description="Each as `POST /v1/plans` takes it"
    )


class BatchCounts(ResponseModel):
    """Number of plans of a batch in each state."""

    queued: int = Field(default=0, description="Plans that wait")
    running: int = Field(default=0, description="Plans that a worker has")
    succeeded: int = Field(default=0, description="Plans with a result")
    failed: int = Field(default=0, description="Plans with a failure")
    canceled: int = Field(default=0, description="Plans whose end was requested")


class BatchSummary(ResponseModel):
    """A batch without the ids of its plans. Deleted plans are no part of it any more."""

    id: str = Field(description="Id of the batch")
    counts: BatchCounts = Field(description="Plans by state")
    created_at: datetime = Field(description="Time of the request (UTC)")
    finished_at: datetime | None = Field(
        description="Time at which the last plan ended (UTC); null while one waits or runs"
    )


class Batch(BatchSummary):
    """A batch; poll it until `finished_at` is there. Deleted plans are no part of it any more."""

    plans: list[str] = Field(
        description="Ids of the plans, in the order of the problems; `GET /v1/plans?batch=` lists "
        "them, newest first"
    )


class BatchPage(ResponseModel):
    """Batches, newest first."""

    items: list[BatchSummary] = Field(
        description="Batches on this page, without the ids of their plans"
    )
    next: str | None = Field(description="Cursor of the next page; null on the last one")
