"""LinkTree: kinematic tree of a Drake plant for the kernel, with welded bodies merged."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import (
    JointIndex,
    PlanarJoint,
    PrismaticJoint,
    QuaternionFloatingJoint,
    RevoluteJoint,
    WeldJoint,
)
from pydrake.planning import RobotDiagram

from planning.domain.arrays import Array
from planning.world.drake_model import DrakeModel

WORLD = -1


class LinkKind(StrEnum):
    """Kinds of joints; each name is also one of the kernel's JointKind (kinds.hpp)."""

    REVOLUTE = "revolute"
    PRISMATIC = "prismatic"
    PLANAR = "planar"
    FLOATING = "floating"


@dataclass(frozen=True)
class KernelLink:
    """Link L of the tree; its frame is the moving frame of its parent joint.

    Attributes:
        parent: An earlier link, or WORLD.
        X_PF: Pose of the joint's fixed frame F in the parent link.
        kind: Of that joint.
        axis: Of a revolute or prismatic joint, in F, shape (3,).
        position: First index of its coordinates in the plant's q.
        velocity: First index in the plant's v.
    """

    parent: int
    X_PF: RigidTransform
    kind: LinkKind
    axis: Array
    position: int
    velocity: int


@dataclass(frozen=True)
class LinkTree:
    """Moving links of a plant, and the link of each body.

    Attributes:
        links: Parents first.
        bodies: For every body's index, the link that it belongs to and X_LB.
    """

    links: tuple[KernelLink, ...]
    bodies: dict[int, tuple[int, RigidTransform]]


_cache: WeakKeyDictionary[RobotDiagram, LinkTree | None] = WeakKeyDictionary()


def link_tree(model: DrakeModel) -> LinkTree | None:
    """Return the tree of a model's plant, cached by model.

    None if it has a joint of a kind that the kernel does not have.
    """
    if model.diagram not in _cache:
        _cache[model.diagram] = _build_tree(model.plant)
    return _cache[model.diagram]


def _build_tree(plant: MultibodyPlant) -> LinkTree | None:
    joints_of_body: dict[int, list[Any]] = {}
    joints: list[Any] = [plant.get_joint(JointIndex(int(i))) for i in plant.GetJointIndices()]
    for joint in joints:
        for body in (joint.parent_body(), joint.child_body()):
            joints_of_body.setdefault(int(body.index()), []).append(joint)
    world = int(plant.world_body().index())
    bodies = {world: (WORLD, RigidTransform())}
    links: list[KernelLink] = []
    frontier = [world]
    while frontier:
        current = frontier.pop(0)
        for joint in joints_of_body.get(current, []):
            is_forward = int(joint.parent_body().index()) == current
            other = int((joint.child_body() if is_forward else joint.parent_body()).index())
            if other in bodies:
                continue
            link_and_pose = _traverse_joint(joint, bodies[current], links, is_forward=is_forward)
            if link_and_pose is None:
                return None
            bodies[other] = link_and_pose
            frontier.append(other)
    return LinkTree(tuple(links), bodies)


def _traverse_joint(
    joint: Any,
    link_and_pose: tuple[int, RigidTransform],
    links: list[KernelLink],
    *,
    is_forward: bool,
) -> tuple[int, RigidTransform] | None:
    """Return the link and X_LB of the body on the other side of a joint, adding a link if needed.

    A joint that is traversed from child to parent turns and slides the other way.
    """
    frames = (joint.frame_on_parent(), joint.frame_on_child())
    near_frame, far_frame = frames if is_forward else frames[::-1]
    parent, x_lb = link_and_pose
    x_lf = x_lb.multiply(near_frame.GetFixedPoseInBodyFrame())
    x_fb = far_frame.GetFixedPoseInBodyFrame().inverse()
    sign = 1.0 if is_forward else -1.0
    match joint:
        case WeldJoint():
            x_fm = joint.X_FM() if is_forward else joint.X_FM().inverse()
            return parent, x_lf.multiply(x_fm).multiply(x_fb)
        case RevoluteJoint():
            kind, axis = LinkKind.REVOLUTE, sign * np.array(joint.revolute_axis())
        case PrismaticJoint():
            kind, axis = LinkKind.PRISMATIC, sign * np.array(joint.translation_axis())
        case PlanarJoint() if is_forward:
            kind, axis = LinkKind.PLANAR, np.zeros(3)
        case QuaternionFloatingJoint() if is_forward:
            kind, axis = LinkKind.FLOATING, np.zeros(3)
        case _:
            return None
    links.append(
        KernelLink(parent, x_lf, kind, axis, joint.position_start(), joint.velocity_start())
    )
    return len(links) - 1, x_fb
