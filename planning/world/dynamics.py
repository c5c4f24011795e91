"""Inverse dynamics: the joint torques that a motion takes."""

from typing import Any

import numpy as np
from jaxtyping import Float64
from pydrake.multibody.tree import MultibodyForces

from planning.domain.joints import JointGroup
from planning.world.world import World

type Array = np.ndarray[Any, np.dtype[np.float64]]


def joint_efforts(
    world: World,
    group: JointGroup,
    q: Float64[np.ndarray, "m nq"],
    v: Float64[np.ndarray, "m nv"],
    vdot: Float64[np.ndarray, "m nv"],
) -> Float64[np.ndarray, "m nv"]:
    """Return tau = M(q) vdot + C(q, v) v - tau_g(q) of a group [N m or N].

    All else stays where the scene has it. What follows a joint burdens that joint, by the
    transpose of its coupling (virtual work). Not in it: friction, rotor inertia, contact.

    Args:
        world: The scene, loaded.
        group: What moves.
        q: Its positions [rad or m].
        v: Drake's velocities [rad/s or m/s].
        vdot: And accelerations [rad/s^2 or m/s^2].
    """
    model, plant = world.drake, world.drake.plant
    context: Any = plant.CreateDefaultContext()
    members = model.velocity_indices(group)
    efforts = np.empty_like(v)
    full_q = world.embed(group, q)
    for i in range(len(q)):
        plant.SetPositions(context, full_q[i])
        plant.SetVelocities(context, _followed(world, members, v[i]))
        forces = MultibodyForces(plant)
        plant.CalcForceElementsContribution(context, forces)
        full = plant.CalcInverseDynamics(context, _followed(world, members, vdot[i]), forces)
        for follower, leader, multiplier in reversed(model.mimics):
            full[leader] += multiplier * full[follower]
        efforts[i] = full[members]
    return efforts


def _followed(world: World, members: Any, rates: Array) -> Array:
    """Return the plant's rates: those of the group, and of what follows it."""
    full = np.zeros(world.drake.plant.num_velocities())
    full[members] = rates
    for follower, leader, multiplier in world.drake.mimics:
        full[follower] = multiplier * full[leader]
    return full
