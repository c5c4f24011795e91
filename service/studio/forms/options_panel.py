"""OptionsPanel: all options of a plan besides its scene, its group and its goal."""

from collections.abc import Mapping
from typing import Any

import viser

from service.studio import texts
from service.studio.cell import Cell
from service.studio.forms.form import Drawing, Words
from service.studio.forms.schema import fields_of
from service.studio.forms.words import spoken

_REQUEST = "PlanRequest"
# Shown elsewhere: the scene that is looked at, its robot, where it is and where it shall go.
_ELSEWHERE = frozenset({"scene", "group", "goal", "start", "revision"})
# A newcomer waits so long for a plan rather than to be told to ask for more time [s].
PLANNING_TIME = 10.0
_AT_FIRST: dict[str, Any] = {"search": {"allowed_planning_time": PLANNING_TIME}}


class OptionsPanel:
    """A form for the options of the next plan, made from the server's OpenAPI document."""

    def __init__(self, gui: viser.GuiApi, cell: Cell, words: Words) -> None:
        """Show the form, with all options as they are by default.

        Args:
            gui: Where it is shown, in the container that is open.
            cell: The scene.
            words: That may be chosen for texts.
        """
        self._told = gui.add_html(texts.told("", "plain"))
        self._reset = gui.add_button(
            "Back to the defaults", icon=viser.Icon.RESTORE, color=texts.SOFT
        )
        self._is_drawn = False
        drawing = Drawing(gui, words, self._look)
        fields = fields_of(cell.api.document, _REQUEST, _ELSEWHERE)
        self._form = drawing.input(fields, is_unfolded=True)
        self._is_drawn = True
        self._reset.on_click(lambda _: self._form.fill(_AT_FIRST))
        self._form.fill(_AT_FIRST)
        self._look()

    def options(self) -> dict[str, Any]:
        """Return what is to be asked besides the goal; `search` says how long it may take.

        Raises:
            FormError: What was written by hand cannot be read.
        """
        found: dict[str, Any] = self._form.value()
        search = {"allowed_planning_time": PLANNING_TIME / 2, **found.get("search", {})}
        return {**found, "search": search}

    def close(self) -> None:
        """Take the form away."""
        self._form.remove()
        self._told.remove()
        self._reset.remove()

    def _look(self) -> None:
        """Say what is otherwise than by default."""
        if not self._is_drawn:
            return
        try:
            value = self._form.value()
        except ValueError as fault:
            self._told.content = texts.told(str(fault), "bad")
            return
        changed = ", ".join(_names(value))
        told = "all by default" if value == _AT_FIRST else f"otherwise than by default: {changed}"
        self._told.content = texts.told(told)


def _names(value: Mapping[str, Any]) -> list[str]:
    """Return what options are called that are set, at two levels."""
    found = list[str]()
    for name, inner in value.items():
        if isinstance(inner, dict) and inner:
            keys: list[str] = [str(key) for key in inner]  # pyright: ignore[reportUnknownVariableType,reportUnknownArgumentType]
            found += [f"{spoken(name)} · {spoken(key).lower()}" for key in keys]
        else:
            found.append(spoken(name))
    return found
