"""Scenes as slots are given them: a document, and the files that it was made from."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from planning import Scene, World
from planning.domain.scene.kept_files import KeptFiles
from planning.world.documents.scene_document import SceneDocument
from service.errors import SceneNotKept


def read_posted(payload: Mapping[str, Any]) -> tuple[SceneDocument, Mapping[str, KeptFiles]]:
    """Return the document of the scene that a task is about, and its files.

    Args:
        payload: With `scene`: its `digest`, and `document`, the path of what the server wrote.

    Raises:
        SceneNotKept: It was written before scenes kept their files.
        SceneInvalid: Its files cannot be meant.
    """
    written = json.loads(Path(payload["scene"]["document"]).read_text(encoding="utf-8"))
    if "files" not in written:
        raise SceneNotKept.of(payload["scene"]["digest"])
    files = {name: KeptFiles.from_json(plain) for name, plain in written["files"].items()}
    return SceneDocument.model_validate(written["document"]), files


def require_same(world: World, payload: Mapping[str, Any]) -> None:
    """Go on only if a world is the very one that the scene was accepted as.

    Raises:
        SceneNotKept: It is another one.
    """
    if world.digest != payload["scene"]["digest"]:
        raise SceneNotKept.of(payload["scene"]["digest"])


def files_wire(scene: Scene) -> dict[str, Any]:
    """Return what a scene was made from, by the name of the robot or object."""
    return {name: kept.as_json for name, kept in scene.files.items()}
