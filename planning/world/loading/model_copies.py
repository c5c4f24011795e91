"""Copies of Drake models that this process has built: they take a hundredth of what building takes.

Parsing a robot and computing the convex hulls of its meshes is most of what loading a scene takes.
Drake clones a diagram within a millisecond. Of each of the last few models a clone is kept that
nothing else refers to; a world that is made of the same robots gets a clone of that. So no two
worlds share an engine, and a copy is what the builder would return: Drake's model before its first
query (`tests/world/loading/test_model_copies.py`).
"""

from collections import OrderedDict
from dataclasses import dataclass, replace
from threading import Lock

from planning.world.drake_model import DrakeModel
from planning.world.files.stored_scene import StoredScene
from planning.world.loading.model_reuse import model_digest, with_other_objects
from planning.world.loading.scene_build import LoadedRobot

# Number of models that are kept: a worker plans for the robots of a few cells.
_MAX_MODELS = 4


@dataclass(frozen=True)
class _Built:
    """What the builder returned: a model that nothing else refers to, and its robots."""

    model: DrakeModel
    robots: tuple[LoadedRobot, ...]


_lock = Lock()
_built: OrderedDict[str, _Built] = OrderedDict()


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
    model = with_other_objects(copy, stored, static_names)
    if model is None:
        return None
    robots = tuple(
        replace(loaded, scene_robot=robot)
        for loaded, robot in zip(kept.robots, stored.scene.robots, strict=True)
    )
    return model, robots


def _key(stored: StoredScene, static_names: frozenset[str], *, kernel: bool) -> str:
    return f"{kernel} {model_digest(stored.scene, static_names)}"


def _clone(model: DrakeModel) -> DrakeModel:
    """Return the same model in a diagram of its own."""
    diagram = model.diagram.Clone()
    plant = diagram.plant()
    frames = {name: plant.get_frame(frame.index()) for name, frame in model.frames.items()}
    return replace(
        model, diagram=diagram, plant=plant, scene_graph=diagram.scene_graph(), frames=frames
    )
