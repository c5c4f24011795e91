"""scene_geometry(): shapes, colours and fixed poses of a world's visible bodies."""

import hashlib
from collections import OrderedDict
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float64
from pydrake import geometry as drake

from planning.domain.geometry.pose import Pose
from planning.domain.geometry.shapes import (
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Sphere,
)
from planning.domain.scene.geometry import MeshFile, VisibleBody, VisibleShape
from planning.domain.value import frozen
from planning.world.files.mesh_axes import to_z_up
from planning.world.replay.replay_view import ShownShape, WorldView
from planning.world.world import World

# Formats whose materials trimesh keeps; of others (VTK) the hull is shown, which is what collides.
_WITH_MATERIALS = {".obj", ".gltf", ".glb"}
# Converted meshes that are kept, by the bytes of all of them [B].
_MAX_KEPT = 256 * 2**20


class _Kept:
    """Converted meshes by digest, the least recently used ones given up first."""

    def __init__(self) -> None:
        self._digests: dict[object, str] = {}
        self._contents: OrderedDict[str, bytes] = OrderedDict()

    def digest(self, key: object) -> str | None:
        """Return the digest of what a mesh became, if it is still here."""
        found = self._digests.get(key)
        return found if found in self._contents else None

    def content(self, digest: str) -> bytes | None:
        """Return a converted mesh, if it is still here."""
        return self._contents.get(digest)

    def keep(self, key: object, content: bytes) -> str:
        """Keep a converted mesh and return its digest."""
        digest = hashlib.sha256(content).hexdigest()
        self._digests[key], self._contents[digest] = digest, content
        self._contents.move_to_end(digest)
        while len(self._contents) > 1 and sum(map(len, self._contents.values())) > _MAX_KEPT:
            self._contents.popitem(last=False)
        return digest


_kept = _Kept()


def scene_geometry(world: World) -> tuple[VisibleBody, ...]:
    """Return the visible bodies of a world, by name.

    Poses are those of bodies that no joint moves: where the others are depends on the configuration
    (`forward_kinematics` of the frame that has the body's name).
    """
    view = WorldView(world)
    poses, moving = view.poses, view.moving_poses
    return tuple(
        VisibleBody(
            name=shown.name,
            X_WB=None if shown.path in moving else _pose(poses[shown.path]),
            shapes=tuple(_visible(drawn) for drawn in shown.shapes),
        )
        for shown in sorted(view.bodies, key=lambda shown: shown.name)
    )


def scene_mesh(world: World, sha256: str) -> bytes | None:
    """Return a mesh that `scene_geometry` names, None if no body of the world has it."""
    if _kept.content(sha256) is None:
        scene_geometry(world)
    return _kept.content(sha256)


def _visible(drawn: ShownShape) -> VisibleShape:
    color = drawn.color
    rgba = frozen([color.r(), color.g(), color.b(), color.a()])
    return VisibleShape(_shape(drawn.shape), _pose(drawn.X_BS), rgba)


def _shape(shape: Any) -> Any:  # noqa: PLR0911  (one return per shape)
    match shape:
        case drake.Box():
            return Box(frozen(shape.size()))
        case drake.Sphere():
            return Sphere(shape.radius())
        case drake.Cylinder():
            return Cylinder(shape.radius(), shape.length())
        case drake.Capsule():
            return Capsule(shape.radius(), shape.length())
        case drake.Ellipsoid():
            return Ellipsoid(frozen([shape.a(), shape.b(), shape.c()]))
        case drake.HalfSpace():
            return HalfSpace()
        case _:
            return MeshFile(_mesh_digest(shape))


def _mesh_digest(shape: Any) -> str:
    """Return the digest of a mesh, converted to glTF; files are kept under names that change."""
    source, scale = shape.source(), np.array(shape.scale3())
    is_drawn = isinstance(shape, drake.Mesh) and source.is_path()
    path = Path(source.path()) if is_drawn else None
    if path is not None and path.suffix.lower() in _WITH_MATERIALS:
        changed = path.stat()
        key = (str(path), changed.st_mtime_ns, changed.st_size, *scale.tolist())
        return _kept.digest(key) or _kept.keep(key, _from_file(path, scale))
    content = _from_hull(shape)
    return _kept.keep(hashlib.sha256(content).hexdigest(), content)


def _from_file(path: Path, scale: Float64[np.ndarray, "3"]) -> bytes:
    import trimesh  # noqa: PLC0415  (takes longer than Drake, and few scenes have meshes)

    scene: Any = trimesh.load_scene(path)
    matrix = to_z_up(b"", path.suffix.lower())
    scene.apply_transform(np.diag([*scale, 1.0]) @ matrix)
    content: bytes = scene.export(file_type="glb")
    return content


def _from_hull(shape: Any) -> bytes:
    import trimesh  # noqa: PLC0415

    hull = shape.GetConvexHull()
    points = np.array([hull.vertex(i) for i in range(hull.num_vertices())])
    scene: Any = trimesh.Scene(trimesh.convex.convex_hull(points))
    content: bytes = scene.export(file_type="glb")
    return content


def _pose(pose: Any) -> Pose:
    return Pose.from_matrix(pose.GetAsMatrix4())
