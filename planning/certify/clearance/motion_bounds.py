"""MotionBounds: how far collision shapes move for bounded joint motion, at one configuration.

Let joint k rotate by at most a_k and translate by at most d_k from the reference instant t_m, and
let y(t) be a point of a shape in the joint's child frame, within m_{k+1} of y(t_m). In the parent
frame it is R(t) y(t) + p(t), and

    R(t) y(t) - R(t_m) y(t_m) = R(t) (y(t) - y(t_m)) + (R(t) - R(t_m)) y(t_m),

so it stays within m_k = m_{k+1} + 2 sin(a_k / 2) rho_k + d_k of its reference position, where rho_k
is the largest distance of the shape's points at t_m from the joint's axis (from its origin, for
rotations about any axis): a chord of a circle of radius rho_k. Summing from the tip to the common
ancestor of two shapes bounds the displacement of each relative to it, and the sum of both bounds
their approach. This is the bound of Schwarzer, Saha, Latombe, "Adaptive dynamic collision checking
for single and multiple articulated robots" (IEEE T-RO 21:3, 2005), with lever arms taken at the
present configuration instead of the worst one; the first term above, rotated by R(t) as a whole, is
why no product of a_k and m_{k+1} is needed. The argument holds as well for a joint that Drake runs
from child to parent: the inverse transform turns about the same axis by the same angle. So it holds
in the frame of a half space that a chain carries: there the other shape moves, by that chain run
backwards and then its own, and the lever arms of both chains are those of its points, as those of
the half space would be infinite.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64
from pydrake.multibody.tree import (
    PlanarJoint,
    PrismaticJoint,
    QuaternionFloatingJoint,
    RevoluteJoint,
)

from planning.certify.clearance.collision_shapes import CollisionShapes
from planning.domain.arrays import Array
from planning.domain.robot.joints import JointGroup, JointType
from planning.errors import ModelInvalid
from planning.world.drake_model import DrakeModel

# Kinds of error of a joint: in rotation, in translation.
_ERROR_KINDS = {
    JointType.REVOLUTE: (1.0, 0.0),
    JointType.CONTINUOUS: (1.0, 0.0),
    JointType.PRISMATIC: (0.0, 1.0),
    JointType.PLANAR: (1.0, 1.0),
    JointType.FLOATING: (1.0, 1.0),
}


@dataclass(frozen=True)
class MovingJoint:
    """A joint that moves with the group: one of the group's own, or a follower (mimic joint).

    Attributes:
        joint: Drake's joint.
        group_index: Index of the joint of the group that moves it.
        scale: Size of its displacement relative to that of the joint that moves it.
    """

    joint: Any
    group_index: int
    scale: float


class MotionBounds:
    """Bounds on the displacement of collision shapes by the joints of one group."""

    def __init__(self, model: DrakeModel, group: JointGroup, shapes: CollisionShapes) -> None:
        """Collect joint chains and lever arms, none of which depends on a configuration.

        Raises:
            ModelInvalid: A joint of a kind whose motion cannot be bounded.
        """
        self._shapes = shapes
        self._joints = moving_joints(model, group)
        self.chains = joint_chains(model, self._joints)
        self.is_carried_by = np.array(
            [[k in self.chains[body] for k in range(len(self._joints))] for body in shapes.bodies],
            dtype=bool,
        ).reshape(len(shapes.bodies), len(self._joints))
        offsets = [m.joint.frame_on_child().GetFixedPoseInBodyFrame() for m in self._joints]
        axes = [_axis(m.joint) for m in self._joints]
        self._p_bm = np.array([x.translation() for x in offsets]).reshape(-1, 3)
        self._axes_B = np.array([
            x.rotation().matrix() @ axis for x, axis in zip(offsets, axes, strict=True)
        ]).reshape(-1, 3)
        self.joint_bodies = np.array(
            [int(m.joint.child_body().index()) for m in self._joints], dtype=np.intp
        )
        self._group_indices = np.array([m.group_index for m in self._joints], dtype=np.intp)
        self._rotation_factors, self._translation_factors = _displacement_factors(self._joints)
        self._error_kinds = np.array([_ERROR_KINDS[joint.type] for joint in group.joints])

    def max_displacements(
        self,
        R_WB: Float64[np.ndarray, "num_bodies 3 3"],
        p_wb: Float64[np.ndarray, "num_bodies 3"],
        max_rotation: Float64[np.ndarray, " num_joints"],
        max_translation: Float64[np.ndarray, " num_joints"],
    ) -> Float64[np.ndarray, "num_shapes num_moving"]:
        """Return the largest displacement of each shape's points by each moving joint [m].

        A joint that does not carry a shape displaces it in the frame of the bodies that it carries.

        Args:
            R_WB: Orientations of all bodies at the reference instant.
            p_wb: Positions of all bodies [m].
            max_rotation: Largest rotation of each joint of the group from there [rad].
            max_translation: Largest translation of each joint of the group from there [m].
        """
        group_bounds = np.stack(
            [max_rotation[self._group_indices], max_translation[self._group_indices]], axis=1
        )
        rotations = np.einsum("kd,kd->k", self._rotation_factors, group_bounds)
        translations = np.einsum("kd,kd->k", self._translation_factors, group_bounds)
        chords = 2 * np.sin(np.minimum(rotations, np.pi) / 2)
        arms = self._lever_arms(R_WB, p_wb)
        by_rotation = np.where(chords > 0, arms, 0.0) * chords
        return by_rotation + translations

    def sensitivities(
        self, R_WB: Float64[np.ndarray, "num_bodies 3 3"], p_wb: Float64[np.ndarray, "num_bodies 3"]
    ) -> Float64[np.ndarray, "num_shapes num_moving"]:
        """Return the growth of each entry of `max_displacements` per joint error [m per rad or m].

        If every joint of the group rotates and translates by e more than its bounds, no entry of
        `max_displacements` grows by more than e times this.
        """
        rotations = np.einsum(
            "kd,kd->k", self._rotation_factors, self._error_kinds[self._group_indices]
        )
        translations = np.einsum(
            "kd,kd->k", self._translation_factors, self._error_kinds[self._group_indices]
        )
        arms = np.where(rotations > 0, self._lever_arms(R_WB, p_wb), 0.0)
        return arms * rotations + translations

    def _lever_arms(self, R_WB: Array, p_wb: Array) -> Array:
        """Return the largest distance of each shape's points from each joint's axis or origin."""
        shapes, own = self._shapes, self.joint_bodies
        centers = np.einsum("sij,sj->si", R_WB[shapes.bodies], shapes.centers) + p_wb[shapes.bodies]
        origins = np.einsum("kij,kj->ki", R_WB[own], self._p_bm) + p_wb[own]
        axes = np.einsum("kij,kj->ki", R_WB[own], self._axes_B)
        away = centers[:, None, :] - origins[None]
        along = np.einsum("skx,kx->sk", away, axes)
        squares = np.einsum("skx,skx->sk", away, away) - along**2
        return np.sqrt(np.maximum(squares, 0.0)) + shapes.radii[:, None]


def moving_joints(model: DrakeModel, group: JointGroup) -> list[MovingJoint]:
    """Return the group's joints and all their followers, direct or indirect."""
    plant = model.plant
    joints = [plant.get_joint(model.joint_indices[joint.name]) for joint in group.joints]
    moving = [MovingJoint(joint, i, 1.0) for i, joint in enumerate(joints)]
    by_velocity = {m.joint.velocity_start(): m for m in moving}
    by_start = {plant.get_joint(i).velocity_start(): plant.get_joint(i) for i in _moveable(plant)}
    for c in model.followers_of(group):
        source = by_velocity[c.leader_velocity]
        scale = source.scale * abs(c.multiplier)
        joint = by_start[c.follower_velocity]
        by_velocity[c.follower_velocity] = MovingJoint(joint, source.group_index, scale)
    return list(by_velocity.values())


def _moveable(plant: Any) -> list[Any]:
    return [i for i in plant.GetJointIndices() if plant.get_joint(i).num_velocities() > 0]


def joint_chains(model: DrakeModel, moving: list[MovingJoint]) -> dict[int, frozenset[int]]:
    """Return, for every body, the moving joints between it and the world."""
    plant = model.plant
    ordinal = {int(m.joint.index()): k for k, m in enumerate(moving)}
    links: dict[int, list[tuple[int, int]]] = {}
    for index in plant.GetJointIndices():
        joint = plant.get_joint(index)
        a, b = int(joint.parent_body().index()), int(joint.child_body().index())
        links.setdefault(a, []).append((b, int(index)))
        links.setdefault(b, []).append((a, int(index)))
    world = int(plant.world_body().index())
    chains = {world: frozenset[int]()}
    frontier = [world]
    while frontier:
        body = frontier.pop()
        for neighbour, index in links.get(body, []):
            if neighbour not in chains:
                here = {ordinal[index]} if index in ordinal else set[int]()
                chains[neighbour] = chains[body] | here
                frontier.append(neighbour)
    return chains


def _axis(joint: Any) -> Array:
    """Return the rotation axis of a joint in its own frame; zero if it has none."""
    match joint:
        case RevoluteJoint():
            return np.array(joint.revolute_axis())
        case PlanarJoint():
            return np.array([0.0, 0.0, 1.0])
        case PrismaticJoint() | QuaternionFloatingJoint():
            return np.zeros(3)
        case _:
            message = f"joint {joint.name()!r} of kind {joint.type_name()!r} cannot be certified"
            raise ModelInvalid(message, {"joint": joint.name(), "reason": message})


def _displacement_factors(joints: list[MovingJoint]) -> tuple[Array, Array]:
    """Return factors from a group joint's rotation and translation to those of each moving joint.

    A follower has the multiple of its leader's coordinate, whether either is an angle or a length.
    """
    rotation_factors, translation_factors = np.zeros((len(joints), 2)), np.zeros((len(joints), 2))
    for k, moving in enumerate(joints):
        match moving.joint:
            case RevoluteJoint():
                rotation_factors[k] = moving.scale
            case PrismaticJoint():
                translation_factors[k] = moving.scale
            case _:
                rotation_factors[k, 0] = translation_factors[k, 1] = moving.scale
    return rotation_factors, translation_factors
