"""EditPanel: objects of the scene: add, move by a gizmo, resize, delete, undo, save."""

from collections.abc import Callable
from typing import Any

import numpy as np
import viser
import yaml

from service.studio import texts
from service.studio.cell import Cell
from service.studio.editing.dropped_mesh import ENDINGS, hull_of_file, name_of_file
from service.studio.editing.history import (
    SHAPES,
    Operation,
    inverse,
    new_object,
    object_of,
    replacement,
)
from service.studio.editing.object_form import ObjectForm
from service.studio.editing.settled import Settled
from service.studio.newest import Newest
from service.studio.numbers import Array

_NOTHING = "(choose)"
_GIZMO = "/edit_gizmo"
# Where new objects begin, beside what the robot does [m].
_BESIDE = [0.4, -0.4, 0.3]
# Of a place that is dragged to [m]: finer than a hand, and its fields have room for it.
_DECIMALS = 4
# Files do not say what their numbers mean [m].
_UNITS = {"metres": 1.0, "millimetres": 0.001, "inches": 0.0254}


class EditPanel:
    """What can be done to the objects of a scene."""

    def __init__(
        self,
        gui: viser.GuiApi,
        cell: Cell,
        on_edit: Callable[[], None],
        on_fault: Callable[[Exception], None],
    ) -> None:
        """Show the objects of a cell.

        Args:
            gui: Where it is shown, in the container that is open.
            cell: The scene.
            on_edit: Called once the scene is another one.
            on_fault: Is told what goes wrong.
        """
        self._cell, self._on_edit, self._on_fault = cell, on_edit, on_fault
        self._newest = Newest(on_fault)
        self._settled = Settled(self._newest.ask)
        self._undone: list[tuple[list[Operation], str]] = []
        self._folder = gui.add_folder("Objects")
        with self._folder:
            self._add = gui.add_button_group("Add", tuple(SHAPES))
            self._file = gui.add_upload_button(
                "Add an STL or OBJ file",
                icon=viser.Icon.UPLOAD,
                color=texts.SOFT,
                mime_type=",".join(ENDINGS),
                hint="It counts as its convex hull, as all meshes do",
            )
            self._unit: Any = gui.add_dropdown("Unit of files", tuple(_UNITS))
            self._object: Any = gui.add_dropdown("Object", (_NOTHING, *cell.object_names))
            self._form = ObjectForm(gui, lambda: self._settled.ask(self._take_typed))
            self._delete = gui.add_button("Delete", icon=viser.Icon.TRASH, color=texts.SOFT)
            self._undo = gui.add_button("Undo", icon=viser.Icon.ARROW_BACK_UP, color=texts.SOFT)
            self._save = gui.add_button("Save as YAML", icon=viser.Icon.DOWNLOAD, color=texts.SOFT)
            self._told = gui.add_html(
                texts.told("Choose an object to drag it, or to type where it is.")
            )
        self._gizmo: Any = cell.client.scene.add_transform_controls(
            _GIZMO, scale=0.2, depth_test=False, visible=False
        )
        self._delete.disabled = self._undo.disabled = True
        self._listen()

    def close(self) -> None:
        """Take the panel away."""
        self._settled.drop()
        self._newest.close()
        self._gizmo.remove()
        self._folder.remove()

    def refresh(self) -> None:
        """Show the objects that the scene has now."""
        names = (_NOTHING, *self._cell.object_names)
        chosen = self._object.value if self._object.value in names else _NOTHING
        if names != self._object.options:
            self._object.options, self._object.value = names, chosen
        if not self._settled.is_waiting:  # what is being typed stays
            self._choose()

    def rest(self) -> None:
        """Hide the gizmo, while a goal is looked for: it would cover the goal's."""
        self._gizmo.visible = False

    def _listen(self) -> None:
        self._add.on_click(lambda _: self._newest.ask(self._add_object))
        self._file.on_upload(lambda _: self._newest.ask(self._add_file))
        self._object.on_update(lambda event: self._choose_anew() if event.client else None)
        self._delete.on_click(lambda _: self._newest.ask(self._remove_object))
        self._undo.on_click(lambda _: self._newest.ask(self._take_back))
        self._save.on_click(lambda _: self._send_file())
        self._gizmo.on_update(self._drag)

    @property
    def _name(self) -> str | None:
        return None if self._object.value == _NOTHING else str(self._object.value)

    def _choose_anew(self) -> None:
        self._settled.drop()
        self._choose()

    def _choose(self) -> None:
        """Put the gizmo to the object, and show its sizes."""
        name = self._name
        is_held = name in self._cell.view.moving
        self._gizmo.visible = name is not None and not is_held
        self._delete.disabled = name is None or is_held
        pose = None if name is None or is_held else self._cell.view.pose_of(name)
        entry = None if name is None else object_of(self._cell.scene.document, name)
        self._form.show(entry, pose)
        if pose is not None:
            self._gizmo.position, self._gizmo.wxyz = tuple(pose[:3]), tuple(pose[3:])

    def _pose(self) -> Array:
        return np.array([*np.round(self._gizmo.position, _DECIMALS), *self._gizmo.wxyz])

    def _drag(self, event: viser.TransformControlsEvent) -> None:
        name = self._name
        if event.phase == "end":
            self._newest.ask(self._move_object)
        elif name is not None:
            self._cell.view.show({name: self._pose()})
            self._form.put(self._pose())

    def _add_object(self) -> None:
        entry = new_object(self._cell.scene.document, str(self._add.value), _BESIDE)
        self._add_entry(entry)

    def _add_entry(self, entry: dict[str, Any]) -> None:
        name = entry["name"]
        self._carry_out([{"op": "add", "object": entry}], f"add {name}", name)

    def _add_file(self) -> None:
        """Add the convex hull of a file, where it stands in the file's own frame."""
        file = self._file.value
        try:
            corners = hull_of_file(file.name, file.content, _UNITS[self._unit.value])
        except ValueError as fault:
            self._told.content = texts.told(str(fault), "bad")
            return
        kind = name_of_file(file.name)
        shape = {"convex": {"points": corners.tolist()}}
        entry = new_object(self._cell.scene.document, kind, [0.0, 0.0, 0.0], shape)
        self._add_entry(entry)

    def _move_object(self) -> None:
        if self._name is not None:
            row = [float(x) for x in self._pose()]
            self._move(self._name, {"position": row[:3], "quaternion": row[3:]})

    def _move(self, name: str, pose: dict[str, Any]) -> None:
        self._carry_out([{"op": "move", "object": name, "pose": pose}], f"move {name}")

    def _take_typed(self) -> None:
        """Change the object as was typed, in one step, or show again what it is."""
        name, document = self._name, self._cell.scene.document
        if name is None or name not in self._cell.object_names:
            return
        try:
            change = self._form.change(object_of(document, name), self._cell.view.pose_of(name))
            if change is None:
                return
            if change.verb == "move":
                self._move(name, change.entry["pose"])
                return
            operations = replacement(document, name, change.entry)
        except ValueError as fault:
            self._told.content = texts.told(str(fault), "bad")
            self._choose()
            return
        now = change.entry["name"]
        to = "" if now == name else f" to {now}"
        self._carry_out(operations, f"{change.verb} {name}{to}", now)

    def _remove_object(self) -> None:
        if self._name is not None:
            self._carry_out([{"op": "remove", "object": self._name}], f"remove {self._name}")

    def _take_back(self) -> None:
        if self._undone:
            operations, words = self._undone.pop()
            self._carry_out(operations, f"undo: {words}", can_be_undone=False)

    def _carry_out(
        self,
        operations: list[Operation],
        words: str,
        chosen: str | None = None,
        *,
        can_be_undone: bool = True,
    ) -> None:
        before = self._cell.scene.document
        try:
            self._cell.edit(operations)
        except Exception:
            self._cell.refresh()  # back to where the server has it
            self.refresh()
            raise
        if can_be_undone:
            self._undone.append((inverse(before, operations), words))
        self._undo.disabled = not self._undone
        if chosen is not None:
            self._object.options = (_NOTHING, *self._cell.object_names)
            self._object.value = chosen
        self._on_edit()
        self._told.content = texts.told(f"revision {self._cell.scene.revision}: {words}", "good")

    def _send_file(self) -> None:
        scene = self._cell.scene
        content = yaml.safe_dump(scene.document, sort_keys=False, default_flow_style=None)
        name = f"{scene.name}.scene.yaml"
        self._cell.client.send_file_download(name, content.encode(), save_immediately=True)
