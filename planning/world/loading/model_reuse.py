"""Reuse of Drake models for scenes with the same robots and attached objects.

Drake's model depends on these alone: all other objects are in our own tables, and robot positions
are a state. A world shares the model of a given world (`reuse_model`), or has a copy of one that
the process has built before (`copied_model`). Parsing robots and computing convex hulls of meshes
is most of what loading a scene takes; Drake clones a diagram within a millisecond. Of each of the
last few models a clone is kept that nothing else refers to, as it was before its first query, and
worlds get clones of that: no two of them share an engine.
"""

from collections import OrderedDict
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from threading import Lock
from typing import Any

from planning.domain.scene.scene import Scene, SceneFrame, SceneObject
from planning.domain.value import digest
from planning.world.collision.collision_pairs import copy_candidates
from planning.world.collision.half_spaces import has_moving_half_space
from planning.world.collision.unchecked_pairs import copy_unchecked_pairs
from planning.world.drake_model import DrakeModel
from planning.world.files.stored_scene import StoredScene
from planning.world.kernel.kernel_scene import copy_kernel_scene, kernel_scene_of
from planning.world.loading.scene_build import LoadedRobot
from planning.world.loading.start_warnings import copy_start_warnings
from planning.world.loading.static_build import make_static_objects, static_frames, transforms
from planning.world.world import World

# Number of models that are kept: a worker plans for the robots of a few cells.
_MAX_MODELS = 4


@dataclass(frozen=True)
class _Built:
    """What the builder returned: a model that nothing else refers to, and its robots."""

    model: DrakeModel
    robots: tuple[LoadedRobot, ...]


_lock = Lock()
_built: OrderedDict[str, _Built] = OrderedDict()


def reuse_model(
    stored: StoredScene, static_names: frozenset[str], previous: World | None, *, kernel: bool
) -> tuple[DrakeModel, tuple[LoadedRobot, ...]] | None:
    """Return the model of a loaded world with the objects of a scene, and its robots.

    None if the scenes differ in what Drake's model is made of, or if the builder has to say what is
    wrong with the scene.

    Args:
        stored: The scene, with its files.
        static_names: Names of the objects that are kept outside of Drake's model.
        previous: The loaded world.
        kernel: Whether the native kernel may decide collisions.

    Raises:
        SceneInvalid: An object does not load, or there are too many.
        ModelInvalid: A mesh refers to elements outside of its file.
        AssetNotFound: The file of a mesh does not exist any more.
    """
    if previous is None or previous.drake.uses_kernel != kernel:
        return None
    before, static_objects = previous.drake, previous.drake.static_objects
    if _model_digest(stored.scene, static_names) != _model_digest(
        previous.scene, static_objects.rows
    ):
        return None
    things = [thing for thing in stored.scene.objects if thing.name in static_names]
    if stored.meshes:
        things = list(map(stored.stored_object, things))
    if _are_same(things, static_objects.objects):
        model = _with_moved_objects(before, things, stored.scene.frames)
    else:
        model = _with_other_objects(before, stored, static_names)
    if model is None:
        return None
    return model, _at_new_positions(previous.loaded_robots, stored.scene)


def _model_digest(scene: Scene, static_names: Collection[str]) -> str:
    """Return the digest of all inputs of Drake's model."""
    return digest((
        [replace(robot, positions=None) for robot in scene.robots],
        [thing for thing in scene.objects if thing.name not in static_names],
        [(frame.name, frame.parent, frame.pose) for frame in scene.frames],
        scene.allowed_collisions,
        scene.margins,
        {name: files for name, files in scene.files.items() if name not in static_names},
    ))


def _are_same(after: Sequence[SceneObject], before: Sequence[SceneObject]) -> bool:
    """Return whether objects are equal except for poses and colors."""
    if len(after) != len(before):
        return False
    others = [(a, b) for a, b in zip(after, before, strict=True) if a is not b]
    return all(a.name == b.name and a.shape == b.shape for a, b in others)


def _with_moved_objects(
    before: DrakeModel, things: Sequence[SceneObject], frames: Sequence[SceneFrame]
) -> DrakeModel:
    """Return a model with the objects outside of it at the scene's present poses."""
    static_objects = before.static_objects
    rows = [
        row
        for row, (a, b) in enumerate(zip(things, static_objects.objects, strict=True))
        if a is not b and a.pose is not b.pose and a.pose != b.pose
    ]
    poses = dict(zip(rows, transforms([things[row].pose for row in rows]), strict=True))
    moved_poses = static_objects.moved_poses(poses)
    after = replace(
        before,
        static_objects=static_objects.with_moved_objects(
            things, poses, static_frames(things, moved_poses, frames)
        ),
    )
    copy_candidates(before, after)
    copy_unchecked_pairs(before, after)
    copy_start_warnings(before, after, rows)
    copy_kernel_scene(before, after, rows)
    return after


def _with_other_objects(
    before: DrakeModel, stored: StoredScene, static_names: frozenset[str]
) -> DrakeModel | None:
    """Return a model with the scene's objects outside of it; None where it has to be built."""
    scene, names = stored.scene, [thing.name for thing in stored.scene.objects]
    others = {*before.bodies, *before.frames, *(robot.name for robot in scene.robots)}
    others |= {frame.name for frame in scene.frames}
    if len(names) > len({*names}) or static_names & others:
        return None  # a name is given twice
    static_objects = make_static_objects(stored, static_names)
    allowed = static_objects.allowed
    known = {*before.bodies, *static_names}
    # The model has the reasons why these pairs are left out.
    if allowed != before.static_objects.allowed or any(pair - known for pair in allowed):
        return None
    after = replace(before, static_objects=static_objects)
    if any(frame.name not in after.all_frames for frame in scene.frames):
        return None  # what it was on is gone
    if static_names and (kernel_scene_of(after) is None or has_moving_half_space(after)):
        return None  # Drake has to have the objects
    return after


def keep_model(
    stored: StoredScene,
    static_names: frozenset[str],
    model: DrakeModel,
    robots: tuple[LoadedRobot, ...],
) -> None:
    """Keep a clone of a model that was just built.

    Args:
        stored: The scene that it was built of.
        static_names: Names of the objects that are outside of it.
        model: Model before its first query.
        robots: Robots of the scene.
    """
    key = _key(stored, static_names, kernel=model.uses_kernel)
    kept = _Built(_clone(model), robots)
    with _lock:
        _built[key] = kept
        _built.move_to_end(key)
        while len(_built) > _MAX_MODELS:
            _built.popitem(last=False)


def copied_model(
    stored: StoredScene, static_names: frozenset[str], *, kernel: bool
) -> tuple[DrakeModel, tuple[LoadedRobot, ...]] | None:
    """Return a copy of a kept model with the objects of a scene, and its robots.

    None if none was built of the same, or if the builder has to say what is wrong with the scene.

    Args:
        stored: The scene, with its files.
        static_names: Names of the objects that are kept outside of Drake's model.
        kernel: Whether the native kernel may decide collisions.

    Raises:
        SceneInvalid: An object does not load, or there are too many.
        ModelInvalid: A mesh refers to elements outside of its file.
        AssetNotFound: The file of a mesh does not exist any more.
    """
    key = _key(stored, static_names, kernel=kernel)
    with _lock:
        kept = _built.get(key)
        if kept is None:
            return None
        _built.move_to_end(key)
        copy = _clone(kept.model)
    model = _with_other_objects(copy, stored, static_names)
    if model is None:
        return None
    return model, _at_new_positions(kept.robots, stored.scene)


def _at_new_positions(robots: Sequence[LoadedRobot], scene: Scene) -> tuple[LoadedRobot, ...]:
    """Return loaded robots as another scene of the same model has them."""
    return tuple(
        replace(loaded, scene_robot=robot)
        for loaded, robot in zip(robots, scene.robots, strict=True)
    )


def _key(stored: StoredScene, static_names: frozenset[str], *, kernel: bool) -> str:
    return f"{kernel} {_model_digest(stored.scene, static_names)}"


def _clone(model: DrakeModel) -> DrakeModel:
    """Return the same model in a diagram of its own."""
    diagram: Any = model.diagram.Clone()
    plant = diagram.plant()
    frames = {name: plant.get_frame(frame.index()) for name, frame in model.frames.items()}
    return replace(
        model, diagram=diagram, plant=plant, scene_graph=diagram.scene_graph(), frames=frames
    )
