"""Inputs: one value each: a number, a word, a choice, a flag, a vector."""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import Any, override

import numpy as np
import viser

from service.studio.forms.fields import Choice, Field, Flag, Number, Vector, Written
from service.studio.forms.words import label_of, read, spoken, written

# Beyond a lower bound that is excluded: the nearest that the page lets one type.
_ABOVE = 1e-6
_STEP = 0.001
# Decimals that are shown, and that can be typed: viser takes as many as the first value has.
_DIGITS = 6
# What numbers without a default begin with, where the bounds allow it.
_FIRST, _FIRST_WHOLE = 0.1, 10


class Input(ABC):
    """A part of a form that has a value, as the JSON has it."""

    @abstractmethod
    def value(self) -> Any:
        """Return the value.

        Raises:
            FormError: It cannot be read.
        """

    @abstractmethod
    def fill(self, value: Any) -> None:
        """Show another value."""

    @abstractmethod
    def remove(self) -> None:
        """Take it away."""


class Single(Input):
    """A value with one handle of the page."""

    def __init__(self, handle: Any, on_change: Callable[[], None]) -> None:
        """Listen to a handle.

        Args:
            handle: Of viser.
            on_change: Called when another value was filled in.
        """
        self._handle = handle
        handle.on_update(lambda _: on_change())

    @override
    def value(self) -> Any:
        return self._handle.value

    @override
    def fill(self, value: Any) -> None:
        self._handle.value = value

    @override
    def remove(self) -> None:
        self._handle.remove()


class NumberInput(Single):
    """A number within its bounds; a factor up to 1 is a slider."""

    def __init__(self, gui: viser.GuiApi, field: Number, on_change: Callable[[], None]) -> None:
        """Show a number."""
        self._field = field
        self._lower = _lowest(field)
        first = self._first() if field.default is None else field.default
        label = label_of(field)
        handle: Any
        if field.default == field.upper == 1 and not field.is_whole:
            handle = gui.add_slider(label, self._lower or 0.0, 1.0, 0.01, 1.0, hint=field.text)
        else:
            handle = gui.add_number(
                label,
                round(first) if field.is_whole else float(first),  # it keeps this type
                min=self._lower,
                max=field.upper,
                step=1 if field.is_whole else _STEP,
                hint=field.text,
            )
            if not field.is_whole:
                handle.precision = max(handle.precision, _DIGITS)
        super().__init__(handle, on_change)

    @override
    def value(self) -> float | int:
        return _within(self._handle.value, self._field, self._lower)

    def _first(self) -> float | int:
        return _within(_FIRST_WHOLE if self._field.is_whole else _FIRST, self._field, self._lower)


class VectorInput(Single):
    """Three numbers within their bounds."""

    def __init__(self, gui: viser.GuiApi, field: Vector, on_change: Callable[[], None]) -> None:
        """Show three numbers."""
        self._field = field
        self._lower = _lowest(field)
        least = _FIRST if field.excludes_lower else 0.0
        first = field.default or [max(least, self._lower or 0.0)] * 3
        handle = gui.add_vector3(
            label_of(field),
            np.array(first),
            min=self._bound(self._lower),
            max=self._bound(field.upper),
            step=_STEP,
            hint=field.text,
        )
        handle.precision = max(handle.precision, _DIGITS)
        super().__init__(handle, on_change)

    @override
    def value(self) -> list[float | int]:
        return [_within(float(x), self._field, self._lower) for x in self._handle.value]

    @override
    def fill(self, value: Any) -> None:
        self._handle.value = tuple(map(float, value))

    @staticmethod
    def _bound(bound: float | None) -> tuple[float, float, float] | None:
        return None if bound is None else (bound, bound, bound)


class WrittenInput(Single):
    """A list or a map that is written by hand."""

    def __init__(self, gui: viser.GuiApi, field: Written, on_change: Callable[[], None]) -> None:
        """Show what is written."""
        self._field = field
        # What is left out is no map, and an empty one is shown as none.
        text = written(field.default or None)
        super().__init__(gui.add_text(label_of(field), text, hint=field.text), on_change)

    @override
    def value(self) -> Any:
        field = self._field
        found = read(self._handle.value, field.name)
        if found is not None or not field.is_required:
            return field.default if found is None else found
        return {} if field.schema.get("type") == "object" else []

    @override
    def fill(self, value: Any) -> None:
        self._handle.value = written(value or None)


def single(
    gui: viser.GuiApi, field: Field, words: Sequence[str], on_change: Callable[[], None]
) -> Input:
    """Return an input of a field that has one value.

    Args:
        gui: Where it is shown, in the container that is open.
        field: No group, no list, no alternatives.
        words: That may be chosen, if the field is a word; none for any.
        on_change: Called when another value was filled in.
    """
    label = spoken(field.name)
    match field:
        case Flag():
            handle = gui.add_checkbox(label, bool(field.default), hint=field.text)
            return Single(handle, on_change)
        case Choice():
            first = field.default or field.options[0]
            options = field.options
            handle = gui.add_dropdown(label, options, initial_value=first, hint=field.text)
            return Single(handle, on_change)
        case Number():
            return NumberInput(gui, field, on_change)
        case Vector():
            return VectorInput(gui, field, on_change)
        case Written():
            return WrittenInput(gui, field, on_change)
        case _:
            return _word(gui, field, words, on_change)


def _word(
    gui: viser.GuiApi, field: Field, words: Sequence[str], on_change: Callable[[], None]
) -> Input:
    label, first = spoken(field.name), field.default
    if not words:
        return Single(gui.add_text(label, first or "", hint=field.text), on_change)
    options = tuple(words) if first is None or first in words else (first, *words)
    chosen = options[0] if first is None else first
    handle = gui.add_dropdown(label, options, initial_value=chosen, hint=field.text)
    return WordInput(handle, on_change)


class WordInput(Single):
    """A word of several that are known; another one that is filled in joins them."""

    @override
    def fill(self, value: Any) -> None:
        if value not in self._handle.options:
            self._handle.options = (*self._handle.options, value)
        self._handle.value = value


def _lowest(field: Number | Vector) -> float | None:
    return _ABOVE if field.excludes_lower and field.lower == 0 else field.lower


def _within(value: float, field: Number | Vector, lower: float | None) -> float | int:
    low = -math.inf if lower is None else lower
    high = math.inf if field.upper is None else field.upper
    found = float(np.clip(value, low, high))
    return round(found) if isinstance(field, Number) and field.is_whole else found
