"""Submission: what a request for a job says in its headers, and how it is answered."""

from dataclasses import dataclass
from typing import Annotated, Any

from fastapi import Depends, Response

from service.dependencies import JobsDep, SettingsDep
from service.jobs.job import Job, JobText
from service.routes.answers import problems
from service.routes.waiting import IdempotencyKey, Prefer, Wait, seconds_to_wait
from service.scene_jobs import SceneJobs
from service.schemas.wire import Answer


@dataclass(frozen=True)
class Submission:
    """How a client asks for a job.

    Attributes:
        desk: Where jobs are asked for.
        key: The idempotency key, or None.
        response: Status and headers of the answer.
    """

    desk: SceneJobs
    key: str | None
    response: Response
    _seconds: float

    async def awaited(self, job: Job, path: str) -> JobText:
        """Return a job when it has ended, or as it is after the time that the client waits.

        Args:
            job: As it was taken in.
            path: Of the resources of its kind; the answer says where to poll.
        """
        found = await self.desk.wait(job, self._seconds)
        self.response.headers["Location"] = f"{path}/{job.id}"
        if found.summary.state.is_final:
            self.response.status_code = 200
        return found


async def _submission(
    response: Response,
    desk: JobsDep,
    settings: SettingsDep,
    *,
    wait: Wait = None,
    prefer: Prefer = None,
    idempotency_key: IdempotencyKey = None,
) -> Submission:
    seconds = seconds_to_wait(wait, prefer, settings.max_wait)
    return Submission(desk, idempotency_key, response, seconds)


type SubmissionDep = Annotated[Submission, Depends(_submission)]


def taken_in(model: type[Answer], what: str, *refusals: int) -> dict[int | str, dict[str, Any]]:
    """Return the declaration of what a request for a job is answered with.

    Args:
        model: Of the job.
        what: It is, as words.
        refusals: Statuses of problem documents.
    """
    location = {"description": f"Of {what}", "schema": {"type": "string"}}
    return {
        200: {"model": model, "description": "Ended within the time that was waited"},
        202: {
            "description": "Accepted; `Location` says where to poll",
            "headers": {"Location": location},
        },
        **problems(*refusals),
    }
