"""Problem: every error answer, RFC 9457."""

from typing import Any, Self

from pydantic import BaseModel, ConfigDict, Field

from planning.errors import WayproofError


class ProblemError(BaseModel):
    """One thing that is wrong with a request, and where."""

    pointer: str = Field(
        description="JSON pointer into the body; empty for its root and for parameters"
    )
    message: str = Field(description="What is wrong there, for a person")
    nearest: list[str] = Field(description="Names that were perhaps meant, the nearest first")


class Problem(BaseModel):
    """Why a request was refused (`application/problem+json`, RFC 9457)."""

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
        description="What is wrong in the body, at most 20; absent where no place of it is",
    )


class Failure(BaseModel):
    """Why a job has no result."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "code": "goal_unreachable",
                    "stage": "goals",
                    "detail": "no configuration reaches the goal pose",
                    "evidence": {"funnel": {"tried": 300, "converged": 0}},
                    "timings": {"load": 0.021, "goals": 0.187, "total": 0.187},
                }
            ]
        }
    )

    code: str = Field(description="Stable machine-readable name of the kind")
    stage: str = Field(
        description="The stage that gave up, or in which the time ran out or the cancel came: a "
        "name in `timings`, for example `goals`; `worker` if it is not known; or empty"
    )
    detail: str = Field(description="What went wrong, for a person")
    evidence: dict[str, Any] = Field(description="Facts behind it [SI units, radians]")
    timings: dict[str, float] = Field(
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
