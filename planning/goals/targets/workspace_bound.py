"""WorkspaceBound: ball in world that bounds the reachable positions of a tool frame's origin."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.robot.joints import JointGroup
from planning.domain.value import Value
from planning.world.kernel.link_tree import WORLD, KernelLink, LinkKind, LinkTree, link_tree
from planning.world.world import World

# Range of unbounded coordinates about their present value [m]; the same as in `Seeds`.
_UNBOUNDED_RANGE = 2.0


@dataclass(frozen=True, eq=False)
class WorkspaceBound(Value):
    """Ball that bounds the reachable positions of a frame's origin.

    Attributes:
        center: Center in world [m], shape (3,).
        radius: Radius [m].
    """

    center: Float64[np.ndarray, "3"]
    radius: float


def workspace_bound(world: World, group: JointGroup, frame: str) -> WorkspaceBound:
    """Return a ball about the group's first joint that bounds the positions of a frame's origin.

    Its radius is the sum of the link lengths from joint to joint and of the travel of prismatic,
    planar and floating joints. Not promised: the smallest ball. Where the scene has joints of
    kinds that the kernel does not model, it is a ball of 2 m about the present position.
    """
    drake = world.drake
    tree = link_tree(drake)
    position = world.frame_pose(frame, world.state).position
    if tree is None:
        return WorkspaceBound(position, _UNBOUNDED_RANGE)
    tool = drake.frame(frame)
    link, x_lb = tree.bodies[int(tool.body)]
    p_lt = x_lb.multiply(tool.pose_in_body).translation()
    moving = _moving_positions(world, group)
    path = _path(tree, link, moving)
    if not path:
        return WorkspaceBound(position, 0.0)
    extents = _extents(world, group)
    radius = float(np.linalg.norm(p_lt)) + sum(_travel(one, extents) for one in path)
    radius += sum(float(np.linalg.norm(one.X_PF.translation())) for one in path[1:])
    return WorkspaceBound(_origin(world, tree, path[0]), radius)


def _moving_positions(world: World, group: JointGroup) -> set[int]:
    """Return the indices of the plant's positions that move with the group, followers included."""
    moving = {int(i) for i in world.drake.position_indices(group)}
    return moving | {c.follower_position for c in world.drake.followers_of(group)}


def _path(tree: LinkTree, link: int, moving: set[int]) -> list[KernelLink]:
    """Return the chain of links from the first one that moves with the group to the frame's."""
    path: list[KernelLink] = []
    while link != WORLD:
        path.insert(0, tree.links[link])
        link = tree.links[link].parent
    while path and path[0].position not in moving:
        path.pop(0)
    return path


def _extents(world: World, group: JointGroup) -> Array:
    """Return the largest magnitude of each position coordinate of the plant [rad or m]."""
    extents = np.abs(world.state)
    limits = world.limits(group)
    indices = world.drake.position_indices(group)
    bounds = np.maximum(np.abs(limits.lower), np.abs(limits.upper))
    extents[indices] = np.where(np.isfinite(bounds), bounds, extents[indices] + _UNBOUNDED_RANGE)
    for c in world.drake.couplings:
        extent = abs(c.multiplier) * extents[c.leader_position] + abs(c.offset)
        extents[c.follower_position] = max(extents[c.follower_position], extent)
    return extents


def _travel(link: KernelLink, extents: Array) -> float:
    """Return the largest translation of a link by its own joint [m]."""
    match link.kind:
        case LinkKind.PRISMATIC:
            return float(extents[link.position])
        case LinkKind.PLANAR:
            return float(np.linalg.norm(extents[link.position : link.position + 2]))
        case LinkKind.FLOATING:
            return float(np.linalg.norm(extents[link.position + 4 : link.position + 7]))
        case LinkKind.REVOLUTE:
            return 0.0


def _origin(world: World, tree: LinkTree, first: KernelLink) -> Array:
    """Return the origin of the first joint's parent frame, in world [m]; it does not move."""
    if first.parent == WORLD:
        return np.array(first.X_PF.translation())
    bodies = world.drake.bodies
    name = next(n for n, body in bodies.items() if tree.bodies[int(body)][0] == first.parent)
    x_wb = world.frame_pose(name, world.state).matrix
    p_bf = tree.bodies[int(bodies[name])][1].inverse().multiply(first.X_PF).translation()
    return x_wb[:3, :3] @ p_bf + x_wb[:3, 3]
