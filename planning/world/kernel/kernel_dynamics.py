"""Inverse dynamics of a group in the native kernel, with the masses of Drake's plant."""

from typing import Any

import numpy as np
from jaxtyping import Float64
from pydrake.math import RigidTransform
from pydrake.multibody.tree import BodyIndex
from pydrake.systems.framework import Context

from planning.domain.robot.joints import JointGroup
from planning.kernel.native import native
from planning.world.drake_model import DrakeModel
from planning.world.kernel.kernel_tree import tree_scene
from planning.world.kernel.link_tree import WORLD, LinkTree

# The uniform field of gravity, which every plant has.
_ONLY_GRAVITY = 1


def kernel_dynamics(
    model: DrakeModel,
    group: JointGroup,
    state: Float64[np.ndarray, " num_positions"],
    context: Context,
) -> Any | None:
    """Return the kernel's InverseDynamics of a group, other joints at `state`.

    It has neither damping nor dry friction. None where Drake alone computes: there is no kernel,
    the model does not use it or has a joint that the kernel does not have, a body has no finite
    inertia, or springs act.

    Args:
        model: The scene.
        group: The group that moves.
        state: Full positions, for all other joints.
        context: Of the plant, with the inertias of bodies.
    """
    module, known = native(), tree_scene(model)
    if module is None or known is None or model.plant.num_force_elements() != _ONLY_GRAVITY:
        return None
    scene, tree = known
    inertias = _inertias(model, tree, context)
    if not np.isfinite(inertias).all():
        return None
    return module.InverseDynamics(
        scene,
        model.position_indices(group).astype(np.int64),
        model.velocity_indices(group).astype(np.int64),
        model.apply_couplings(np.array(state)),
        inertias,
        _reflected_inertias(model, context),
        np.array(model.plant.gravity_field().gravity_vector()),
    )


def _inertias(model: DrakeModel, tree: LinkTree, context: Any) -> Float64[np.ndarray, "n 13"]:
    """Return mass, centre of mass and rotational inertia about it of every link."""
    bodies = [(index, *placed) for index, placed in tree.bodies.items() if placed[0] != WORLD]
    links = np.array([link for _, link, _ in bodies], dtype=np.int64)
    mass, center, inertia = _in_links(model, bodies, context)
    masses = np.zeros(len(tree.links))
    moments = np.zeros((len(tree.links), 3))
    about_origin = np.zeros((len(tree.links), 3, 3))
    np.add.at(masses, links, mass)
    np.add.at(moments, links, mass[:, None] * center)
    np.add.at(about_origin, links, inertia)
    centers = np.divide(moments, masses[:, None], where=masses[:, None] > 0, out=moments * 0)
    about_center = about_origin - masses[:, None, None] * _point_inertia(centers)
    return np.concatenate([masses[:, None], centers, about_center.reshape(-1, 9)], axis=1)


def _in_links(
    model: DrakeModel, bodies: list[tuple[int, int, RigidTransform]], context: Any
) -> tuple[Float64[np.ndarray, " k"], Float64[np.ndarray, "k 3"], Float64[np.ndarray, "k 3 3"]]:
    """Return bodies' masses, their centres in the links, and inertias about the links' origins."""
    mass, p_bc = np.zeros(len(bodies)), np.zeros((len(bodies), 3))
    about_body, x_lb = np.zeros((len(bodies), 3, 3)), np.zeros((len(bodies), 3, 4))
    for k, (index, _, pose) in enumerate(bodies):
        body: Any = model.plant.get_body(BodyIndex(index))
        inertia = body.CalcSpatialInertiaInBodyFrame(context)
        mass[k], p_bc[k] = inertia.get_mass(), inertia.get_com()
        about_body[k] = inertia.CalcRotationalInertia().CopyToFullMatrix3()
        x_lb[k] = pose.GetAsMatrix34()
    r_lb, scale = x_lb[:, :, :3], mass[:, None, None]
    center = np.einsum("kij,kj->ki", r_lb, p_bc) + x_lb[:, :, 3]
    about_center = about_body - scale * _point_inertia(p_bc)
    turned = np.einsum("kia,kab,kjb->kij", r_lb, about_center, r_lb)
    return mass, center, turned + scale * _point_inertia(center)


def _point_inertia(at: Float64[np.ndarray, "*n 3"]) -> Float64[np.ndarray, "*n 3 3"]:
    """Return the rotational inertia about the origin of a unit mass at a point, |p|^2 1 - p p^T."""
    return (at**2).sum(axis=-1)[..., None, None] * np.eye(3) - at[..., :, None] * at[..., None, :]


def _reflected_inertias(model: DrakeModel, context: Any) -> Float64[np.ndarray, " num_velocities"]:
    """Return the reflected inertia of the motor of every velocity."""
    plant = model.plant
    found = np.zeros(plant.num_velocities())
    for index in plant.GetJointActuatorIndices():
        actuator = plant.get_joint_actuator(index)
        joint = actuator.joint()
        begin = joint.velocity_start()
        found[begin : begin + joint.num_velocities()] += actuator.calc_reflected_inertia(context)
    return found
