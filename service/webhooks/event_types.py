"""Types of messages: a kind of job, and what happened to it."""

from enum import StrEnum

# By the prefix of a job's id.
KINDS = {"pln": "plan", "reg": "regions", "exe": "execution"}


class WebhookEvent(StrEnum):
    """Event that a webhook can be told."""

    PLAN_STARTED = "plan.started"
    PLAN_REQUEUED = "plan.requeued"
    PLAN_FINISHED = "plan.finished"
    REGIONS_STARTED = "regions.started"
    REGIONS_REQUEUED = "regions.requeued"
    REGIONS_FINISHED = "regions.finished"
    EXECUTION_STARTED = "execution.started"
    EXECUTION_FINISHED = "execution.finished"


def type_of(job: str, event_type: str) -> str:
    """Return the type of the message of an event of a job, "" for a job that has none."""
    kind = KINDS.get(job.partition("_")[0])
    return "" if kind is None else f"{kind}.{event_type}"
