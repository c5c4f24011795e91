"""Requests and answers about motions of the client: timed, certified, stopped, spliced."""

from typing import Annotated, Any, Self

from pydantic import ConfigDict, Field, Strict, model_validator

from service.api.failures.failure import Failure
from service.api.models import (
    GROUP,
    WHOLE,
    Boolean,
    GroupName,
    GroupPositions,
    Identifier,
    NonNegative,
    Real,
    RequestModel,
    ResponseModel,
)
from service.plans.models.constraints import Constraint
from service.plans.models.motion_limits import ScaledLimits
from service.plans.models.reports import CertifyReport, RetimeReport
from service.plans.models.request import Certify, Retime
from service.plans.models.result import Certificate
from service.plans.models.sampling import Sampling
from service.plans.models.trajectory import Trajectory
from service.trajectories.input import MotionInterpolation, TrajectoryInput

_SCENE = {"scene": "scn_3f0c5b1e9a7d4c62", "group": "arm"}
_WAYPOINTS = [[0, -1.57, 1.57, -1.57, -1.57, 0], [0.5, -1.4, 1.4, -1.57, -1.57, 0]]
_REST = [[0] * 6, [0] * 6]
_PATH: dict[str, Any] = {**_SCENE, "waypoints": _WAYPOINTS, "retime": {"method": "ruckig"}}
_MOTION: dict[str, Any] = {
    **_SCENE,
    "trajectory": {"times": [0, 1.5], "positions": _WAYPOINTS, "velocities": _REST},
}
_RUNNING: dict[str, Any] = {
    "times": [0, 2],
    "positions": _WAYPOINTS,
    "velocities": _REST,
    "accelerations": _REST,
}
_STOP: dict[str, Any] = {**_SCENE, "trajectory": _RUNNING, "time": 0.8}
_ONTO: dict[str, Any] = {
    **_RUNNING,
    "positions": [[0.2, -1.5, 1.5, -1.57, -1.57, 0], [0.4, -1.2, 1.2, -1.57, -1.57, 0]],
}


class MotionRequest(RequestModel):
    """Fields of every request about a motion of the client."""

    path_constraints: Annotated[list[Constraint], Field(max_length=64)] = Field(
        default=[],
        description="Constraints on the whole motion; those relative to the start are relative to "
        "the first configuration of the given path or motion",
    )
    scene: Identifier = Field(description="Id of a scene")
    revision: Annotated[int, Strict(), Field(ge=1), WHOLE] | None = Field(
        default=None, description="Revision of the scene; null for its latest"
    )
    group: GroupName = Field(description=GROUP)
    margin: Annotated[NonNegative, Field(le=10)] | None = Field(
        default=None, description="Distance that everything keeps [m]; null for the scene's"
    )
    allowed_time: Annotated[Real, Field(gt=0, le=60)] = Field(
        default=5.0, description="Time after which to give up [s]"
    )


class RetimeRequest(MotionRequest):
    """Time a path of your own, and prove the motion."""

    model_config = ConfigDict(json_schema_extra={"examples": [_PATH]})

    waypoints: Annotated[list[GroupPositions], Field(min_length=2, max_length=2000)] = Field(
        description="The group's positions from start to goal, joined by straight lines in joint "
        "space [rad or m]"
    )
    retime: Retime = Field(default_factory=Retime, description="Options of the timing")
    certify: Certify = Field(default_factory=Certify, description="Computations besides the proof")
    polynomial: Boolean = Field(
        default=False, description="Whether to add the exact piecewise polynomial"
    )


class RetimeStages(ResponseModel):
    """Reports of the two stages."""

    retime: RetimeReport = Field(description="Report of the timing")
    certify: CertifyReport = Field(description="Report of the proof")


class RetimeResponse(ResponseModel):
    """A certified motion along the path, or why there is none."""

    trajectory: Trajectory | None = Field(description="The motion; null if there is none")
    certificate: Certificate | None = Field(description="The proof; null if there is none")
    stages: RetimeStages | None = Field(
        description="Reports of the stages; null if there is no motion"
    )
    cut_short: list[str] = Field(
        default=[],
        description="Stages that the clock ended early, whose results may differ another time: "
        "`retime`, `certify`, `explain`, `samples`",
    )
    failure: Failure | None = Field(
        description="Reason why there is none: `not_certified` with the failed checks, "
        "`retiming_failed`, `deadline_exceeded`; null if there is one"
    )


class CertifyMotionRequest(MotionRequest, ScaledLimits):
    """Prove a trajectory of your own."""

    model_config = ConfigDict(json_schema_extra={"examples": [_MOTION]})

    trajectory: TrajectoryInput = Field(
        description="The motion; its `interpolation` says what is between the samples, "
        "and straight lines are only held to what corners can keep. Positions "
        "are numbers, not angles on a circle: from 3 to -3 is a way of 6 rad"
    )
    start: GroupPositions | None = Field(
        default=None,
        description="Positions at which the motion shall begin [rad or m]; "
        "null for those at which it begins",
    )
    goal: GroupPositions | None = Field(
        default=None,
        description="Positions at which the motion shall end [rad or m]; "
        "null for those at which it ends",
    )
    limit_jerk: Boolean = Field(
        default=False, description="Whether to check the limits on jerk as well"
    )
    certify: Certify = Field(default_factory=Certify, description="Computations besides the proof")


class CertifyMotionResponse(ResponseModel):
    """The verdict on the motion, between its samples too."""

    certificate: Certificate = Field(description="Checks that passed and checks that failed")
    interpolation: MotionInterpolation = Field(
        description="Motion that was taken to be between the samples"
    )
    unchecked: list[str] = Field(
        default=[],
        description="Checks that straight lines are not held to, as their velocity jumps",
    )
    duration: float = Field(description="Duration of the motion [s]")
    stage: CertifyReport = Field(description="Report of the proof")


class _FromRunningMotion(MotionRequest, Sampling, ScaledLimits):
    """A running motion, the instant at which it is left, and what to keep on the way."""

    trajectory: TrajectoryInput = Field(
        description="The running motion, read as `POST /trajectories/certify` reads one"
    )
    time: NonNegative = Field(
        description="Time along the running motion at which it is left, within its duration [s]"
    )
    polynomial: Boolean = Field(default=False, description="Add the exact piecewise polynomial")


class StopMotionRequest(_FromRunningMotion):
    """Stop a running motion; only the limits and constraints of this request are kept."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [_STOP, {**_STOP, "along_path": True}]}
    )

    along_path: Boolean = Field(
        default=False,
        description="Whether to stay on the path of the running motion, which is slowed "
        "down; else every joint brakes by itself",
    )
    limit_jerk: Boolean = Field(
        default=True,
        description="Whether to keep the limits on jerk, which the running motion must "
        "keep too. It can only be false along the path, where accelerations "
        "then may jump, at the first instant too",
    )

    @model_validator(mode="after")
    def _limits_jerk_off_the_path(self) -> Self:
        if not (self.limit_jerk or self.along_path):
            message = "limit_jerk: only stops with `along_path` can do without"
            raise ValueError(message)
        return self


class SpliceMotionRequest(_FromRunningMotion):
    """Go over to another motion; only the limits and constraints of this request are kept."""

    model_config = ConfigDict(json_schema_extra={"examples": [{**_STOP, "onto": _ONTO}]})

    onto: TrajectoryInput = Field(description="The other motion, which is followed to its end")


class StopMotionResponse(ResponseModel):
    """A certified motion from the instant on, or why there is none."""

    trajectory: Trajectory | None = Field(
        description="The motion, from the running motion's state at `time`, which is its 0; null "
        "if there is none"
    )
    certificate: Certificate | None = Field(description="The proof; null if there is none")
    stage: CertifyReport | None = Field(description="Report of the proof; null if there is none")
    interpolation: MotionInterpolation = Field(
        description="Motion that was taken to be between the samples of the running motion"
    )
    failure: Failure | None = Field(
        description="Reason why there is none: `retiming_failed`, `not_certified` with "
        "the failed checks, `deadline_exceeded`; null if there is one"
    )


class SpliceMotionResponse(StopMotionResponse):
    """A certified motion from the instant on to the end of the other one, or why there is none."""

    onto_interpolation: MotionInterpolation = Field(
        description="Motion that was taken to be between the samples of the other motion"
    )
