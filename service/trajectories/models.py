"""Bring your own: a path to time, or a trajectory to prove."""

from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Field, Strict

from service.api.models import (
    WHOLE,
    Boolean,
    Coordinate,
    Failure,
    Identifier,
    Name,
    NonNegative,
    Positions,
    Real,
    RequestModel,
    ResponseModel,
)
from service.plans.models.constraints import Constraint
from service.plans.models.motion_limits import ScaledLimits
from service.plans.models.reports import CertifyReport, RetimeReport
from service.plans.models.request import Certify, Retime
from service.plans.models.result import Certificate
from service.plans.models.trajectory import Trajectory

type Rows = Annotated[list[Positions], Field(min_length=2, max_length=20_000)]
type Instants = Annotated[list[NonNegative], Field(min_length=2, max_length=20_001)]
type Pieces = Annotated[list[Positions], Field(min_length=1, max_length=20_000)]
type Powers = Annotated[list[Positions], Field(min_length=1, max_length=16)]

# What samples may be taken for; no `type`, which would be a schema of its own in OpenAPI.
AsAsked = Literal["quintic", "cubic", "cubic_spline", "linear"]
Interpolation = Literal["polynomial", "quintic", "cubic", "cubic_spline", "linear"]

_SCENE = {"scene": "scn_3f0c5b1e9a7d4c62", "group": "arm"}
_PATH: dict[str, Any] = {
    **_SCENE,
    "waypoints": [[0, -1.57, 1.57, -1.57, -1.57, 0], [0.5, -1.4, 1.4, -1.57, -1.57, 0]],
    "retime": {"method": "ruckig"},
}
_MOTION: dict[str, Any] = {
    **_SCENE,
    "trajectory": {
        "times": [0, 1.5],
        "positions": _PATH["waypoints"],
        "velocities": [[0] * 6, [0] * 6],
    },
}


class InScene(RequestModel):
    """What all these questions have in common."""

    scene: Identifier = Field(description="Id of a scene")
    revision: Annotated[int, Strict(), Field(ge=1), WHOLE] | None = Field(
        default=None, description="Of the scene; null for its latest"
    )
    group: Name = Field(description="`robot` for its default group, or `robot::group`")
    margin: Annotated[NonNegative, Field(le=10)] | None = Field(
        default=None, description="Distance that everything keeps [m]; null for the scene's"
    )
    allowed_time: Annotated[Real, Field(gt=0, le=60)] = Field(
        default=5.0, description="Give up after this long [s]"
    )


class KeptConstraints(RequestModel):
    """What a motion keeps besides its limits."""

    path_constraints: Annotated[list[Constraint], Field(max_length=64)] = Field(
        default=[],
        description="What to keep on the way; what counts from the start counts from where the "
        "given path or motion begins",
    )


class RetimeRequest(InScene, KeptConstraints):
    """Time a path of your own, and prove the motion."""

    model_config = ConfigDict(json_schema_extra={"examples": [_PATH]})

    waypoints: Annotated[list[Positions], Field(min_length=2, max_length=2000)] = Field(
        description="The group's positions from start to goal, joined by straight lines in joint "
        "space [rad or m]"
    )
    retime: Retime = Field(default_factory=Retime, description="How to time it")
    certify: Certify = Field(
        default_factory=Certify, description="What to find out besides the proof"
    )
    polynomial: Boolean = Field(default=False, description="Add the exact piecewise polynomial")


class RetimeStages(ResponseModel):
    """What the two stages did."""

    retime: RetimeReport = Field(description="How the path was timed")
    certify: CertifyReport = Field(description="How the motion was proven")


class RetimeResponse(ResponseModel):
    """A certified motion along the path, or why there is none."""

    trajectory: Trajectory | None = Field(description="The motion; null if there is none")
    certificate: Certificate | None = Field(description="The proof; null if there is none")
    stages: RetimeStages | None = Field(description="What was done; null if there is no motion")
    cut_short: list[str] = Field(
        default=[],
        description="What ended early because of the clock and may be something else another "
        "time: `retime`, `certify`, `explain`, `samples`",
    )
    failure: Failure | None = Field(
        description="Why there is none: `not_certified` with the failed checks, "
        "`retiming_failed`, `deadline_exceeded`; null if there is one"
    )


class OwnPolynomial(RequestModel):
    """The exact motion, as `Trajectory.polynomial` has it."""

    breaks: Instants = Field(description="Instants between pieces, from 0, n + 1 of them [s]")
    bases: Pieces = Field(description="Where each piece is anchored, n rows [rad or m]")
    coefficients: Annotated[list[Powers], Field(min_length=1, max_length=20_000)] = Field(
        description="n pieces, powers from 0 up, a column per velocity coordinate"
    )
    joint_names: list[Name] | None = Field(default=None, description="The group's joints in order")
    joint_types: list[Name] | None = Field(default=None, description="Ignored: the scene knows")


class OwnTrajectory(RequestModel):
    """A timed motion as `Trajectory` has it: samples, or with `polynomial` exactly."""

    times: Instants = Field(description="Instants of the samples, from 0 [s]")
    positions: Rows = Field(description="One row per instant [rad or m]")
    velocities: Rows | None = Field(
        default=None, description="One row per instant [rad/s or m/s]; null if not known"
    )
    accelerations: Rows | None = Field(
        default=None, description="One row per instant [rad/s^2 or m/s^2]; null if not known"
    )
    joint_names: list[Name] | None = Field(
        default=None,
        description="Whose the columns are, those of the rates too; null: the group's, in order",
    )
    velocity_names: list[Name] | None = Field(
        default=None,
        description="Whose the columns of the rates are; null: as those of the positions. Not "
        "without `joint_names`, unless it is the group's order",
    )
    interpolation: AsAsked | None = Field(
        default=None,
        description="What the samples stand for: the polynomials of degree 5 (`quintic`) or 3 "
        "(`cubic`) that meet what is given, the cubic spline with continuous acceleration that "
        "rests at both ends (`cubic_spline`), or straight lines (`linear`); null for the first of "
        "these that there are rates for",
    )
    interpolations: list[dict[str, Any]] | None = Field(
        default=None, description="Ignored: what was proven of the samples where they come from"
    )
    duration: Coordinate | None = Field(default=None, description="Ignored: the times tell it [s]")
    polynomial: OwnPolynomial | None = Field(
        default=None, description="The exact motion; if it is given the samples are not looked at"
    )


class CertifyMotionRequest(InScene, KeptConstraints, ScaledLimits):
    """Prove a trajectory of your own."""

    model_config = ConfigDict(json_schema_extra={"examples": [_MOTION]})

    trajectory: OwnTrajectory = Field(
        description="The motion. Between samples it is taken to be the polynomial of degree 5 that "
        "meets positions, velocities and accelerations; of degree 3 without accelerations; "
        "without velocities the cubic spline with continuous acceleration that rests at both ends; "
        "or what its `interpolation` says. Straight lines have corners, and are only held to what "
        "corners can keep. Positions are numbers, not angles on a circle: from 3 to -3 is a way of "
        "6 rad"
    )
    start: Positions | None = Field(
        default=None, description="Where it shall begin [rad or m]; null for where it does"
    )
    goal: Positions | None = Field(
        default=None, description="Where it shall end [rad or m]; null for where it does"
    )
    limit_jerk: Boolean = Field(
        default=False, description="Hold it against the limits on jerk as well"
    )
    certify: Certify = Field(
        default_factory=Certify, description="What to find out besides the proof"
    )


class CertifyMotionResponse(ResponseModel):
    """The verdict on the motion, between its samples too."""

    certificate: Certificate = Field(description="What was proven, and what failed")
    interpolation: Interpolation = Field(description="What the samples were taken for")
    unchecked: list[str] = Field(
        default=[],
        description="Checks that straight lines are not held to, as their velocity jumps",
    )
    duration: float = Field(description="Of the motion [s]")
    stage: CertifyReport = Field(description="What it took")
