"""Asking whether configurations are valid."""

from typing import Annotated, Literal

from pydantic import ConfigDict, Field

from service.api.models import Name, NonNegative, Positions, RequestModel, ResponseModel


class CheckRequest(RequestModel):
    """Check configurations of a group against limits and collisions."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [{"group": "arm", "configurations": [[0, -1.57, 1.57, -1.57, -1.57, 0]]}]
        }
    )

    group: Name = Field(description="`robot` or `robot::group`")
    configurations: Annotated[list[Positions], Field(min_length=1, max_length=10_000)] = Field(
        description="The group's positions, one row each [rad or m]"
    )
    margin: Annotated[NonNegative, Field(le=10)] | None = Field(
        default=None, description="Distance that everything keeps [m]; null for the scene's"
    )


class UncheckedPair(ResponseModel):
    """Two bodies that no collision check looks at."""

    model_config = ConfigDict(title="UncheckedPair")

    bodies: tuple[str, str] = Field(description="Full names, sorted")
    reason: Literal["allowed", "held", "welded", "welded_to_world", "adjacent"] = Field(
        description="allowed: by the scene or the robot's description; held: one is attached and "
        "may touch the other; welded: neither can move relative to the other; welded_to_world: "
        "both stand in the world; adjacent: a joint joins them, and their shapes touch about it or "
        "can never touch"
    )
    evidence: str = Field(description="What that rests on, in words")


class Pair(ResponseModel):
    """Two bodies and how near they are."""

    bodies: tuple[str, str] = Field(description="Full names")
    distance: float = Field(description="Signed [m]; negative is the depth of penetration")
    depth: float = Field(description="Of penetration [m]; 0 if they do not touch", ge=0)
    points: list[list[float]] = Field(description="The nearest point of each, in world [m]")


class LimitViolation(ResponseModel):
    """A joint outside its position limits."""

    joint: str = Field(description="Name of the position coordinate")
    value: float = Field(description="Where it is [rad or m]")
    lower: float | None = Field(description="Smallest allowed [rad or m]; null for none")
    upper: float | None = Field(description="Largest allowed [rad or m]; null for none")


class Verdict(ResponseModel):
    """What was found of one configuration."""

    valid: bool = Field(description="Within limits, and nothing nearer than the margin")
    collisions: list[Pair] = Field(
        description="All pairs that touch or are nearer than the margin, deepest first"
    )
    distance: float | None = Field(
        description="Smallest signed distance [m]; null if there is no pair to look at"
    )
    nearest: Pair | None = Field(description="The pair that is nearest; null if there is none")
    limit_violations: list[LimitViolation] = Field(description="Joints outside their limits")


class CheckResponse(ResponseModel):
    """A verdict per configuration, in order."""

    results: list[Verdict] = Field(description="In the order of the configurations")
