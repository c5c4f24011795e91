"""Submission: what a request for a job says besides its body, and how it is answered.

`?wait=S` or `Prefer: wait=S` (RFC 7240) say how long the client waits for the end of the job.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

from fastapi import Depends, Header, Query, Request, Response

from service.api.dependencies import jobs_of, settings_of
from service.jobs.job import Job, JobText
from service.jobs.service import JobService
from service.settings import Settings

_PREFERENCE = re.compile(r"(?:^|[,;\s])wait\s*=\s*\"?(\d{1,6}(?:\.\d{1,6})?)")

type Wait = Annotated[
    float | None,
    Query(
        ge=0,
        le=3600,
        allow_inf_nan=False,
        description="Longest time to wait for the job [s]; the answer is 200 with the "
        "finished job if it ends by then",
    ),
]
type Prefer = Annotated[
    str | None,
    Header(max_length=200, description="`wait=S` does what `?wait=S` does (RFC 7240)"),
]
type KeyHeader = Annotated[
    str | None,
    Header(
        alias="Idempotency-Key",
        min_length=1,
        max_length=200,
        description="The same key and request give the same resource, however often they are sent",
    ),
]


@dataclass(frozen=True)
class Submission:
    """How a client asks for a job.

    Attributes:
        jobs: Where jobs are asked for.
        key: The idempotency key, or None.
        response: Status and headers of the answer.
        settings: Of the server.
    """

    jobs: JobService
    key: str | None
    response: Response
    settings: Settings
    _seconds: float

    async def awaited(self, job: Job, path: str) -> JobText:
        """Return a job when it has ended, or as it is after the time that the client waits.

        Args:
            job: As it was taken in.
            path: Of the resources of its kind; the answer says where to poll.
        """
        found = await self.jobs.wait(job, self._seconds)
        self.response.headers["Location"] = f"{path}/{job.id}"
        if found.summary.state.is_final:
            self.response.status_code = 200
        return found

    async def all_awaited(self, jobs: Sequence[str], address: str) -> None:
        """Wait until jobs have ended, for as long as the client waits; the answer says which it is.

        Args:
            jobs: Their ids.
            address: Where to poll all of them.
        """
        self.response.headers["Location"] = address
        if await self.jobs.wait_for_all(jobs, self._seconds):
            self.response.status_code = 200


async def _submission(
    request: Request,
    response: Response,
    *,
    wait: Wait = None,
    prefer: Prefer = None,
    idempotency_key: KeyHeader = None,
) -> Submission:
    return submission_of(request, response, wait, prefer, idempotency_key)


def submission_of(
    request: Request,
    response: Response,
    wait: float | None,
    prefer: str | None,
    idempotency_key: str | None,
) -> Submission:
    """Return how a client asks for a job.

    Args:
        request: Of the client.
        response: Status and headers of the answer.
        wait: Its parameter [s].
        prefer: Its header.
        idempotency_key: Its header.
    """
    settings = settings_of(request)
    seconds = seconds_to_wait(wait, prefer, settings.max_wait)
    return Submission(jobs_of(request), idempotency_key, response, settings, seconds)


type SubmissionDep = Annotated[Submission, Depends(_submission)]


def seconds_to_wait(wait: float | None, prefer: str | None, longest: float) -> float:
    """Return how long to wait [s]: the parameter, else the preference, else not at all."""
    if wait is not None:
        return min(wait, longest)
    found = _PREFERENCE.search(prefer or "")
    return min(float(found[1]), longest) if found else 0.0
