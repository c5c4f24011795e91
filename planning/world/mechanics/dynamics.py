"""Inverse dynamics: joint torques and forces of a motion, with payload, by the kernel or Drake."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64
from pydrake.math import RotationMatrix
from pydrake.multibody.tree import MultibodyForces, RotationalInertia, SpatialInertia

from planning.domain.arrays import Array
from planning.domain.robot.joints import JointGroup
from planning.domain.robot.payload import Payload
from planning.errors import ProblemInvalid
from planning.world.drake_model import DrakeModel
from planning.world.kernel.kernel_dynamics import kernel_dynamics
from planning.world.world import World


@dataclass(frozen=True)
class PathEfforts:
    """Efforts along a path r(s): tau = a u + b x + c, without damping.

    With x = (ds/dt)^2 and u = d2s/dt2: a = M r', b = M r'' + C(r, r') r', c = -tau_g(r)
    (Bobrow, Dubowsky, Gibson 1985).

    Attributes:
        by_path_acceleration: a, the effort by path acceleration [N m or N per 1/s^2], shape (m,
            nv).
        by_squared_velocity: b, the effort by squared path velocity, in the same unit, shape (m,
            nv).
        static: c, the effort against gravity [N m or N], shape (m, nv).
    """

    by_path_acceleration: Float64[np.ndarray, "m nv"]
    by_squared_velocity: Float64[np.ndarray, "m nv"]
    static: Float64[np.ndarray, "m nv"]


class GroupDynamics:
    """Inverse dynamics of a group by the native kernel, else by Drake in a context of its own.

    All other joints stay as in the scene. The effort of a follower adds to that of its leader, by
    the transpose of the coupling (virtual work). Not included: dry friction, contact.

    Attributes:
        damping: Viscous damping of each coordinate [N m s/rad or N s/m], shape (nv,).
    """

    def __init__(self, world: World, group: JointGroup, payload: Payload | None = None) -> None:
        """Load the group with a payload, if there is one.

        Raises:
            UnknownName: The payload's frame does not exist.
            ProblemInvalid: The group does not move it.
        """
        self._world, self._group, self._model = world, group, world.drake
        self._plant = self._model.plant
        self._context: Any = self._plant.CreateDefaultContext()
        self._forces = MultibodyForces(self._plant)
        self._velocity_indices = self._model.velocity_indices(group)
        self._mimics = self._model.mimics
        self.damping = self._remove_damping()
        if payload is not None:
            validate_payload(world, group, payload)
            _add_payload(self._model, self._context, payload)
        self._native = kernel_dynamics(self._model, group, world.state, self._context)

    def efforts(
        self,
        q: Float64[np.ndarray, "m nq"],
        v: Float64[np.ndarray, "m nv"],
        vdot: Float64[np.ndarray, "m nv"],
    ) -> Float64[np.ndarray, "m nv"]:
        """Return tau = M(q) vdot + C(q, v) v - tau_g(q) + D v [N m or N].

        Args:
            q: Positions [rad or m].
            v: Drake's velocities [rad/s or m/s].
            vdot: Drake's accelerations [rad/s^2 or m/s^2].
        """
        return self._undamped(q, v, vdot) + self.damping * v

    def derivatives(
        self,
        q: Float64[np.ndarray, "m nq"],
        v: Float64[np.ndarray, "m nv"],
        vdot: Float64[np.ndarray, "m nv"],
    ) -> Float64[np.ndarray, "3 m nv nq"] | None:
        """Return the derivatives of the efforts without damping by q, v and vdot.

        None where Drake computes, or a joint floats.

        Args:
            q: Positions [rad or m].
            v: Drake's velocities [rad/s or m/s].
            vdot: Drake's accelerations [rad/s^2 or m/s^2].
        """
        if self._native is None or q.shape[1] != v.shape[1]:
            return None
        found: Array = self._native.derivatives(*map(np.ascontiguousarray, (q, v, vdot)))
        return found

    def _undamped(self, q: Array, v: Array, vdot: Array) -> Array:
        if self._native is not None:
            found: Array = self._native.efforts(*map(np.ascontiguousarray, (q, v, vdot)))
            return found
        found = np.empty((len(v), self._plant.num_velocities()))
        full_v, full_vdot = self._full_rates(v), self._full_rates(vdot)
        for i, full in enumerate(self._world.embed(self._group, q)):
            self._plant.SetPositions(self._context, full)
            self._plant.SetVelocities(self._context, full_v[i])
            self._plant.CalcForceElementsContribution(self._context, self._forces)
            found[i] = self._inverse_dynamics(full_vdot[i])
        return self._group_efforts(found)

    def path_efforts(
        self,
        q: Float64[np.ndarray, "m nq"],
        rate: Float64[np.ndarray, "m nv"],
        curvature: Float64[np.ndarray, "m nv"],
    ) -> PathEfforts:
        """Return the coefficients of the efforts along a path.

        Args:
            q: r(s) [rad or m].
            rate: r' as Drake's velocity.
            curvature: r'' as Drake's acceleration.
        """
        zeros = np.zeros_like(rate)
        static = self._undamped(q, zeros, zeros)
        inertial = self._undamped(q, zeros, rate)
        centrifugal = self._undamped(q, rate, curvature)
        return PathEfforts(inertial - static, centrifugal - static, static)

    def _inverse_dynamics(self, vdot: Array) -> Array:
        """Return the plant's generalized forces at the context's state, for all joints alone."""
        return self._plant.CalcInverseDynamics(self._context, vdot, self._forces)

    def _group_efforts(self, full: Float64[np.ndarray, "m num_velocities"]) -> Array:
        """Return the group's part of the plant's forces, with those of all followers."""
        for follower, leader, multiplier in reversed(self._mimics):
            full[:, leader] += multiplier * full[:, follower]
        return full[:, self._velocity_indices]

    def _remove_damping(self) -> Array:
        """Remove the damping from the context, and return it."""
        full = np.zeros(self._plant.num_velocities())
        for index in self._plant.GetJointIndices():
            joint = self._plant.get_joint(index)
            begin, count = joint.velocity_start(), joint.num_velocities()
            if count:
                full[begin : begin + count] = joint.GetDampingVector(self._context)
                joint.SetDampingVector(self._context, np.zeros(count))
        for follower, leader, multiplier in reversed(self._mimics):
            full[leader] += multiplier**2 * full[follower]
        return full[self._velocity_indices]

    def _full_rates(self, rates: Float64[np.ndarray, "m nv"]) -> Array:
        """Return the plant's rates: those of the group, and of its followers."""
        full = np.zeros((len(rates), self._plant.num_velocities()))
        full[:, self._velocity_indices] = rates
        for follower, leader, multiplier in self._mimics:
            full[:, follower] = multiplier * full[:, leader]
        return full


def validate_payload(
    world: World, group: JointGroup, payload: Payload, field: str = "payload"
) -> None:
    """Raise unless a payload loads a joint of a group.

    Args:
        world: The scene.
        group: The group that moves.
        payload: The mass that it carries.
        field: Name of the payload in the request.

    Raises:
        UnknownName: Its frame does not exist.
        ProblemInvalid: The group does not move it.
    """
    world.validate_frame(payload.frame)
    model = world.drake
    moved_velocities = {int(v) for v in model.velocity_indices(group)}
    moved_velocities |= {c.follower_velocity for c in model.followers_of(group)}
    joints = [model.plant.get_joint(index) for index in model.joint_indices.values()]
    moving = [joint.index() for joint in joints if joint.velocity_start() in moved_velocities]
    body = model.frame(payload.frame).body
    if body not in model.plant.GetBodiesKinematicallyAffectedBy(moving):
        message = f"{field}.frame: {group.name!r} does not move {payload.frame!r}"
        evidence = {"field": f"{field}.frame", "tool_frames": list(group.tool_frames)}
        raise ProblemInvalid(message, evidence)


def _add_payload(model: DrakeModel, context: Any, payload: Payload) -> None:
    """Add a payload to the body of its frame, in a context alone."""
    frame = model.frame(payload.frame)
    body: Any = model.plant.get_body(frame.body)
    x_bf = frame.pose_in_body
    (xx, xy, xz), (_, yy, yz), (*_, zz) = payload.inertia
    central = RotationalInertia(xx, yy, zz, xy, xz, yz).ReExpress(RotationMatrix(x_bf.rotation()))
    added = SpatialInertia.MakeFromCentralInertia(
        payload.mass, x_bf.multiply(payload.center_of_mass), central
    )
    total = body.CalcSpatialInertiaInBodyFrame(context)
    total += added
    body.SetSpatialInertiaInBodyFrame(context, total)
