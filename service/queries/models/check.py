"""Asking whether configurations are valid."""

from typing import TYPE_CHECKING, Annotated, Self

from pydantic import ConfigDict, Field

from service.api.models import (
    GROUP,
    GroupName,
    GroupPositions,
    NonNegative,
    RequestModel,
    ResponseModel,
    finite,
)
from service.scenes.models.pairs import Pair

if TYPE_CHECKING:
    from planning.world import configuration_check as domain


class CheckRequest(RequestModel):
    """Check configurations of a group against limits and collisions."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [{"group": "arm", "configurations": [[0, -1.57, 1.57, -1.57, -1.57, 0]]}]
        }
    )

    group: GroupName = Field(description=GROUP)
    configurations: Annotated[list[GroupPositions], Field(min_length=1, max_length=2_000)] = Field(
        description="The group's positions, one row each [rad or m]"
    )
    margin: Annotated[NonNegative, Field(le=10)] | None = Field(
        default=None, description="Distance that everything keeps [m]; null for the scene's"
    )


class LimitViolation(ResponseModel):
    """A joint outside its position limits."""

    joint: str = Field(description="Name of the position coordinate")
    value: float = Field(description="Position of the coordinate [rad or m]")
    lower: float | None = Field(description="Smallest allowed [rad or m]; null for none")
    upper: float | None = Field(description="Largest allowed [rad or m]; null for none")


class Verdict(ResponseModel):
    """Verdict on one configuration."""

    valid: bool = Field(
        description="Whether it is within limits, and nothing is nearer than the margin"
    )
    collisions: list[Pair] = Field(
        description="All pairs that touch or are nearer than the margin, deepest first"
    )
    distance: float | None = Field(
        description="Smallest signed distance [m]; null if there is no pair to look at"
    )
    nearest: Pair | None = Field(description="The pair that is nearest; null if there is none")
    limit_violations: list[LimitViolation] = Field(description="Joints outside their limits")

    @classmethod
    def from_domain(cls, verdict: "domain.StateVerdict") -> Self:
        """Return a verdict, which is not validated again."""
        nearest = None if verdict.nearest is None else Pair.from_domain(verdict.nearest)
        return cls.model_construct(
            valid=verdict.valid,
            collisions=[Pair.from_domain(pair) for pair in verdict.violations],
            distance=None if nearest is None else nearest.distance,
            nearest=nearest,
            limit_violations=[
                LimitViolation(
                    joint=outside.joint,
                    value=outside.position,
                    lower=finite(outside.lower),
                    upper=finite(outside.upper),
                )
                for outside in verdict.limit_violations
            ],
        )


class CheckResponse(ResponseModel):
    """A verdict per configuration, in order."""

    results: list[Verdict] = Field(description="Verdicts in the order of the configurations")
