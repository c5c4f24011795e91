"""Problem: why a request was refused."""

from functools import cache
from typing import Annotated, Any, override

from pydantic import BaseModel, ConfigDict, Field

from service.api.failures.parts import NoEvidence
from service.api.failures.table import EVIDENCE, HTTP_ERROR, problem_errors
from service.api.failures.union import CodedUnion, NoneOf, UnionMembers, enum_of, member

ProblemCode = enum_of(
    "ProblemCode",
    "Codes of problems that this version knows.",
    (HTTP_ERROR, *(error.code for error in problem_errors())),
)


class ProblemError(BaseModel):
    """One thing that is wrong with a request, and where."""

    pointer: str = Field(
        description="JSON pointer into the body; empty for its root and for parameters"
    )
    parameter: str = Field(
        default="",
        description="Name of the parameter of the query, the path or the headers that is wrong; "
        "absent where the body is",
    )
    message: str = Field(description="What is wrong there, for a person")
    nearest: list[str] = Field(
        description="Names or values that were perhaps meant, the nearest first"
    )


class Problem(CodedUnion):
    """Reason why a request was refused (`application/problem+json`, RFC 9457).

    Its `code` says what its `evidence` has.
    """

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "type": "urn:wayproof:problem:unknown_name",
                    "title": "Unknown name",
                    "status": 422,
                    "code": "unknown_name",
                    "detail": "frame 'pik' does not exist; did you mean 'pick'? frames: ['pick']",
                    "evidence": {"kind": "frame", "name": "pik", "known": ["pick"]},
                    "errors": [
                        {
                            "pointer": "/goal/poses/0/frame",
                            "message": "frame 'pik' does not exist",
                            "nearest": ["pick"],
                        }
                    ],
                }
            ]
        }
    )

    type: str = Field(description="`urn:wayproof:problem:` and the code")
    title: str = Field(description="The kind of problem, for a person")
    status: int = Field(description="The HTTP status, again")
    code: str = Field(description="Stable machine-readable name of the kind")
    detail: str = Field(description="What is wrong with this request, for a person")
    evidence: dict[str, Any] = Field(description="Facts behind it [SI units, radians]")
    errors: list[ProblemError] = Field(
        default=[],
        description="What is wrong in the body or in parameters, at most 20; absent where no "
        "place of them is",
    )

    @classmethod
    @override
    def union_members(cls) -> UnionMembers:
        """Return one for each code that this version knows, and one for all others."""
        return problems(), OtherProblem


class OtherProblem(Problem):
    """A problem that a newer version tells."""

    code: Annotated[str, NoneOf(ProblemCode)] = Field(
        description="Stable machine-readable name of the kind"
    )


@cache
def problems() -> dict[str, type[Problem]]:
    """Return the members of the union by code; only documents and tests need them."""
    known = {
        error.code: member(Problem, error, error.code, EVIDENCE[error])
        for error in problem_errors()
    }
    return {HTTP_ERROR: member(Problem, None, HTTP_ERROR, NoEvidence), **known}
