"""Grips: grippers of a simulation that hold objects by friction, and how those move in them."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64
from pydrake.math import RigidTransform

from planning.domain.arrays import Array
from planning.domain.geometry.pose import Pose
from planning.domain.geometry.touching_pair import TouchingPair
from planning.domain.scene.grip import Grip
from planning.domain.scene.held_pose import HeldPose
from planning.domain.scene.scene import SceneObject
from planning.world.loading.builder import pose_of
from planning.world.mechanics.grippers import require_gripper
from planning.world.mechanics.joint_followers import joint_followers
from planning.world.mechanics.simulation_world import touched_bodies
from planning.world.world import World


@dataclass(frozen=True, eq=False)
class _Held:
    """An object in a gripper.

    Attributes:
        thing: The object, whose pose is the one that proofs take it to have.
        grip: How it is held.
        joint: Drake's floating joint between the frame that it is attached to and the object.
        corners: Of its bounding box, in its frame [m], shape (8, 3).
        body: Drake's of the object.
        leader: Velocity coordinate of the gripper's joint.
        fingers: Velocity coordinates of all fingers.
        closing: Force along the leader that presses every finger with the grip's [N].
    """

    thing: SceneObject
    grip: Grip
    joint: Any
    body: Any
    corners: Array
    leader: int
    fingers: tuple[int, ...]
    closing: float


class Grips:
    """Objects that are free bodies of a simulation, between fingers that a force closes."""

    def __init__(self, world: World, held: tuple[SceneObject, ...]) -> None:
        """Take a world in which the objects float, as `simulation_world` makes it."""
        self._model = world.drake
        self._held = [_held(world, thing) for thing in held]
        self._objects = [
            index
            for each in self._held
            for index in _range(each.joint.velocity_start(), each.joint.num_velocities())
        ]
        self._touching = frozenset(
            frozenset((thing.name, body))
            for thing in held
            for body in touched_bodies(world.drake, thing.name)
        )

    @property
    def fingers(self) -> frozenset[int]:
        """Velocity coordinates of all fingers: they follow forces, and no positions."""
        return frozenset(index for each in self._held for index in each.fingers)

    def hold_still(self, context: Any) -> None:
        """Put the objects where proofs have them, at rest in their grippers."""
        for each in self._held:
            each.joint.SetPose(context, RigidTransform(each.thing.pose.matrix))
            each.joint.set_angular_velocity(context, np.zeros(3))
            each.joint.set_translational_velocity(context, np.zeros(3))

    def lock(self, context: Any) -> None:
        """Hold the objects where they are, whatever touches them."""
        for each in self._held:
            each.joint.Lock(context)

    def unlock(self, context: Any) -> None:
        """Let them move."""
        for each in self._held:
            each.joint.Unlock(context)

    def apply(self, tau: Float64[np.ndarray, " nv"]) -> None:
        """Close the fingers by their forces, and leave the objects to what touches them.

        Drake couples the followers with their leader, which has the force of all.
        """
        tau[self._objects] = 0.0
        for each in self._held:
            tau[list(each.fingers)] = 0.0
            tau[each.leader] = -each.closing

    def poses(self, context: Any) -> tuple[HeldPose, ...]:
        """Return where the objects are, by the plant's context."""
        return tuple(_measured(each, context) for each in self._held)

    def counted(self, contacts: Iterable[TouchingPair], context: Any) -> list[TouchingPair]:
        """Return the contacts but for those by which objects are held, and those of lost ones."""
        lost = {pose.name for pose in self.poses(context) if pose.is_lost}
        return [
            pair
            for pair in contacts
            if frozenset(pair.bodies) not in self._touching and lost.isdisjoint(pair.bodies)
        ]


def _measured(each: _Held, context: Any) -> HeldPose:
    attached = each.thing.attached
    frame = "" if attached is None else attached.frame
    x_fo = pose_of(each.joint.GetPose(context))
    moved = _placed(x_fo, each.corners) - _placed(each.thing.pose, each.corners)
    slip = float(np.linalg.norm(moved, axis=1).max())
    x_wo = pose_of(each.body.EvalPoseInWorld(context))
    return HeldPose(each.thing.name, frame, x_fo, x_wo, slip, each.grip.slip)


def _placed(pose: Pose, points: Array) -> Array:
    matrix = pose.matrix
    return points @ matrix[:3, :3].T + matrix[:3, 3]


def _held(world: World, thing: SceneObject) -> _Held:
    model, plant = world.drake, world.drake.plant
    if thing.attached is None or thing.attached.grip is None:
        message = f"{thing.name} is not held by contact"
        raise AssertionError(message)
    grip = thing.attached.grip
    gripper = require_gripper(world, world.group(grip.gripper))
    leader = plant.get_joint(model.joint_indices[gripper.joint]).velocity_start()
    followers = [each.joint.velocity_start() for each in joint_followers(model, gripper.joint)]
    (joint,) = (
        joint
        for joint in map(plant.get_joint, plant.GetJointIndices())
        if joint.child_body().index() == model.bodies[thing.name]
    )
    body = plant.get_body(model.bodies[thing.name])
    (geometry,) = plant.GetCollisionGeometriesForBody(body)
    box: Any = model.scene_graph.model_inspector().GetObbInGeometryFrame(geometry)
    corners = _corners(np.array(box.half_width()), np.array(box.pose().GetAsMatrix4()))
    closing = grip.force * gripper.travel
    return _Held(thing, grip, joint, body, corners, leader, (leader, *followers), closing)


def _corners(half: Array, x_go: Array) -> Array:
    signs = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, -1).T
    return (signs * half) @ x_go[:3, :3].T + x_go[:3, 3]


def _range(first: int, count: int) -> range:
    return range(first, first + count)
