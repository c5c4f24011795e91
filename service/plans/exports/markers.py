"""Markers: the bodies of a scene as `visualization_msgs/msg/Marker`, each in a frame of its own."""

import io
from typing import Any

import numpy as np

from planning.domain.arrays import Array
from planning.domain.geometry.pose import Pose
from planning.domain.geometry.shapes import Box, Capsule, Cylinder, Ellipsoid, HalfSpace, Sphere
from planning.domain.scene.geometry import SceneMotion, VisibleBody, VisibleShape

WORLD = "world"
# Of `visualization_msgs/msg/Marker`.
_CUBE, _SPHERE, _CYLINDER, _LINE_STRIP, _TRIANGLE_LIST = 1, 2, 3, 4, 11
# A half space is drawn as a plate [m].
_PLATE = np.array([10.0, 10.0, 0.01])
_PATH_WIDTH = 0.004
_PATH_COLOR = (0.95, 0.45, 0.05, 1.0)

type _Part = tuple[int, Array, Pose, Array]


def markers(motion: SceneMotion) -> list[dict[str, Any]]:
    """Return markers of all bodies, which follow their frames, and the tool's path.

    Raises:
        ValueError: A mesh is no glTF.
    """
    found: list[dict[str, Any]] = []
    for body in motion.bodies:
        parts = [(drawn, p) for drawn in body.shapes for p in _parts(drawn.shape, motion.meshes)]
        found += [_marker(body, i, drawn, part) for i, (drawn, part) in enumerate(parts)]
    if len(motion.tool_path) > 1:
        found.append({
            **_common(WORLD, "tool path", 0, _LINE_STRIP, _PATH_COLOR),
            "pose": pose_message(Pose.identity()),
            "scale": vector(np.array([_PATH_WIDTH, 0.0, 0.0])),
            "points": [vector(p) for p in motion.tool_path],
        })
    return found


def vector(values: Any) -> dict[str, float]:
    """Return three numbers as ROS has them."""
    return dict(zip("xyz", map(float, values), strict=True))


def quaternion(wxyz: Any) -> dict[str, float]:
    """Return a quaternion `[w, x, y, z]` as ROS has it."""
    return dict(zip("wxyz", map(float, wxyz), strict=True))


def pose_message(pose: Pose) -> dict[str, Any]:
    """Return a pose as ROS has it."""
    return {"position": vector(pose.position), "orientation": quaternion(pose.quaternion)}


def triangles(glb: bytes) -> Array:
    """Return the triangles of a glTF file, a row for each corner, shape (3 m, 3) [m].

    Raises:
        ValueError: It is no glTF.
    """
    import trimesh  # noqa: PLC0415  (few scenes have meshes)

    loaded: Any = trimesh.load_scene(io.BytesIO(glb), file_type="glb")
    corners: Array = np.asarray(loaded.to_mesh().triangles, dtype=float).reshape(-1, 3)
    return corners


def _parts(shape: Any, meshes: dict[str, bytes]) -> list[_Part]:  # noqa: PLR0911  (one per shape)
    """Return what draws a shape S: type, scale [m], X_SM, and corners of triangles."""
    match shape:
        case Box(size):
            return [_part(_CUBE, size)]
        case Sphere(radius):
            return [_part(_SPHERE, np.full(3, 2 * radius))]
        case Ellipsoid(semi_axes):
            return [_part(_SPHERE, 2 * semi_axes)]
        case Cylinder(radius, length):
            return [_part(_CYLINDER, np.array([2 * radius, 2 * radius, length]))]
        case Capsule(radius, length):
            round_end = np.full(3, 2 * radius)
            return [
                _part(_CYLINDER, np.array([2 * radius, 2 * radius, length])),
                _part(_SPHERE, round_end, height=length / 2),
                _part(_SPHERE, round_end, height=-length / 2),
            ]
        case HalfSpace():
            return [_part(_CUBE, _PLATE, height=-_PLATE[2] / 2)]
        case mesh:
            corners = triangles(meshes[mesh.sha256])
            return [(_TRIANGLE_LIST, np.ones(3), Pose.identity(), corners)]


def _part(kind: int, scale: Array, *, height: float = 0.0) -> _Part:
    """Return a part without triangles, so far above the origin of its shape [m]."""
    return kind, scale, Pose.from_parts((0, 0, height)), np.zeros((0, 3))


def _marker(body: VisibleBody, index: int, drawn: VisibleShape, part: _Part) -> dict[str, Any]:
    kind, scale, pose, corners = part
    placed = Pose.from_matrix(drawn.X_BS.matrix @ pose.matrix)
    return {
        **_common(body.name, body.name, index, kind, drawn.color),
        "pose": pose_message(placed),
        "scale": vector(scale),
        "points": [vector(p) for p in corners],
    }


def _common(frame: str, name: str, index: int, kind: int, color: Any) -> dict[str, Any]:
    """Return the fields of a marker that stays in its frame from the beginning on."""
    return {
        "header": {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": frame},
        "ns": name,
        "id": index,
        "type": kind,
        "action": 0,
        "color": dict(zip("rgba", map(float, color), strict=True)),
        "frame_locked": True,
    }
