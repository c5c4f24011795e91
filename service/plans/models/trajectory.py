"""Trajectories: samples, and the exact piecewise polynomial."""

from collections.abc import Iterable
from typing import Self

import numpy as np
from pydantic import ConfigDict, Field

from planning.domain.curves.curve import TimedTrajectory
from planning.domain.curves.interpolation_proof import InterpolationProof
from planning.domain.curves.sampling import SampledTrajectory
from planning.domain.robot.joints import Joint, JointType
from service.api.arrays import Row, Rows, matrix, vector
from service.api.models import ResponseModel
from service.plans.models.checks import Interpolation


class Polynomial(ResponseModel):
    """The exact motion: q(t) = bases[i] [+] sum_k coefficients[i][k] (t - breaks[i])^k.

    It holds on breaks[i] <= t <= breaks[i + 1]. `[+]` is the plain sum, but for floating joints,
    where the first three tangent coordinates turn the quaternion: R exp(delta).
    """

    breaks: Row = Field(description="Instants between pieces, n + 1 of them [s]")
    bases: Rows = Field(
        description="Configuration at which each piece is anchored, n rows [rad or m]"
    )
    coefficients: list[list[list[float]]] = Field(
        description="n pieces, powers k from 0 up, a column per velocity coordinate "
        "[rad/s^k or m/s^k]"
    )
    joint_names: list[str] = Field(description="A name per position coordinate")
    joint_types: list[str] = Field(
        description="A type per joint: revolute, continuous, prismatic, planar or floating"
    )

    @classmethod
    def from_domain(cls, trajectory: TimedTrajectory) -> Self:
        """Return the exact trajectory: floats survive JSON bit for bit."""
        return cls.model_construct(
            breaks=trajectory.breaks.tolist(),
            bases=trajectory.bases.tolist(),
            coefficients=trajectory.coefficients.tolist(),
            joint_names=[joint.name for joint in trajectory.joints],
            joint_types=[str(joint.type) for joint in trajectory.joints],
        )

    def to_domain(self) -> TimedTrajectory:
        """Return the domain's trajectory."""
        joints = zip(self.joint_names, self.joint_types, strict=True)
        return TimedTrajectory(
            tuple(Joint(name, JointType(kind)) for name, kind in joints),
            vector(self.breaks),
            matrix(self.bases),
            np.array(self.coefficients, dtype=np.float64),
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
    times: Row = Field(description="Instants of the samples [s]")
    positions: Rows = Field(description="One row per instant [rad or m]")
    velocities: Rows = Field(description="Velocities, one row per instant [rad/s or m/s]")
    accelerations: Rows = Field(description="Accelerations, one row per instant [rad/s^2 or m/s^2]")
    duration: float = Field(description="Duration of the whole motion [s]")
    interpolations: list[Interpolation] = Field(
        default=[],
        description="Proofs of the samples, by what receivers make of them; the "
        "certificate beside them is that of the exact motion. Empty for older "
        "plans",
    )
    polynomial: Polynomial | None = Field(
        default=None, description="The exact motion, if the request has it added"
    )

    @classmethod
    def from_samples(
        cls,
        samples: SampledTrajectory,
        proofs: Iterable[InterpolationProof],
        exact: TimedTrajectory | None = None,
    ) -> Self:
        """Return the samples of a motion, which are not validated.

        Args:
            samples: Of the motion.
            proofs: What is proven of them.
            exact: The motion itself, if it is to be there too.
        """
        return cls.model_construct(
            joint_names=[name for joint in samples.joints for name in joint.position_names],
            velocity_names=[name for joint in samples.joints for name in joint.velocity_names],
            times=samples.times.tolist(),
            positions=samples.positions.tolist(),
            velocities=samples.velocities.tolist(),
            accelerations=samples.accelerations.tolist(),
            duration=float(samples.times[-1]),
            interpolations=[Interpolation.model_validate(proof) for proof in proofs],
            polynomial=None if exact is None else Polynomial.from_domain(exact),
        )
