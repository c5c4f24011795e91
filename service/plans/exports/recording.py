"""Rerun: a recording (.rrd) of a motion in its scene, with curves of its joints."""

from functools import cache
from importlib import import_module
from typing import Any

import numpy as np

from planning.domain.geometry.pose import Pose
from planning.domain.geometry.shapes import Box, Capsule, Cylinder, Ellipsoid, HalfSpace, Sphere
from planning.domain.scene.geometry import SceneMotion, VisibleShape
from service.plans.exports.exported_motion import ExportedMotion

# Of the timeline, whose values are seconds from the beginning of the motion.
TIMELINE = "time"
# A half space is drawn as a plate [m].
_PLATE = (10.0, 10.0, 0.01)
_PATH_COLOR = (242, 115, 13)
_PATH_RADIUS = 0.002


def to_recording(motion: ExportedMotion) -> bytes:
    """Return the recording: bodies below `world`, each joint below `joints`."""
    rr = _rerun()

    recording = rr.RecordingStream("wayproof")
    stream = recording.binary_stream()
    recording.log("world", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    times = [rr.TimeColumn(TIMELINE, duration=np.array(motion.samples.times))]
    if motion.scene is not None:
        _log_scene(recording, motion.scene, times)
    for kind, names, rows in (
        ("position", motion.samples.joint_names, motion.samples.positions),
        ("velocity", motion.samples.velocity_names, motion.samples.velocities),
    ):
        for name, column in zip(names, np.array(rows).T, strict=True):
            scalars = rr.Scalars.columns(scalars=column)
            recording.send_columns(_path("joints", kind, name), indexes=times, columns=scalars)
    content: bytes | None = stream.read()
    return content or b""


@cache
def _rerun() -> Any:
    """Import Rerun's SDK, of the extra `rerun`: half a gigabyte, which developers need not have."""
    return import_module("rerun")


def _log_scene(recording: Any, scene: SceneMotion, times: list[Any]) -> None:
    rr = _rerun()

    for name, pose in scene.fixed.items():
        recording.log(_path("world", name), _transform(pose), static=True)
    for name, rows in scene.moving.items():
        poses = rr.Transform3D.columns(translation=rows[:, :3, 3], mat3x3=rows[:, :3, :3])
        recording.send_columns(_path("world", name), indexes=times, columns=poses)
    for body in scene.bodies:
        for i, drawn in enumerate(body.shapes):
            path = _path("world", body.name, str(i))
            recording.log(path, _transform(drawn.X_BS), static=True)
            recording.log(path, _shape(drawn, scene.meshes), static=True)
    if len(scene.tool_path) > 1:
        line = rr.LineStrips3D([scene.tool_path], radii=_PATH_RADIUS, colors=_PATH_COLOR)
        recording.log(_path("world", "tool path"), line, static=True)


def _path(*names: str) -> str:
    """Return a place in Rerun's tree; any name is one level of it."""
    rr = _rerun()

    path: str = rr.new_entity_path(list(names))
    return path


def _transform(pose: Pose) -> Any:
    rr = _rerun()

    x = pose.matrix
    return rr.Transform3D(translation=x[:3, 3], mat3x3=x[:3, :3])


def _shape(drawn: VisibleShape, meshes: dict[str, bytes]) -> Any:  # noqa: PLR0911  (a return each)
    rr = _rerun()

    look: dict[str, Any] = {
        "colors": [np.round(255 * drawn.color).astype(np.uint8)],
        "fill_mode": "solid",
    }
    match drawn.shape:
        case Box(size):
            return rr.Boxes3D(sizes=[size], **look)
        case Sphere(radius):
            return rr.Ellipsoids3D(radii=[radius], **look)
        case Ellipsoid(semi_axes):
            return rr.Ellipsoids3D(half_sizes=[semi_axes], **look)
        case Cylinder(radius, length):
            return rr.Cylinders3D(radii=[radius], lengths=[length], **look)
        case Capsule(radius, length):
            middle = [(0.0, 0.0, -length / 2)]  # Rerun's begins at its origin
            return rr.Capsules3D(radii=[radius], lengths=[length], translations=middle, **look)
        case HalfSpace():
            return rr.Boxes3D(sizes=[_PLATE], centers=[(0.0, 0.0, -_PLATE[2] / 2)], **look)
        case mesh:
            return rr.Asset3D(contents=meshes[mesh.sha256], media_type="model/gltf-binary")
