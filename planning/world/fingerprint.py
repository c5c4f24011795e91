"""Fingerprint: what a world is to a group that moves in it, as one short text.

Two worlds with the same fingerprint collide for the same configurations of the group. Names of
frames, named configurations and where the group itself stands have no part in it, so a robot that
has moved still knows the world; what is held, where other robots stand and the robot's own files
have.
"""

from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from planning.domain.robot.joints import JointGroup
from planning.domain.robot.manifold import Manifold
from planning.domain.value import digest
from planning.world.collision.shape_pairs import candidates_of
from planning.world.collision.static_objects import StaticObjects
from planning.world.kernel.convex_shapes import convex_shape
from planning.world.world import World

type Array = np.ndarray[Any, np.dtype[np.float64]]

# Where bodies are is compared at so many configurations of the group: two kinematic chains that
# agree at these agree everywhere, but for accidents of measure zero.
_NUM_PROBES = 4


_known: WeakKeyDictionary[StaticObjects, dict[str, str]] = WeakKeyDictionary()


def collision_fingerprint(world: World, group: JointGroup) -> str:
    """Return the sha256 of shapes, which of them may touch, and where the group takes them."""
    known = _known.setdefault(world.drake.standing, {})
    if group.name not in known:
        known[group.name] = _taken(world, group)
    return known[group.name]


def _taken(world: World, group: JointGroup) -> str:
    inspector = world.drake.scene_graph.model_inspector()
    candidates, standing = candidates_of(world.drake), world.drake.standing
    ids = candidates.ids[: candidates.num_of_drake]
    alone = [
        [thing.name, x.GetAsMatrix34(), shape]
        for thing, x, shape in zip(standing.things, standing.poses, standing.shapes, strict=True)
    ]
    return digest((
        [_geometry(world, inspector, geometry) for geometry in ids] + alone,
        candidates.rows.astype(np.int32),
        list(group.position_names),
        _body_poses(world, group),
        world.drake.owners,
    ))


def _geometry(world: World, inspector: Any, geometry: Any) -> list[Any]:
    body = world.drake.plant.GetBodyFromFrameId(inspector.GetFrameId(geometry))
    shape = inspector.GetShape(geometry)
    known = convex_shape(shape)
    return [
        world.drake.body_names.get(body.index(), body.name()),
        inspector.GetPoseInFrame(geometry).GetAsMatrix34(),
        str(shape) if known is None else known,
    ]


def _body_poses(world: World, group: JointGroup) -> Array:
    """Return X_WB of every body at each probe, shape (probes, bodies, 3, 4)."""
    plant = world.drake.plant
    context = plant.CreateDefaultContext()
    poses: list[list[Array]] = []
    for full in world.embed(group, probes(group)):
        plant.SetPositions(context, full)
        poses.append([
            plant.EvalBodyPoseInWorld(context, plant.get_body(index)).GetAsMatrix34()
            for index in world.drake.body_names
        ])
    return np.array(poses)


def probes(group: JointGroup) -> Array:
    """Return configurations of no special meaning, shape (probes, nq)."""
    numbers = np.random.default_rng(0).uniform(0.1, 1.0, (_NUM_PROBES, group.num_positions))
    return Manifold(group.joints).normalized(numbers)
