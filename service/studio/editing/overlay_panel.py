"""OverlayPanel: what can be shown besides the bodies: frames, margins, pairs that may touch."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import viser

from service.studio import texts
from service.studio.cell import Cell

_GRAY = (100, 116, 139)
_THICKNESS = 0.003


class OverlayPanel:
    """Switches for what is drawn over a scene."""

    def __init__(self, gui: viser.GuiApi, cell: Cell) -> None:
        """Show the switches; frames are shown, the rest is not.

        Args:
            gui: Where they are shown, in the container that is open.
            cell: The scene.
        """
        self._cell = cell
        self._pairs: list[viser.SceneNodeHandle] = []
        self._folder = gui.add_folder("Show")
        with self._folder:
            self._frames = gui.add_checkbox("Frames", initial_value=True)
            self._margins = gui.add_checkbox("Margins", initial_value=False)
            self._allowed = gui.add_checkbox("Allowed pairs", initial_value=False)
            self._told = gui.add_html(texts.told(_words(cell.scene.document)))
        for switch in (self._frames, self._margins, self._allowed):
            switch.on_update(lambda _: self.refresh())

    def refresh(self) -> None:
        """Draw what is switched on, of the scene as it is now."""
        view, document = self._cell.view, self._cell.scene.document
        view.show_frames(is_visible=bool(self._frames.value))
        view.show_margin(float(document.get("margin") or 0.0) if self._margins.value else 0.0)
        for node in self._pairs:
            node.remove()
        self._pairs = []
        if self._allowed.value:
            for a, b in document.get("allowed_collisions", []):
                self._connect(a, b)
        self._told.content = texts.told(_words(document))

    def close(self) -> None:
        """Take the switches and what they drew away."""
        for node in self._pairs:
            node.remove()
        self._folder.remove()

    def _connect(self, a: str, b: str) -> None:
        view, scene = self._cell.view, self._cell.client.scene
        if not view.has(a) or not view.has(b):
            return
        ends = np.array([view.pose_of(a)[:3], view.pose_of(b)[:3]])
        path = f"/allowed/{len(self._pairs)}"
        self._pairs.append(scene.add_line_segments(path, ends[None], _GRAY, thickness=_THICKNESS))
        text = f"{texts.short(a)} may touch {texts.short(b)}"
        self._pairs.append(scene.add_label(f"{path}/name", text, position=tuple(ends.mean(axis=0))))


def _words(document: Mapping[str, Any]) -> str:
    margin, pairs = 1000 * float(document.get("margin") or 0.0), document["allowed_collisions"]
    kept = (
        f"margin {margin:.1f} mm" if margin else "no margin: bodies may come as near as they like"
    )
    return f"{kept}; {len(pairs)} {'pair' if len(pairs) == 1 else 'pairs'} may touch"
