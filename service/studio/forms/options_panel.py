"""OptionsPanel: all options of a plan besides its scene, its group and its goal."""

import threading
from collections.abc import Callable, Mapping
from typing import Any

import viser

from service.studio import texts
from service.studio.cell import Cell
from service.studio.forms.fields import Group
from service.studio.forms.form import Drawing, Words
from service.studio.forms.schema import fields_of
from service.studio.forms.words import spoken

_REQUEST = "PlanRequest"
# Shown elsewhere: the scene that is looked at, its robot, where it is and where it shall go.
_ELSEWHERE = frozenset({"scene", "group", "goal", "start", "revision"})
# A newcomer waits so long for a plan rather than to be told to ask for more time [s].
PLANNING_TIME = 10.0
_AT_FIRST: dict[str, Any] = {"search": {"allowed_planning_time": PLANNING_TIME}}
_FIRST = {f"{group}.{name}": value for group, of in _AT_FIRST.items() for name, value in of.items()}
_WHERE = "Distance to keep: Margin. Planner and its time: Search. Speed and limits: Retime."


class OptionsPanel:
    """A form for the options of the next plan, made from the server's OpenAPI document."""

    def __init__(
        self,
        gui: viser.GuiApi,
        place: viser.GuiTabHandle,
        cell: Cell,
        words: Words,
        on_fault: Callable[[Exception], None],
    ) -> None:
        """Begin to show the form, with all options as they are by default.

        Its fields are many, and a server makes its document when it is first asked for it, which
        takes seconds: nothing else waits for them.

        Args:
            gui: Of one browser.
            place: Where it is shown.
            cell: The scene.
            words: That may be chosen for texts.
            on_fault: Is told what goes wrong.
        """
        self._gui, self._place, self._cell, self._words = gui, place, cell, words
        self._on_fault = on_fault
        self._lock = threading.Lock()
        self._is_closed = False
        self._parts: list[Any] = []
        self._form: Any = None
        self._planning_time = PLANNING_TIME
        threading.Thread(target=self._draw, daemon=True).start()

    def options(self) -> dict[str, Any]:
        """Return what is to be asked besides the goal; `search` says how long it may take.

        Raises:
            FormError: What was written by hand cannot be read.
        """
        found: dict[str, Any] = _AT_FIRST if self._form is None else self._form.value()
        search = {"allowed_planning_time": self._planning_time, **found.get("search", {})}
        return {**found, "search": search}

    def close(self) -> None:
        """Take the form away."""
        with self._lock:
            self._is_closed = True
            for part in self._parts:
                part.remove()

    def _draw(self) -> None:
        try:
            fields = fields_of(self._cell.api.document, _REQUEST, _ELSEWHERE)
            with self._lock, self._place:
                if not self._is_closed:
                    self._fill(fields)
        except Exception as fault:  # noqa: BLE001  (told to the person at the browser)
            self._on_fault(fault)

    def _fill(self, fields: Group) -> None:
        gui = self._gui
        self._told = gui.add_html(texts.told("all by default"))
        where = gui.add_html(texts.told(_WHERE))
        self._reset = reset = gui.add_button(
            "Back to the defaults", icon=viser.Icon.RESTORE, color=texts.SOFT, disabled=True
        )
        # Each field with its first value: it may be filled in while the others are drawn.
        form = Drawing(gui, self._words, self._look, _FIRST).input(fields, is_unfolded=True)
        self._parts = [self._told, where, reset, form]
        reset.on_click(lambda _: form.fill(_AT_FIRST))
        self._planning_time = _planning_time(fields)
        self._form = form
        self._look()

    def _look(self) -> None:
        """Say what is otherwise than by default."""
        if self._form is None:
            return
        try:
            value = self._form.value()
        except ValueError as fault:
            self._told.content = texts.told(str(fault), "bad")
            return
        changed = ", ".join(_names(value))
        told = "all by default" if value == _AT_FIRST else f"otherwise than by default: {changed}"
        self._told.content = texts.told(told)
        self._reset.disabled = value == _AT_FIRST


def _planning_time(fields: Group) -> float:
    """Return how long the server plans by default [s]: what the form leaves out is that."""
    search = next(field for field in fields.fields if field.name == "search")
    inner = search.fields if isinstance(search, Group) else ()
    return float(next(f.default for f in inner if f.name == "allowed_planning_time"))


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
