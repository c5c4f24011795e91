"""How far the points of each body can move while joints move by known amounts.

Let joint k turn by at most dtheta_k, and let every point x of body B move by at most m_{k+1}
within joint k's child frame. If rho_k is the largest distance of B's points from the joint's axis
at the reference instant, then within the joint's parent frame

    |R(dtheta) x(t) - x(t_m)| <= dtheta_k (rho_k + m_{k+1}) + m_{k+1} = m_k,

since x(t) is within m_{k+1} of x(t_m), so within rho_k + m_{k+1} of the axis, and an arc is longer
than its chord. A prismatic joint adds its travel; planar and floating joints add theirs and turn
about their own origin. Summing from the tip to the root bounds B's motion relative to each of its
ancestors (the bound of Schwarzer, Saha, Latombe, "Adaptive dynamic collision checking for single
and multiple articulated robots", 2005, with lever arms taken at the present configuration).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64
from pydrake.multibody.tree import BodyIndex, PrismaticJoint, RevoluteJoint

from planning.certify.bounding_spheres import BoundingSpheres, bounding_spheres
from planning.domain.joints import JointGroup
from planning.world.drake_model import DrakeModel

type Array = np.ndarray[Any, np.dtype[np.float64]]


@dataclass(frozen=True)
class _MovingJoint:
    """A joint that moves with the group, and where its displacement is found.

    Attributes:
        joint: Drake's.
        turn: Indices into the group's v whose norm is its rotation [rad].
        shift: Indices into the group's v whose norm is its translation [m].
        scale: What a mimic joint multiplies its leader's displacement by.
    """

    joint: Any
    turn: tuple[int, ...]
    shift: tuple[int, ...]
    scale: float


class MotionBounds:
    """Bounds on body motion for one group of one model."""

    def __init__(self, model: DrakeModel, group: JointGroup) -> None:
        """Read the tree; nothing here depends on a configuration."""
        self.spheres: BoundingSpheres = bounding_spheres(model)
        self._model = model
        self._joints = _moving_joints(model, group)
        self._plant = model.plant
        chains = [self._chain(body) for body in self.spheres.bodies]
        self.chains: dict[BodyIndex, tuple[int, ...]] = dict(
            zip(self.spheres.bodies, chains, strict=True)
        )
        self.row = {body: i for i, body in enumerate(self.spheres.bodies)}
        depth = max((len(chain) for chain in chains), default=0)
        self._chain_table = np.full((len(chains), depth), -1)
        for i, chain in enumerate(chains):
            self._chain_table[i, : len(chain)] = chain
        offsets = [m.joint.frame_on_child().GetFixedPoseInBodyFrame() for m in self._joints]
        self._p_bm = np.array([x.translation() for x in offsets]).reshape(-1, 3)
        self._axes_b = np.array([
            x.rotation().multiply(_axis(m.joint))
            for m, x in zip(self._joints, offsets, strict=True)
        ]).reshape(-1, 3)
        self._has_axis = np.array([_has_axis(m.joint) for m in self._joints], dtype=bool)
        self._sphere_rows = np.repeat(
            np.arange(len(chains)),
            np.diff(np.append(self.spheres.first, len(self.spheres.radii))),
        )

    def relative_depth(self, a: BodyIndex, b: BodyIndex) -> int:
        """Return how many moving joints the chains of two bodies share, from the root."""
        shared = 0
        for one, other in zip(self.chains[a], self.chains[b], strict=False):
            if one != other:
                break
            shared += 1
        return shared

    def displacements(self, delta: Float64[np.ndarray, " nv"]) -> tuple[Array, Array]:
        """Return turn [rad] and shift [m] of every moving joint, from those of the group's v."""
        turn = np.array([abs(m.scale) * np.linalg.norm(delta[list(m.turn)]) for m in self._joints])
        shift = np.array([
            abs(m.scale) * np.linalg.norm(delta[list(m.shift)]) for m in self._joints
        ])
        return turn, shift

    def motions(self, context: Any, delta: Float64[np.ndarray, " nv"]) -> Array:
        """Return how far each body can move, shape (num_bodies, depth + 1) [m].

        Entry [b, d] is relative to the parent of the d-th joint of b's chain: [b, 0] is relative
        to the world, and entries at or beyond the chain's length are 0.

        Args:
            context: Of the plant, at the reference configuration.
            delta: Largest displacement of each of the group's velocity coordinates from there.
        """
        turn, shift = self.displacements(delta)
        arms = self._lever_arms(context)
        table = self._chain_table
        rows = np.arange(len(table))
        motions = np.zeros((len(table), table.shape[1] + 1))
        for d in range(table.shape[1] - 1, -1, -1):
            joint = table[:, d]
            inner = motions[:, d + 1]
            with np.errstate(invalid="ignore"):
                moved = inner + shift[joint] + turn[joint] * (arms[rows, joint] + inner)
            motions[:, d] = np.where(joint >= 0, moved, 0.0)
        return np.nan_to_num(motions, nan=0.0, posinf=np.inf)

    def _lever_arms(self, context: Any) -> Array:
        """Return the largest distance of each body's points from each joint's axis or origin."""
        centers = np.empty((len(self._sphere_rows), 3))
        first = np.append(self.spheres.first, len(self._sphere_rows))
        for i, body in enumerate(self.spheres.bodies):
            x_wb = self._plant.EvalBodyPoseInWorld(context, self._plant.get_body(body))
            own = slice(first[i], first[i + 1])
            rotation = x_wb.rotation().matrix()
            centers[own] = self.spheres.centers[own] @ rotation.T + x_wb.translation()
        origins = np.empty((len(self._joints), 3))
        axes = np.empty((len(self._joints), 3))
        for k, moving in enumerate(self._joints):
            x_wb = self._plant.EvalBodyPoseInWorld(context, moving.joint.child_body())
            rotation = x_wb.rotation().matrix()
            origins[k] = rotation @ self._p_bm[k] + x_wb.translation()
            axes[k] = rotation @ self._axes_b[k]
        away = centers[:, None, :] - origins[None]
        squares = np.einsum("skx,skx->sk", away, away)
        along = np.einsum("skx,kx->sk", away, axes) * self._has_axis
        distances = np.sqrt(np.maximum(squares - along**2, 0.0)) + self.spheres.radii[:, None]
        return np.maximum.reduceat(distances, self.spheres.first, axis=0)

    def _chain(self, body: BodyIndex) -> tuple[int, ...]:
        """Return the moving joints from the world to a body."""
        by_child = {
            self._plant.get_joint(index).child_body().index(): self._plant.get_joint(index)
            for index in self._plant.GetJointIndices()
        }
        ordinals = {int(m.joint.index()): k for k, m in enumerate(self._joints)}
        chain: list[int] = []
        while body in by_child:
            joint = by_child[body]
            if int(joint.index()) in ordinals:
                chain.append(ordinals[int(joint.index())])
            body = joint.parent_body().index()
        return tuple(reversed(chain))


def _moving_joints(model: DrakeModel, group: JointGroup) -> list[_MovingJoint]:
    moving: list[_MovingJoint] = []
    by_velocity: dict[int, int] = {}
    offset = 0
    for member in group.joints:
        joint = model.plant.get_joint(model.joint_indices[member.name])
        indices = tuple(range(offset, offset + joint.num_velocities()))
        by_velocity[joint.velocity_start()] = offset
        moving.append(_MovingJoint(joint, *_turn_and_shift(joint, indices), 1.0))
        offset += joint.num_velocities()
    by_start = {
        model.plant.get_joint(i).velocity_start(): model.plant.get_joint(i)
        for i in model.joint_indices.values()
    }
    for follower, leader, multiplier in model.mimics:
        if leader in by_velocity:
            joint = by_start[follower]
            parts = _turn_and_shift(joint, (by_velocity[leader],))
            moving.append(_MovingJoint(joint, *parts, multiplier))
    return moving


def _turn_and_shift(
    joint: Any, indices: tuple[int, ...]
) -> tuple[tuple[int, ...], tuple[int, ...]]:
    match joint:
        case RevoluteJoint():
            return indices, ()
        case PrismaticJoint():
            return (), indices
        case _ if len(indices) == 3:
            return indices[2:], indices[:2]
        case _:
            return indices[:3], indices[3:]


def _axis(joint: Any) -> Array:
    return joint.revolute_axis() if isinstance(joint, RevoluteJoint) else np.array([0.0, 0.0, 1.0])


def _has_axis(joint: Any) -> bool:
    """Whether the joint turns about a line; floating joints turn about a point."""
    return joint.num_velocities() in (1, 3)
