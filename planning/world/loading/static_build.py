"""Static objects outside of Drake's model: their selection, and the tables made of them."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from pydrake.geometry import GeometryId
from pydrake.math import RigidTransform

from planning.domain.geometry import rotation
from planning.domain.geometry.pose import Pose
from planning.domain.geometry.shapes import HalfSpace, Mesh
from planning.domain.scene.scene import Scene, SceneFrame, SceneObject
from planning.errors import SceneInvalid
from planning.kernel.shape import ConvexShape
from planning.world.collision.static_objects import StaticObjects
from planning.world.files.mesh_check import validate_mesh
from planning.world.files.stored_scene import StoredScene
from planning.world.kernel.convex_shapes import convex_shape
from planning.world.loading.drake_shapes import drake_shape


def static_object_names(scene: Scene) -> frozenset[str]:
    """Return the names of the objects that stay out of Drake's model.

    They are all that are fixed to the world: moving one must not rebuild the model. Half spaces
    are not among them, as they have no bounds: Drake's model has them as bodies without collision
    geometry (`DrakeModel.half_spaces`).
    """
    return frozenset(
        thing.name
        for thing in scene.objects
        if thing.attached is None and not isinstance(thing.shape, HalfSpace)
    )


def make_static_objects(stored: StoredScene, names: frozenset[str]) -> StaticObjects:
    """Return the objects of these names as tables.

    Raises:
        SceneInvalid: One does not load; evidence has its `path`.
        ModelInvalid: A mesh refers to elements outside of its file.
        AssetNotFound: The file of a mesh does not exist any more.
    """
    scene = stored.scene
    things: list[SceneObject] = []
    drake_shapes: list[Any] = []
    shapes: list[ConvexShape] = []
    for i, thing in enumerate(scene.objects):
        if thing.name in names:
            things.append(stored.stored_object(thing))
            drake, convex = _shape(things[-1], f"objects.{i}.shape")
            drake_shapes.append(drake)
            shapes.append(convex)
    poses = transforms([thing.pose for thing in things])
    return StaticObjects(
        objects=tuple(things),
        ids=tuple(GeometryId.get_new_id() for _ in things),
        drake_shapes=tuple(drake_shapes),
        shapes=tuple(shapes),
        poses=poses,
        frames=static_frames(things, poses, scene.frames),
        allowed=_allowed_pairs(scene, names),
    )


def transforms(poses: Sequence[Pose]) -> tuple[RigidTransform, ...]:
    """Return poses as Drake's transforms, the same to the bit as one by one."""
    x = np.tile(np.eye(4), (len(poses), 1, 1))
    if poses:
        x[:, :3, :3] = rotation.matrix(np.array([pose.quaternion for pose in poses]))
        x[:, :3, 3] = [pose.position for pose in poses]
    return tuple(map(RigidTransform, x))


def static_frames(
    things: Sequence[SceneObject],
    poses: Sequence[RigidTransform],
    frames: Sequence[SceneFrame],
) -> Mapping[str, RigidTransform]:
    """Return X_WF of objects, and of the frames below them, directly or through others."""
    poses_W = {thing.name: x for thing, x in zip(things, poses, strict=True)}
    children: dict[str, list[SceneFrame]] = {}
    for frame in frames:
        children.setdefault(frame.parent, []).append(frame)
    # The frame's pose in its object is multiplied first, as in Drake, for results that are equal to
    # the bit.
    above = poses_W.items() if children else ()
    pending = [(name, x, RigidTransform()) for name, x in above if name in children]
    while pending:
        parent, x_wo, x_op = pending.pop()
        for frame in children.get(parent, []):
            if frame.name in poses_W:
                continue  # its name is taken, which the builder refuses
            x_of = x_op.multiply(RigidTransform(frame.pose.matrix))
            poses_W[frame.name] = x_wo.multiply(x_of)
            pending.append((frame.name, x_wo, x_of))
    return poses_W


def _shape(thing: SceneObject, path: str) -> tuple[Any, ConvexShape]:
    if isinstance(thing.shape, Mesh):
        validate_mesh(Path(thing.shape.uri), f"{path}: object {thing.name!r}")
    try:
        shape = drake_shape(thing.shape)
        convex = convex_shape(shape)
    except (RuntimeError, ValueError, SystemExit) as fault:
        message = f"{path}: object {thing.name!r} does not load: {fault}"
        raise SceneInvalid(message, {"path": path}) from fault
    assert convex is not None  # noqa: S101  (the kernel has all shapes that scenes have)
    return shape, convex


def _allowed_pairs(scene: Scene, names: frozenset[str]) -> frozenset[frozenset[str]]:
    """Return the scene's allowed pairs that contain one of these names."""
    pairs = [frozenset(pair) for pair in scene.allowed_collisions]
    for thing in scene.objects:
        touch = () if thing.attached is None else thing.attached.touch or ()
        pairs += [frozenset((thing.name, name)) for name in touch]
    return frozenset(pair for pair in pairs if pair & names)
