"""FrameStates: position, velocity and acceleration of a frame's origin along a trajectory."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Float64
from pydrake.multibody.tree import JacobianWrtVariable

from planning.certify.frames.kernel_points import KernelPoints
from planning.certify.request import CertifyRequest
from planning.domain.arrays import Array
from planning.domain.curves.curve import TimedTrajectory, derivative
from planning.domain.request.deadline import Deadline
from planning.world.drake_model import DrakeModel

_BATCH_SIZE = 256


@dataclass(frozen=True)
class FrameMotion:
    """Motion of a frame's origin at some instants, in world.

    Attributes:
        position: Position [m], shape (n, 3).
        velocity: Velocity [m/s], shape (n, 3).
        acceleration: Acceleration [m/s^2], shape (n, 3).
    """

    position: Float64[np.ndarray, "n 3"]
    velocity: Float64[np.ndarray, "n 3"]
    acceleration: Float64[np.ndarray, "n 3"]

    def __getitem__(self, rows: Any) -> "FrameMotion":
        """Return some of the rows."""
        return FrameMotion(self.position[rows], self.velocity[rows], self.acceleration[rows])

    def interleaved(self, other: "FrameMotion") -> "FrameMotion":
        """Return the rows of both, alternating."""
        return FrameMotion(
            *(
                np.stack([own_rows, other_rows], axis=1).reshape(-1, 3)
                for own_rows, other_rows in zip(self.parts, other.parts, strict=True)
            )
        )

    @property
    def parts(self) -> tuple[Array, Array, Array]:
        """Position, velocity and acceleration."""
        return self.position, self.velocity, self.acceleration


class FrameStates:
    """States of one frame along one trajectory, by the kernel or Drake in a context of its own."""

    def __init__(self, model: DrakeModel, request: CertifyRequest, frame: str) -> None:
        """Prepare; the frame must exist."""
        self._model, self._request, self._plant = model, request, model.plant
        self._frame = model.frame(frame)
        self._columns = model.velocity_indices(request.group)
        self._kernel = KernelPoints.of(model, request, frame)

    @cached_property
    def _context(self) -> Any:
        """Drake's context, which the kernel needs not."""
        return self._plant.CreateDefaultContext()

    def at(self, pieces: Any, local: Float64[np.ndarray, " n"], deadline: Deadline) -> FrameMotion:
        """Return the frame's motion at instants of given pieces, also where two pieces meet.

        Args:
            pieces: Index of the piece of each instant, shape (n,).
            local: Time since the beginning of the piece [s].
            deadline: Time limit.

        Raises:
            DeadlineExceeded: Time ran out.
            Canceled: The caller canceled.
        """
        request, model = self._request, self._model
        if self._kernel is not None:
            deadline.check("certify")
            return FrameMotion(*self._kernel.at(pieces, local))
        q, v, vdot = _joint_states(request.trajectory, pieces, local)
        full = model.embed(request.group, q, request.state)
        rates = [self._plant_rates(x) for x in (v, vdot)]
        states = np.empty((3, len(local), 3))
        for i in range(len(local)):
            if i % _BATCH_SIZE == 0:
                deadline.check("certify")
            states[:, i] = self._evaluate(full[i], rates[0][i], rates[1][i])
        return FrameMotion(*states)

    def _plant_rates(self, rates: Array) -> Array:
        """Return rates of the whole plant: those of the group, of its followers, else zero."""
        full = np.zeros((len(rates), self._plant.num_velocities()))
        full[:, self._columns] = rates
        for follower, leader, multiplier in self._model.mimics:
            full[:, follower] = multiplier * full[:, leader]
        return full

    def _evaluate(self, q: Array, v: Array, vdot: Array) -> tuple[Array, Array, Array]:
        plant, context, frame = self._plant, self._context, self._frame
        plant.SetPositions(context, q)
        plant.SetVelocities(context, v)
        world = plant.world_frame()
        of_v = JacobianWrtVariable.kV
        jacobian = plant.CalcJacobianTranslationalVelocity(
            context, of_v, frame.frame, frame.origin, world, world
        )
        bias = plant.CalcBiasTranslationalAcceleration(
            context, of_v, frame.frame, frame.origin, world, world
        )
        position = np.array(frame.pose(context).translation())
        return position, jacobian @ v, jacobian @ vdot + bias[:, 0]


def _joint_states(curve: TimedTrajectory, pieces: Any, local: Array) -> tuple[Array, Array, Array]:
    """Return q, v and vdot at instants of given pieces."""
    delta, rate, change = (
        _polynomial_values(derivative(curve.coefficients, order)[pieces], local)
        for order in range(3)
    )
    manifold = curve.manifold
    q = manifold.plus(curve.bases[pieces], delta)
    return (
        q,
        manifold.generalized_velocity(q, delta, rate),
        manifold.generalized_acceleration(q, delta, rate, change),
    )


def _polynomial_values(coefficients: Array, local: Array) -> Array:
    powers = local[:, None] ** np.arange(coefficients.shape[1])
    return np.einsum("nk,nkv->nv", powers, coefficients)
