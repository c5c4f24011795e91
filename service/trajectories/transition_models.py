"""Leave a running motion: for a stand, or for another motion."""

from typing import Any, Self

from pydantic import ConfigDict, Field, model_validator

from service.api.models import Boolean, Failure, NonNegative, ResponseModel
from service.plans.models.motion_limits import ScaledLimits
from service.plans.models.reports import CertifyReport
from service.plans.models.result import Certificate
from service.plans.models.sampling import Sampling
from service.plans.models.trajectory import Trajectory
from service.trajectories.models import InScene, Interpolation, KeptConstraints, OwnTrajectory

_REST = [[0] * 6, [0] * 6]
_RUNNING: dict[str, Any] = {
    "times": [0, 2],
    "positions": [[0, -1.57, 1.57, -1.57, -1.57, 0], [0.5, -1.4, 1.4, -1.57, -1.57, 0]],
    "velocities": _REST,
    "accelerations": _REST,
}
_STOP: dict[str, Any] = {
    "scene": "scn_3f0c5b1e9a7d4c62",
    "group": "arm",
    "trajectory": _RUNNING,
    "time": 0.8,
}
_ONTO: dict[str, Any] = {
    **_RUNNING,
    "positions": [[0.2, -1.5, 1.5, -1.57, -1.57, 0], [0.4, -1.2, 1.2, -1.57, -1.57, 0]],
}


class _LeavingRequest(InScene, KeptConstraints, Sampling, ScaledLimits):
    """What is left and when, and what to keep on the way."""

    trajectory: OwnTrajectory = Field(
        description="The running motion, read as `POST /trajectories/certify` reads one"
    )
    time: NonNegative = Field(description="When it is left, within its duration [s]")
    polynomial: Boolean = Field(default=False, description="Add the exact piecewise polynomial")


class StopMotionRequest(_LeavingRequest):
    """Stop a running motion; only what is told here is kept."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [_STOP, {**_STOP, "along_path": True}]}
    )

    along_path: Boolean = Field(
        default=False,
        description="Stay on the path of the running motion, which is slowed down; else every "
        "joint brakes by itself",
    )
    limit_jerk: Boolean = Field(
        default=True,
        description="Keep the limits on jerk, which the running motion must keep too; can only be "
        "false along the path, where accelerations then may jump, at the first instant too",
    )

    @model_validator(mode="after")
    def _limits_jerk_off_the_path(self) -> Self:
        if not (self.limit_jerk or self.along_path):
            message = "limit_jerk: only stops with `along_path` can do without"
            raise ValueError(message)
        return self


class SpliceMotionRequest(_LeavingRequest):
    """Go over from a running motion to another one; only what is told here is kept."""

    model_config = ConfigDict(json_schema_extra={"examples": [{**_STOP, "onto": _ONTO}]})

    onto: OwnTrajectory = Field(description="The other motion, which is followed to its end")


class StopMotionResponse(ResponseModel):
    """A certified motion from the instant on, or why there is none."""

    trajectory: Trajectory | None = Field(
        description="The motion, from the running motion's state at `time`, which is its 0; null "
        "if there is none"
    )
    certificate: Certificate | None = Field(description="The proof; null if there is none")
    stage: CertifyReport | None = Field(description="What it took; null if there is none")
    interpolation: Interpolation = Field(
        description="What the samples of the running motion were taken for"
    )
    failure: Failure | None = Field(
        description="Why there is none: `retiming_failed`, `not_certified` with the failed checks, "
        "`deadline_exceeded`; null if there is one"
    )


class SpliceMotionResponse(StopMotionResponse):
    """A certified motion from the instant on to the end of the other one, or why there is none."""

    onto_interpolation: Interpolation = Field(
        description="What the samples of the other motion were taken for"
    )
