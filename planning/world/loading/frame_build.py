"""Named frames of a scene, added to Drake's plant."""

from collections.abc import Mapping, Sequence
from typing import Any

from pydrake.math import RigidTransform
from pydrake.multibody.tree import FixedOffsetFrame

from planning.domain.scene.scene import SceneFrame
from planning.errors import SceneInvalid, UnknownName
from planning.world.loading.scene_build import Build, validate_unused_name


def add_frames(
    build: Build, frames: Sequence[SceneFrame], static_frames: Mapping[str, RigidTransform]
) -> None:
    """Add frames to the plant, every parent before its children.

    Each is fixed to its root body, so that a chain of thousands costs no more than as many frames
    of one body.

    Args:
        build: With all bodies.
        frames: Of the scene.
        static_frames: X_WF of frames below objects outside of the plant; they are not added.

    Raises:
        SceneInvalid: A name is given twice, a parent does not exist, or frames form a cycle.
    """
    _validate_unique_names(build, frames)
    children: dict[str, list[int]] = {}
    for i, frame in enumerate(frames):
        children.setdefault(frame.parent, []).append(i)
    ready = [i for parent in build.frames for i in children.get(parent, [])]
    num_added = 0
    while ready:
        ready.sort()
        for i in ready:
            build.frames[frames[i].name] = _add_frame(build, frames[i])
        num_added += len(ready)
        ready = [k for i in ready for k in children.get(frames[i].name, [])]
    if num_added + sum(frame.name in static_frames for frame in frames) < len(frames):
        _raise_for_orphans(build, frames, static_frames)


def _add_frame(build: Build, frame: SceneFrame) -> Any:
    parent = build.frames[frame.parent]
    x_pf = RigidTransform(frame.pose.matrix)
    x_bf = parent.GetFixedPoseInBodyFrame().multiply(x_pf)
    offset = FixedOffsetFrame(f"frame::{frame.name}", parent.body().body_frame(), x_bf)
    return build.plant.AddFrame(offset)


def _validate_unique_names(build: Build, frames: Sequence[SceneFrame]) -> None:
    seen: set[str] = set()
    for i, frame in enumerate(frames):
        path = f"frames.{i}.name"
        validate_unused_name(build, frame.name, path)
        if frame.name in seen:
            message = f"{path}: the name {frame.name!r} is taken by another frame"
            raise SceneInvalid(message, {"path": path, "name": frame.name})
        seen.add(frame.name)


def _raise_for_orphans(
    build: Build, frames: Sequence[SceneFrame], static_frames: Mapping[str, RigidTransform]
) -> None:
    pending = [
        (i, f) for i, f in enumerate(frames) if f.name not in {*build.frames, *static_frames}
    ]
    names = [frame.name for _, frame in pending]
    known = {*build.frames, *static_frames, *names}
    for i, frame in pending:
        if frame.parent not in known:
            fault = UnknownName.among("frame", frame.parent, known)
            path = f"frames.{i}.parent"
            raise SceneInvalid(f"{path}: {fault.detail}", {"path": path, **fault.evidence})
    message = f"the parents of frames form a cycle: {names}"
    raise SceneInvalid(message, {"path": "frames", "frames": names})
