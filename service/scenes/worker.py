"""Loading a posted or edited scene: whether it stands, and what it holds."""

import gc
from collections.abc import Collection, Generator
from contextlib import contextmanager
from dataclasses import replace

from planning import (
    ModelLibrary,
    Scene,
    World,
    edit_scene,
    scene_document,
    scene_summary,
)
from planning.domain.robot.spanning_group import joined_name
from planning.errors import SceneInvalid, UnknownName
from planning.world.documents.scene_file import with_line
from planning.world.files.trial_load import trial_load
from service.api.names import located, located_in_scene
from service.jobs.context import MADE, TaskContext
from service.scenes.document_text import SceneText, keep_text, kept_text, unchecked_text
from service.scenes.models.edits import SceneEdit
from service.scenes.models.scene import SceneSummary
from service.scenes.parsing import decode_scene
from service.scenes.tasks import (
    EDIT_SCENE,
    LOAD_SCENE,
    LoadedScene,
    LoadWork,
    RequestWork,
    SceneWork,
)
from service.scenes.world_cache import (
    keep,
    library_of,
    load_like,
    posed,
    read_stored,
    warm_scene,
)

# Events are short: so many digests in one.
_AT_ONCE = 500


@LOAD_SCENE.runs
def load_scene(work: LoadWork, context: TaskContext) -> LoadedScene:
    """Load a posted scene; its world and text stay warm here.

    Raises:
        UnreadableBody: The text is not JSON.
        InputError: The scene has a fault.
    """
    library = library_of(work.library)
    with _no_collections():
        document = decode_scene(work.text, work.media)
        try:
            world = load_like(trial_load(document.value(), library), library)
        except SceneInvalid as fault:
            posted = document.model_dump(mode="json")
            raise located_in_scene(with_line(fault, work.text), posted) from fault
        except UnknownName as fault:
            raise located(fault, document.model_dump(mode="json")) from fault
        return _told(_loaded(world, library, SceneText.of(document)), context)


@EDIT_SCENE.runs
def revise_scene(work: RequestWork[SceneEdit], context: TaskContext) -> LoadedScene:
    """Load a scene after operations, which are done to its live state.

    What comes of it has the robots where the document had them, but for those that were placed.
    Where its world and text are warm, only what is edited is read and written; else all of it is
    read from the file, with the same outcome.

    Raises:
        UnknownName: An operation names what the scene does not have.
        SceneEditImpossible: An operation cannot be done to it.
        SceneNotKept: It was written before scenes kept their files.
        InputError: What came of it does not load.
    """
    library = library_of(work.library)
    operations = [operation.to_domain() for operation in work.request.operations]
    with _no_collections():
        before, text = _before(work)
        edited = edit_scene(posed(before, work.scene.positions), operations, library)
        edited = _as_described(edited, before, work.request.placed_robots)
        after = text.after(before, edited)
        if after is None:
            scene_document(edited)  # says what is wrong
            raise AssertionError
        world = load_like(trial_load(after[1], library), library)
        return _told(_loaded(world, library, after[0]), context)


def _told(loaded: LoadedScene, context: TaskContext) -> LoadedScene:
    """Return a scene after saying which files it was made from: they are here, and not stored."""
    files = loaded.summary.files or {}
    made = sorted({sha256 for kept in files.values() for sha256 in kept.sha256.values()})
    for i in range(0, len(made), _AT_ONCE):
        context.emit(MADE, {"artifacts": made[i : i + _AT_ONCE]})
    return loaded


@contextmanager
def _no_collections() -> Generator[None]:
    """Collect no garbage: what is made meanwhile mostly stays, and is looked through each time."""
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()


def _before(work: SceneWork) -> tuple[Scene, SceneText]:
    """Return the described scene that a task is about and its text, from here or from its file."""
    scene, text = warm_scene(work), kept_text(work.scene.digest)
    if scene is not None and text is not None:
        return scene, text
    posted, files = read_stored(work.scene)
    before = replace(posted.value(), files=files) if scene is None else scene
    return before, SceneText.of(posted)


def _as_described(edited: Scene, before: Scene, placed: Collection[str]) -> Scene:
    """Return an edited scene with the robots that were not placed where they were described."""
    robots = [
        now if now.name in placed else replace(now, positions=then.positions)
        for now, then in zip(edited.robots, before.robots, strict=True)
    ]
    return replace(edited, robots=tuple(robots))


def _loaded(world: World, library: ModelLibrary, text: SceneText) -> LoadedScene:
    keep(world, library)
    keep_text(world.digest, text)
    summary = scene_summary(world)
    return LoadedScene(
        name=world.scene.name,
        digest=world.digest,
        summary=SceneSummary.from_domain(summary, aliases_of(world), world.scene.files),
        unchecked=unchecked_text(summary.unchecked),
        document=text.whole,
    )


def aliases_of(world: World) -> dict[str, list[str]]:
    """Return the other names of each group.

    A robot's default group is `robot::group` too, and one that spans several their joined names.
    """
    names = {
        group.name: [f"{own.robot}::{name}"]
        for own in world.robot_groups
        for name, group in own.groups.items()
        if group.name == own.robot
    }
    for group in world.scene_groups.spanning:
        joined = joined_name(world.scene_groups.members(group))
        names[group.name] = [joined] if joined != group.name else []
    return names
