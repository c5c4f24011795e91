"""Trajectories on the wire: samples, and the exact piecewise polynomial."""

from pydantic import ConfigDict, Field

from service.api.models import ResponseModel
from service.plans.models.checked import Interpolation

type Row = list[float]


class Polynomial(ResponseModel):
    """The exact motion: q(t) = bases[i] [+] sum_k coefficients[i][k] (t - breaks[i])^k.

    It holds on breaks[i] <= t <= breaks[i + 1]. `[+]` is the plain sum, but for floating joints,
    where the first three tangent coordinates turn the quaternion: R exp(delta).
    """

    breaks: list[float] = Field(description="Instants between pieces, n + 1 of them [s]")
    bases: list[Row] = Field(description="Where each piece is anchored, n rows [rad or m]")
    coefficients: list[list[Row]] = Field(
        description="n pieces, powers from 0 up, a column per velocity coordinate"
    )
    joint_names: list[str] = Field(description="A name per position coordinate")
    joint_types: list[str] = Field(
        description="A type per joint: revolute, continuous, prismatic, planar or floating"
    )


class Trajectory(ResponseModel):
    """A timed motion, sampled; the first and the last instant are included."""

    model_config = ConfigDict(
        title="Trajectory",
        json_schema_extra={
            "examples": [
                {
                    "joint_names": ["arm::shoulder_pan_joint"],
                    "velocity_names": ["arm::shoulder_pan_joint"],
                    "times": [0.0, 0.01],
                    "positions": [[0.0], [0.0001]],
                    "velocities": [[0.0], [0.02]],
                    "accelerations": [[2.0], [2.0]],
                    "duration": 0.01,
                    "interpolations": [],
                    "polynomial": None,
                }
            ]
        },
    )

    joint_names: list[str] = Field(description="A name per position coordinate, in row order")
    velocity_names: list[str] = Field(
        description="A name per velocity coordinate; as `joint_names`, but for floating joints"
    )
    times: list[float] = Field(description="Instants of the samples [s]")
    positions: list[Row] = Field(description="One row per instant [rad or m]")
    velocities: list[Row] = Field(description="One row per instant [rad/s or m/s]")
    accelerations: list[Row] = Field(description="One row per instant [rad/s^2 or m/s^2]")
    duration: float = Field(description="Of the whole motion [s]")
    interpolations: list[Interpolation] = Field(
        default=[],
        description="What is proven of the samples, by what receivers make of them; the "
        "certificate beside them is that of the exact motion. Empty of plans that are older",
    )
    polynomial: Polynomial | None = Field(
        default=None, description="The exact motion, where it was asked for"
    )
