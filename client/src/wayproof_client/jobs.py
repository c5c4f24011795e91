"""Jobs: plans, executions, regions and batches, which are waited for alike."""

from typing import Any

from wayproof_client import models
from wayproof_client.errors import JobFailed

# What is asked for a job by its class, and what its operations are called after.
_NAMES = {
    models.Plan: "plan",
    models.Execution: "execution",
    models.RegionsJob: "regions",
    models.Batch: "batch",
}


def name_of(job: Any) -> str:
    """Return what the operations of a job are called after.

    Raises:
        TypeError: It is no job.
    """
    for kind, name in _NAMES.items():
        if isinstance(job, kind):
            return name
    known = ", ".join(kind.__name__ for kind in _NAMES)
    message = f"{type(job).__name__} is no job; jobs: {known}"
    raise TypeError(message)


def has_ended(job: Any) -> bool:
    """Return whether a job will not change any more."""
    return job.finished_at is not None


def require_success(job: Any) -> None:
    """Refuse a job that ended without a result; what became of a batch, its counts say.

    Raises:
        JobFailed: It is one.
    """
    if not isinstance(job, models.Batch) and job.state != "succeeded":
        raise JobFailed(job)
