"""Failure: why a job, or a part of an answer, has no result."""

from functools import cache
from typing import Annotated, Any, Self, override

from pydantic import ConfigDict, Field

from planning.errors import WayproofError
from service.api.document.open_enums import AnyStage
from service.api.failures.table import EVIDENCE, failure_errors
from service.api.failures.union import CodedUnion, NoneOf, UnionMembers, enum_of, member
from service.api.models import Timings

FailureCode = enum_of(
    "FailureCode",
    "Codes of failures that this version knows.",
    (error.code for error in failure_errors()),
)


class Failure(CodedUnion):
    """Reason why a job has no result: its `code` says what its `evidence` has.

    Codes and evidence of older versions are passed on as they are.
    """

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "code": "goal_unreachable",
                    "stage": "goals",
                    "detail": "no configuration reaches the goal pose",
                    "evidence": {
                        "funnel": {
                            "tried": 300,
                            "converged": 0,
                            "within_limits": 0,
                            "collision_free": 0,
                            "distinct": 0,
                            "rejected_by": [],
                        }
                    },
                    "timings": {"load": 0.021, "goals": 0.187, "total": 0.187},
                }
            ]
        }
    )

    code: str = Field(description="Stable machine-readable name of the kind")
    stage: AnyStage = Field(
        description="The stage that gave up, or in which the time ran out or the cancel came: a "
        "name in `timings`, for example `goals`; `worker` if it is not known; or empty"
    )
    detail: str = Field(description="What went wrong, for a person")
    evidence: dict[str, Any] = Field(description="Facts behind it [SI units, radians]")
    timings: Timings = Field(
        default={},
        description="Seconds per stage, of those that ended and of the one that failed; empty "
        "where nothing was timed",
    )

    @classmethod
    def from_error(cls, error: WayproofError) -> Self:
        """Return what a job says of an error that ended it."""
        return cls(
            code=error.code,
            stage=str(getattr(error, "stage", "")),
            detail=error.detail,
            evidence=dict(error.evidence),
            timings=dict(getattr(error, "timings", {})),
        )

    @classmethod
    @override
    def union_members(cls) -> UnionMembers:
        """Return one for each code that this version knows, and one for all others."""
        return failures(), OtherFailure


class OtherFailure(Failure):
    """A failure that an older or a newer version recorded."""

    code: Annotated[str, NoneOf(FailureCode)] = Field(
        description="Stable machine-readable name of the kind"
    )


@cache
def failures() -> dict[str, type[Failure]]:
    """Return the members of the union by code; only documents and tests need them."""
    return {
        error.code: member(Failure, error, error.code, EVIDENCE[error])
        for error in failure_errors()
    }
