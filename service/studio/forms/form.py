"""Form: inputs for all fields of a schema; what it is filled with, as the server wants it."""

import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, override

import viser

from service.studio import texts
from service.studio.forms.fields import (
    Field,
    Group,
    Items,
    OneOf,
    Optional,
)
from service.studio.forms.inputs import Input, single
from service.studio.forms.words import label_of, spoken

type Words = Mapping[str, Sequence[str]]


@dataclass(frozen=True)
class Drawing:
    """What inputs are made with.

    Attributes:
        gui: Of one browser.
        words: That may be chosen for a text, by `group.field` or by the field's name.
        on_change: Called when another value was filled in.
        first: What single values begin with that do not with their default, by `group.field`.
    """

    gui: viser.GuiApi
    words: Words
    on_change: Callable[[], None]
    first: Mapping[str, Any] = MappingProxyType({})

    def input(self, field: Field, parent: str = "", *, is_unfolded: bool = False) -> Input:
        """Return an input for a field, shown in the container that is open.

        Args:
            field: What is filled in.
            parent: Name of the field that it is of.
            is_unfolded: Whether a group of fields is shown without a folder.
        """
        match field:
            case Group():
                return GroupInput(self, field, is_unfolded=is_unfolded)
            case Optional():
                return OptionalInput(self, field, parent)
            case Items():
                return ItemsInput(self, field)
            case OneOf():
                return OneOfInput(self, field)
            case _:
                name = f"{parent}.{field.name}"
                known = self.words.get(name, self.words.get(field.name, ()))
                made = single(self.gui, field, known, self.on_change)
                if name in self.first:
                    made.fill(self.first[name])
                return made


class GroupInput(Input):
    """Several fields; what is as it is by default is left out."""

    def __init__(self, drawing: Drawing, field: Group, *, is_unfolded: bool = False) -> None:
        """Show the fields, in a folder that is closed, or where the form stands."""
        label = None if is_unfolded else spoken(field.name)
        self._folder = drawing.gui.add_folder(label, expand_by_default=False)
        self._fields = field.fields
        with self._folder:
            # What most need is on top, and what opens comes below it.
            order = sorted(field.fields, key=lambda inner: isinstance(inner, Group | Items))
            self._inputs = {inner.name: drawing.input(inner, field.name) for inner in order}

    @override
    def value(self) -> dict[str, Any]:
        found = {field.name: self._inputs[field.name].value() for field in self._fields}
        return {
            field.name: found[field.name]
            for field in self._fields
            if field.is_required or found[field.name] != _left_out(field)
        }

    @override
    def fill(self, value: Mapping[str, Any]) -> None:
        for field in self._fields:
            if field.name in value:
                self._inputs[field.name].fill(value[field.name])
            elif not field.is_required:
                self._inputs[field.name].fill(_left_out(field))

    @override
    def remove(self) -> None:
        self._folder.remove()


class OptionalInput(Input):
    """A switch, and what it switches on."""

    def __init__(self, drawing: Drawing, field: Optional, parent: str) -> None:
        """Show the switch; the rest only while it is on."""
        self._drawing, self._field, self._parent = drawing, field, parent
        label, is_on = label_of(field), field.default is not None
        self._switch = drawing.gui.add_checkbox(label, is_on, hint=field.text)
        self._folder = drawing.gui.add_folder(None)
        self._inner: Input | None = None
        self._lock = threading.RLock()
        self._switch.on_update(lambda _: self._turn())
        self._turn()

    @override
    def value(self) -> Any:
        return self._inner.value() if self._inner is not None else None

    @override
    def fill(self, value: Any) -> None:
        self._switch.value = value is not None
        self._turn()
        if self._inner is not None:
            self._inner.fill(value)

    @override
    def remove(self) -> None:
        self._switch.remove()
        self._folder.remove()

    def _turn(self) -> None:
        with self._lock:
            is_on = bool(self._switch.value)
            self._folder.visible = is_on
            if is_on == (self._inner is not None):
                return
            if self._inner is not None:
                self._inner.remove()
                self._inner = None
            else:
                with self._folder:
                    self._inner = self._drawing.input(
                        self._field.inner, self._parent, is_unfolded=True
                    )
        self._drawing.on_change()


class OneOfInput(Input):
    """A choice of alternatives, and the fields of the one that is chosen."""

    def __init__(self, drawing: Drawing, field: OneOf) -> None:
        """Show the alternative that is the default, else the first."""
        self._drawing, self._field = drawing, field
        self._alternatives = {one.name: one for one in field.alternatives}
        label = spoken(field.tag) if field.tag else f"{spoken(field.name)}: how many"
        first = self._name_of(field.default)
        names = tuple(self._alternatives)
        self._choice: Any = drawing.gui.add_dropdown(
            label, names, initial_value=first, hint=field.text
        )
        self._folder = drawing.gui.add_folder(None)
        self._inner, self._shown = self._drawn(first), first
        self._lock = threading.RLock()
        if field.default is not None:
            self.fill(field.default)
        self._choice.on_update(lambda _: self._choose())

    @override
    def value(self) -> Any:
        inner = self._inner.value()
        return {self._field.tag: self._shown, **inner} if self._field.tag else inner

    @override
    def fill(self, value: Any) -> None:
        self._choice.value = self._name_of(value)
        self._choose()
        self._inner.fill(value)

    @override
    def remove(self) -> None:
        self._choice.remove()
        self._folder.remove()

    def _choose(self) -> None:
        with self._lock:
            if self._choice.value == self._shown:
                return
            self._inner.remove()
            self._shown = str(self._choice.value)
            self._inner = self._drawn(self._shown)
        self._drawing.on_change()

    def _drawn(self, name: str) -> Input:
        chosen = self._alternatives[name]
        with self._folder:
            if self._field.tag:
                return self._drawing.input(chosen, is_unfolded=True)
            return self._drawing.input(replace(chosen, name=self._field.name))

    def _name_of(self, value: Any) -> str:
        names = tuple(self._alternatives)
        if self._field.tag:
            return str(value[self._field.tag]) if value else names[0]
        is_list = isinstance(value, list)
        return next((name for name in names if (name == "several") == is_list), names[0])


class ItemsInput(Input):
    """A list of things, each of which can be taken away, and a button for one more."""

    def __init__(self, drawing: Drawing, field: Items) -> None:
        """Show as many as there must be."""
        self._drawing, self._field = drawing, field
        gui = drawing.gui
        self._folder = gui.add_folder(spoken(field.name), expand_by_default=False)
        self._items: list[tuple[viser.GuiFolderHandle, Input]] = []
        with self._folder:
            self._more = gui.add_button("Add", icon=viser.Icon.PLUS, color=texts.SOFT)
        self._more.on_click(lambda _: self._add_one())
        for _ in range(field.fewest):
            self._add()

    @override
    def value(self) -> list[Any]:
        return [inner.value() for _, inner in self._items]

    @override
    def fill(self, value: Sequence[Any]) -> None:
        for folder, _ in self._items:
            folder.remove()
        self._items = []
        for entry in value:
            self._add()
            self._items[-1][1].fill(entry)

    @override
    def remove(self) -> None:
        self._folder.remove()

    def _add_one(self) -> None:
        if len(self._items) < self._field.most:
            self._add()
            self._drawing.on_change()

    def _add(self) -> None:
        gui = self._drawing.gui
        with self._folder:
            folder = gui.add_folder(f"{len(self._items) + 1}")
        with folder:
            inner = self._drawing.input(self._field.inner, self._field.name, is_unfolded=True)
            button = gui.add_button("Remove", icon=viser.Icon.TRASH, color=texts.SOFT)
        item = folder, inner
        self._items.append(item)
        button.on_click(lambda _: self._drop(item))

    def _drop(self, item: tuple[viser.GuiFolderHandle, Input]) -> None:
        if item in self._items and len(self._items) > self._field.fewest:
            self._items.remove(item)
            item[0].remove()
            self._drawing.on_change()


def _left_out(field: Field) -> Any:
    """Return what a field is that is left out."""
    if field.default is not None:
        return field.default
    return {} if isinstance(field, Group) else [] if isinstance(field, Items) else None
