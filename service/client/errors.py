"""ApiError: the server said no, and why."""

import httpx
from pydantic import ValidationError

from service.client.models import Problem


class ApiError(Exception):
    """An answer that is a problem document.

    Attributes:
        problem: What the server said.
    """

    def __init__(self, problem: Problem) -> None:
        super().__init__(f"{problem.status} {problem.code}: {problem.detail}")
        self.problem = problem


def raise_for_problem(response: httpx.Response) -> httpx.Response:
    """Return an answer that is no error.

    Raises:
        ApiError: It is one.
    """
    if not response.is_error:
        return response
    try:
        problem = Problem.model_validate_json(response.content)
    except ValidationError:
        problem = Problem(
            title=response.reason_phrase,
            status=response.status_code,
            code="http_error",
            detail=response.text[:300],
            evidence={},
        )
    raise ApiError(problem)
