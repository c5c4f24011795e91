"""Errors: the server said no, a job has no result, or it took too long."""

from typing import Any

import httpx
from pydantic import ValidationError

from wayproof_client import models
from wayproof_client.connection import adapter

# Of an answer that no Wayproof server gave, for example by a proxy.
_NO_PROBLEM = "http_error"
_NOT_MODIFIED = 304


class ClientError(Exception):
    """What this package raises, beside errors of the transport."""


class ApiError(ClientError):
    """An answer that is a problem document.

    Attributes:
        problem: What the server said: a class for each code, with typed evidence.
        request_id: By which the server's log knows the request; empty if it said none.
        retry_after: When to ask again [s], None if the server did not say.
    """

    def __init__(
        self, problem: Any, *, request_id: str = "", retry_after: float | None = None
    ) -> None:
        super().__init__(f"{problem.status} {problem.code}: {problem.detail}")
        self.problem: models.Problem = problem
        self.request_id = request_id
        self.retry_after = retry_after

    @property
    def code(self) -> str:
        """Return the stable name of what is wrong."""
        return str(self.problem.code)


class NotModified(ClientError):
    """What `if_none_match` names is still what the server has."""


class JobFailed(ClientError):
    """A job ended without a result.

    Attributes:
        job: As the server has it.
        failure: Why: a class for each code, with typed evidence; None if no reason is known.
    """

    def __init__(self, job: models.Plan | models.Execution | models.RegionsJob) -> None:
        failure: Any = job.failure
        why = "no reason is known" if failure is None else f"{failure.code}: {failure.detail}"
        super().__init__(f"{job.id} {job.state}: {why}")
        self.job = job
        self.failure: models.Failure | None = failure

    @property
    def code(self) -> str:
        """Return the stable name of what went wrong; empty if no reason is known."""
        return "" if self.failure is None else str(self.failure.code)


class WaitTimeout(ClientError, TimeoutError):
    """A job has not ended in time; it goes on.

    Attributes:
        job: As it was seen last.
    """

    def __init__(self, job: Any, seconds: float) -> None:
        super().__init__(f"{job.id} has not ended after {seconds:g} s")
        self.job = job


def checked(response: httpx.Response) -> httpx.Response:
    """Return an answer, which has been read, if it is no error.

    Raises:
        ApiError: It is one.
        NotModified: It says that nothing has changed.
    """
    if response.status_code == _NOT_MODIFIED:
        raise NotModified(str(response.url))
    if not response.is_error:
        return response
    wait = response.headers.get("Retry-After", "")
    raise ApiError(
        _problem_of(response),
        request_id=response.headers.get("X-Request-ID", ""),
        retry_after=float(wait) if wait.isdigit() else None,
    )


def _problem_of(response: httpx.Response) -> Any:
    try:
        return adapter(models.Problem).validate_json(response.content)
    except ValidationError:
        return models.OtherProblem(
            type=f"urn:wayproof:problem:{_NO_PROBLEM}",
            title=response.reason_phrase,
            status=response.status_code,
            code=_NO_PROBLEM,
            detail=response.text[:300],
            evidence={},
        )
