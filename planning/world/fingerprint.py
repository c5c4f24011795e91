"""Collision fingerprint: digest of a world's collision geometry as one group sees it.

Two worlds with the same fingerprint collide for the same configurations of the group. Names of
frames, named configurations and the group's own position do not enter, so a robot that has moved
has the same fingerprint; attached objects, the positions of other robots and the robot's own files
do.
"""

from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from planning.domain.arrays import Array
from planning.domain.robot.joints import JointGroup
from planning.domain.robot.manifold import Manifold
from planning.domain.value import digest
from planning.world.collision.collision_pairs import collision_pairs_of
from planning.world.collision.static_objects import StaticObjects
from planning.world.kernel.convex_shapes import convex_shape
from planning.world.world import World

# Number of configurations at which body poses are compared: two kinematic chains that agree at
# these agree everywhere, except on a set of measure zero.
_NUM_PROBE_CONFIGURATIONS = 4


_cache: WeakKeyDictionary[StaticObjects, dict[tuple[str, ...], str]] = WeakKeyDictionary()


def collision_fingerprint(world: World, group: JointGroup) -> str:
    """Return the sha256 of shapes, collision filters, and body poses over the group's motion."""
    fingerprints = _cache.setdefault(world.drake.static_objects, {})
    # By its joints: scenes that share an engine may give one name to different groups.
    key = group.position_names
    if key not in fingerprints:
        fingerprints[key] = _compute_fingerprint(world, group)
    return fingerprints[key]


def _compute_fingerprint(world: World, group: JointGroup) -> str:
    inspector = world.drake.scene_graph.model_inspector()
    candidates, static_objects = collision_pairs_of(world.drake), world.drake.static_objects
    ids = candidates.ids[: candidates.num_drake_shapes]
    static_shapes = [
        [thing.name, x.GetAsMatrix34(), shape]
        for thing, x, shape in zip(
            static_objects.objects, static_objects.poses, static_objects.shapes, strict=True
        )
    ]
    return digest((
        [_geometry(world, inspector, geometry) for geometry in ids] + static_shapes,
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
    """Return X_WB of every body at each probe configuration, shape (probes, bodies, 3, 4)."""
    plant = world.drake.plant
    context = plant.CreateDefaultContext()
    poses: list[list[Array]] = []
    for full in world.embed(group, probe_configurations(group)):
        plant.SetPositions(context, full)
        poses.append([
            plant.EvalBodyPoseInWorld(context, plant.get_body(index)).GetAsMatrix34()
            for index in world.drake.body_names
        ])
    return np.array(poses)


def probe_configurations(group: JointGroup) -> Array:
    """Return arbitrary fixed configurations, shape (probes, nq)."""
    numbers = np.random.default_rng(0).uniform(
        0.1, 1.0, (_NUM_PROBE_CONFIGURATIONS, group.num_positions)
    )
    return Manifold(group.joints).normalized(numbers)
