"""Scenes as slots are given them: a document, and the files that it was made from."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from planning import Scene, World
from planning.domain.scene.kept_files import KeptFiles
from planning.world.documents.scene_document import SceneDocument
from service.errors import SceneNotKept
from service.scenes.tasks import StoredScene


def read_posted(scene: StoredScene) -> tuple[SceneDocument, Mapping[str, KeptFiles]]:
    """Return the document of the scene that a task is about, and its files.

    Raises:
        SceneNotKept: It was written before scenes kept their files.
        SceneInvalid: Its files cannot be meant.
    """
    written = json.loads(Path(scene.document).read_text(encoding="utf-8"))
    if "files" not in written:
        raise SceneNotKept.of(scene.digest)
    files = {name: KeptFiles.from_json(plain) for name, plain in written["files"].items()}
    return SceneDocument.model_validate(written["document"]), files


def require_same(world: World, scene: StoredScene) -> None:
    """Go on only if a world is the very one that the scene was accepted as.

    Raises:
        SceneNotKept: It is another one.
    """
    if world.digest != scene.digest:
        raise SceneNotKept.of(scene.digest)


def files_wire(scene: Scene) -> dict[str, Any]:
    """Return what a scene was made from, by the name of the robot or object."""
    return {name: kept.as_json for name, kept in scene.files.items()}
