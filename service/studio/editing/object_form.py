"""ObjectForm: name, place and sizes of one object, typed by hand."""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import viser
import viser.transforms as vtf

from service.studio.editing.sizes import sizes_of, with_size
from service.studio.numbers import Array

_STEP = 0.001
# Decimals that are shown, and that can be typed: what is finer than them is the same.
_DIGITS = 6
_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_.-]*")
# Of places that are the same: finer than the page lets one type [m or 1].
_SAME = 1e-6


@dataclass(frozen=True)
class Change:
    """What was typed.

    Attributes:
        entry: The object as it shall be.
        verb: What is done to it: rename, resize or move.
    """

    entry: dict[str, Any]
    verb: str


class ObjectForm:
    """Fields of an object, hidden while none is chosen."""

    def __init__(self, gui: viser.GuiApi, on_change: Callable[[], None]) -> None:
        """Show no object.

        Args:
            gui: Where it is shown, in the container that is open.
            on_change: Called with each key that is typed.
        """
        self._name: Any = gui.add_text("Name", "", visible=False)
        zero = (0.0, 0.0, 0.0)
        self._position: Any = gui.add_vector3("Position [m]", zero, step=_STEP, visible=False)
        self._turn: Any = gui.add_vector3(
            "Roll, pitch, yaw [rad]", zero, step=_STEP, visible=False, hint="About x, y, z of world"
        )
        self._sizes: list[Any] = [
            gui.add_number(f"Size {axis} [m]", 0.1, step=_STEP, visible=False)
            for axis in ("1", "2", "3")
        ]
        for field in (self._position, self._turn, *self._sizes):
            field.precision = _DIGITS
        for field in (self._name, self._position, self._turn, *self._sizes):
            field.on_update(lambda event: on_change() if event.client else None)

    def show(self, entry: Mapping[str, Any] | None, pose: Array | None) -> None:
        """Show an object, or none.

        Args:
            entry: As the scene's document has it.
            pose: X_WO, shape (7,); None if it cannot be moved now.
        """
        sizes = {} if entry is None else sizes_of(entry)
        for slot, field in enumerate(self._sizes):
            is_used = slot < len(sizes)
            field.visible = is_used
            if is_used:
                field.label, field.value = list(sizes.items())[slot]
        self._name.visible = entry is not None
        self._name.value = "" if entry is None else entry["name"]
        self._position.visible = self._turn.visible = pose is not None
        if pose is not None:
            self.put(pose)

    def put(self, pose: Array) -> None:
        """Show where the object is: X_WO, shape (7,)."""
        self._position.value = tuple(map(float, pose[:3]))
        self._turn.value = _rpy(pose[3:])

    def change(self, entry: Mapping[str, Any], pose: Array) -> Change | None:
        """Return what was typed; None if nothing is otherwise.

        Args:
            entry: The object as it is.
            pose: X_WO as it is, shape (7,).

        Raises:
            ValueError: It is no object.
        """
        changed, verb = dict(entry), ""
        if self._position.visible and not self._is_at(pose):
            turned = vtf.SO3.from_rpy_radians(*map(float, self._turn.value)).wxyz
            place = {"position": [*map(float, self._position.value)], "quaternion": [*turned]}
            changed["pose"] = {key: list(map(float, row)) for key, row in place.items()}
            verb = "move"
        sizes = sizes_of(entry)
        values = [float(field.value) for field in self._sizes if field.visible]
        if values != [*sizes.values()]:
            changed, verb = with_size(changed, _above_zero([*sizes], values)), "resize"
        name = str(self._name.value).strip()
        if name != entry["name"]:
            if not _NAME.fullmatch(name):
                message = f"{name!r} is no name: letters, digits, _, . and -, a letter first"
                raise ValueError(message)
            changed, verb = {**changed, "name": name}, "rename"
        return Change(changed, verb) if verb else None

    def _is_at(self, pose: Array) -> bool:
        turn = np.subtract(self._turn.value, _rpy(pose[3:]))
        moved = np.subtract(self._position.value, pose[:3])
        return bool(np.abs([*moved, *turn]).max() < _SAME)


def _rpy(wxyz: Sequence[float] | Array) -> tuple[float, ...]:
    found = vtf.SO3(np.asarray(wxyz, dtype=float)).as_rpy_radians()
    return tuple(round(float(part), 9) for part in (found.roll, found.pitch, found.yaw))


def _above_zero(names: Sequence[str], values: Sequence[float]) -> Sequence[float]:
    for name, value in zip(names, values, strict=True):
        if value <= 0:
            message = f"{name.partition(' [')[0]} must be above 0"
            raise ValueError(message)
    return values
