"""Fingerprint: what a world is to a group that moves in it, as one short text.

Two worlds with the same fingerprint collide for the same configurations of the group. Names of
frames, named configurations and where the group itself stands have no part in it, so a robot that
has moved still knows the world; what is held, where other robots stand and the robot's own files
have.
"""

from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from pydrake.geometry import Role
from pydrake.planning import RobotDiagram

from planning.domain.joints import JointGroup
from planning.domain.manifold import Manifold
from planning.domain.value import digest
from planning.world.convex_shapes import convex_shape
from planning.world.world import World

type Array = np.ndarray[Any, np.dtype[np.float64]]

# Where bodies are is compared at so many configurations of the group: two kinematic chains that
# agree at these agree everywhere, but for accidents of measure zero.
_NUM_PROBES = 4


_known: WeakKeyDictionary[RobotDiagram, dict[str, str]] = WeakKeyDictionary()


def collision_fingerprint(world: World, group: JointGroup) -> str:
    """Return the sha256 of shapes, which of them may touch, and where the group takes them."""
    known = _known.setdefault(world.drake.diagram, {})
    if group.name not in known:
        known[group.name] = _taken(world, group)
    return known[group.name]


def _taken(world: World, group: JointGroup) -> str:
    inspector = world.drake.scene_graph.model_inspector()
    ids = sorted(
        inspector.GetAllGeometryIds(Role.kProximity), key=lambda geometry: geometry.get_value()
    )
    place = {geometry: row for row, geometry in enumerate(ids)}
    pairs = sorted(
        tuple(sorted((place[a], place[b]))) for a, b in inspector.GetCollisionCandidates()
    )
    return digest((
        [_geometry(world, inspector, geometry) for geometry in ids],
        np.array(pairs, dtype=np.int32),
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
