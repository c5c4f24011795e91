"""Cell: the scene that one browser looks at, and who is asked about it."""

import threading
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import viser

from service.studio.api import Api, ShownGroup, ShownScene
from service.studio.drawing.view import SceneView
from service.studio.numbers import Array


@dataclass
class Cell:
    """A scene in one browser.

    Attributes:
        api: The server.
        client: The browser.
        scene: As the server has it.
        group: That is planned for.
        view: What is drawn of it.
        positions: Where the group is, as far as it was told.
    """

    api: Api
    client: viser.ClientHandle
    scene: ShownScene
    group: ShownGroup
    view: SceneView
    positions: Array = field(init=False)
    _lock: threading.RLock = field(init=False, default_factory=threading.RLock)

    def __post_init__(self) -> None:
        """Begin where the scene has the group."""
        self.positions = np.array(self.group.positions)

    @property
    def object_names(self) -> list[str]:
        """Names of the objects of the scene."""
        return [entry["name"] for entry in self.scene.document.get("objects", [])]

    def edit(self, operations: list[dict[str, Any]]) -> None:
        """Carry operations out on the scene, and draw it as it is then.

        Raises:
            ApiError: The scene refuses them.
        """
        with self._lock:  # the live state tells of the new revision before it is drawn
            self.api.edit_scene(self.scene.id, operations)
            self.refresh()

    def catch_up(self, revision: int) -> bool:
        """Draw the scene as the server has it, unless it is drawn: return whether it was not."""
        with self._lock:
            is_older = self.scene.revision < revision
            if is_older:
                self.refresh()
            return is_older

    def refresh(self) -> None:
        """Draw the scene as the server has it now."""
        with self._lock:
            self.scene = self.api.shown(self.scene.id)
            self.group = self.scene.group(self.group.name)
            self.view.update(self.api.geometry(self.scene.id))
            self.draw_frames()

    def draw_frames(self) -> None:
        """Draw the scene's named frames where they are."""
        frames = [frame["name"] for frame in self.scene.document.get("frames", [])]
        rows = self.api.poses(self.scene.id, self.group.name, self.positions, frames)
        self.view.draw_frames({name: poses[0] for name, poses in rows.items()})

    def poses(self, positions: Array) -> dict[str, Array]:
        """Return X_WB of all moving bodies with the group at some positions, shape (7,)."""
        found = self.api.poses(self.scene.id, self.group.name, positions, self.view.moving)
        return {name: rows[0] for name, rows in found.items()}

    def show(self, positions: Array) -> None:
        """Put the robot somewhere."""
        self.positions = positions
        self.view.show(self.poses(positions))


def open_cell(api: Api, client: viser.ClientHandle, scene: str, group: str | None = None) -> Cell:
    """Return a scene, drawn as it is now.

    Args:
        api: The server.
        client: The browser.
        scene: Its id.
        group: That is planned for; None for the first one.
    """
    shown = api.shown(scene)
    chosen = shown.groups[0] if group is None else shown.group(group)
    meshes: dict[str, bytes] = {}

    def mesh(sha256: str) -> bytes:
        if sha256 not in meshes:
            meshes[sha256] = api.mesh(scene, sha256)
        return meshes[sha256]

    view = SceneView(client, api.geometry(scene), mesh)
    cell = Cell(api, client, shown, chosen, view)
    cell.show(cell.positions)
    cell.draw_frames()
    view.aim()
    return cell
