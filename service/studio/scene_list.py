"""SceneList: the scenes that a browser can open, and which one is open."""

import threading
from contextlib import suppress
from pathlib import Path
from typing import Any

import httpx
import viser

from service.client.errors import ApiError
from service.studio.api import Api

_SUFFIX = ".scene.yaml"
_FIRST = "ur5e_pickup"


class SceneList:
    """Bundled scenes, which are copied for a browser, and those of the server."""

    def __init__(self, gui: viser.GuiApi, api: Api, folder: Path) -> None:
        """Show the list.

        Args:
            gui: Where it is shown, in the container that is open.
            api: The server.
            folder: Of the bundled scenes.
        """
        self._api, self._folder = api, folder
        self._own: str | None = None
        self._choices = self._found()
        first = _FIRST if _FIRST in self._choices else next(iter(self._choices))
        self.field: Any = gui.add_dropdown("Scene", tuple(self._choices), initial_value=first)
        self._lock = threading.Lock()

    @property
    def own(self) -> str | None:
        """Id of the scene that was copied for this browser, if that is open."""
        return self._own

    def open(self) -> str:
        """Return the id of the scene that is chosen; the copy before is deleted.

        Raises:
            ApiError: The server refuses it.
        """
        self.forget()
        chosen = self._choices[self.field.value]
        if not isinstance(chosen, Path):
            return chosen
        self._own = self._api.add_scene(chosen.read_bytes()).id
        return self._own

    def forget(self) -> None:
        """Delete the copy that is open, if there is one."""
        if self._own is not None:
            with suppress(ApiError, httpx.HTTPError):
                self._api.delete_scene(self._own)
        self._own = None

    def renew(self) -> None:
        """List scenes that came, and no more those that went."""
        with self._lock, suppress(ApiError, httpx.HTTPError, RuntimeError):
            found = self._found()
            if self.field.value not in found:  # it is looked at
                found[self.field.value] = self._choices[self.field.value]
            if found.keys() != self._choices.keys():
                self._choices = found
                self.field.options = tuple(found)

    def _found(self) -> dict[str, Path | str]:
        files = sorted(self._folder.glob(f"*{_SUFFIX}"))
        found: dict[str, Path | str] = {path.name.removesuffix(_SUFFIX): path for path in files}
        for brief in self._api.scenes():
            if brief["id"] != self._own:
                found[f"{brief['name']} · {brief['id']}"] = brief["id"]
        return found
