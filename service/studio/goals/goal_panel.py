"""GoalPanel: where the robot shall go: a frame, a configuration, sliders, or a dragged tool."""

import math
from collections.abc import Callable
from typing import Any

import httpx
import numpy as np
import viser

from service.client.errors import ApiError
from service.studio import texts
from service.studio.cell import Cell
from service.studio.drawing.view import BLOCKED, GHOST
from service.studio.forms.form import Drawing, Words
from service.studio.forms.words import FormError
from service.studio.goals.choices import (
    BY_FORM,
    BY_SLIDERS,
    BY_TOOL,
    CONFIGURATION,
    FRAME,
    free,
    goal_to_begin_with,
    goals_of,
    pose_goal,
    praise,
)
from service.studio.goals.goal_form import SOLVED, GoalForm
from service.studio.goals.solutions import Solutions
from service.studio.newest import Newest
from service.studio.numbers import Array
from service.studio.plans.failure_words import failed

# Of a slider of a joint without limits [rad or m].
_UNLIMITED = 2 * math.pi
_STEP = 0.001
_GIZMO = "/gizmo"
# Ghosts of other ways to reach a goal.
_MAX_OTHERS = 3
_GIZMO_SIZE = 0.22


class GoalPanel:
    """The goal of the next plan, and its ghost."""

    def __init__(
        self,
        gui: viser.GuiApi,
        cell: Cell,
        words: Words,
        on_change: Callable[[], None],
        on_fault: Callable[[Exception], None],
    ) -> None:
        """Show the goals of a cell, and choose the first one.

        Args:
            gui: Where it is shown, in the container that is open.
            cell: The scene.
            words: That may be chosen for texts of a goal in full.
            on_change: Called when the person at the browser asks for another goal.
            on_fault: Is told what goes wrong.
        """
        self._gui, self._cell, self._words, self._on_change = gui, cell, words, on_change
        self._newest, self._on_fault = Newest(on_fault), on_fault
        self._positions = cell.positions
        self._goals = goals_of(cell)
        self._choice = gui.add_dropdown("Goal", tuple(self._goals), hint="Where it shall go")
        self._place = gui.add_folder(None, visible=False)
        self._form: GoalForm | None = None
        self._told = gui.add_html(texts.told("…"))
        self._solutions: Solutions | None = None
        self._way: Any = gui.add_dropdown(
            "Arm pose",
            ("",),
            visible=False,
            hint="Configurations that reach the goal, nearest first: how far they are from "
            "everything, and on which side (+ or -) each part of the arm bends",
        )
        self._nearest: Array | None = None
        self._use_nearest = gui.add_button("Take the nearest", color=texts.SOFT, visible=False)
        self._sliders: list[viser.GuiSliderHandle[float]] = []
        self._folder = gui.add_folder("Joints of the goal", expand_by_default=False)
        with self._folder:
            self._add_sliders(gui)
        self._gizmo = self._add_gizmo()
        self._choice.on_update(lambda event: self._choose_anew() if event.client else None)
        self._way.on_update(lambda event: self._choose_way() if event.client else None)
        self._use_nearest.on_click(lambda _: self._take_nearest())
        self._choose()

    def goal(self) -> dict[str, Any]:
        """Return the goal as the API wants it."""
        choice = self._choice.value
        ways = self._solutions
        if choice == BY_SLIDERS or (ways is not None and self._way.value != ways.names[0]):
            return {"type": "joint", "positions": [self._positions.tolist()]}
        return self._goal_asked()

    def _goal_asked(self) -> dict[str, Any]:
        choice = self._choice.value
        if choice == BY_TOOL and self._gizmo is not None:
            return pose_goal(self._gizmo)
        if choice == BY_FORM:
            return self._opened_form().goal()
        return self._goals[choice]

    def close(self) -> None:
        """End what goes on, and take the panel away."""
        self._newest.close()
        self._cell.view.show_others([])
        for part in (
            self._choice,
            self._told,
            self._way,
            self._use_nearest,
            self._folder,
            self._place,
        ):
            part.remove()

    def _choose_anew(self) -> None:
        try:
            if self._choice.value == BY_TOOL:
                self._move_gizmo(self._cell.positions)
        except (ApiError, httpx.HTTPError) as fault:
            self._on_fault(fault)
        self._on_change()
        self._choose()

    def _choose(self) -> None:
        if self._gizmo is not None:
            self._gizmo.visible = self._choice.value == BY_TOOL
        self._place.visible = self._choice.value == BY_FORM
        self._newest.ask(self._show)

    def look_again(self) -> None:
        """Look at the goal again, once the scene is another one."""
        self._newest.ask(self._show)

    def _show(self) -> None:
        """Show where the goal is, or why it cannot be reached."""
        choice = self._choice.value
        self._nearest = None
        self._use_nearest.visible = False
        if not self._is_pose(choice):
            self._forget_ways()
        if choice == BY_SLIDERS:
            self._judge(self._positions)
        elif choice.startswith(CONFIGURATION):
            name = choice.removeprefix(CONFIGURATION)
            positions = np.array(self._cell.group.configurations[name])
            self._set_sliders(positions)
            self._judge(positions)
        elif choice == BY_FORM:
            self._show_form()
        else:
            self._show_solutions(self._goal_asked())

    def _opened_form(self) -> GoalForm:
        if self._form is None:
            with self._place:
                first = goal_to_begin_with(self._cell)
                drawing = Drawing(self._gui, self._words, self._fill_in)
                self._form = GoalForm(drawing, self._cell.api.document, first)
        return self._form

    def _fill_in(self) -> None:
        if self._form is not None:  # it fills itself in first
            self._on_change()
            self._newest.ask(self._show)

    def _show_form(self) -> None:
        """Show what the goal in full comes to, as far as it is known before a plan."""
        try:
            goal = self._opened_form().goal()
            if goal["type"] in SOLVED:
                self._show_solutions(goal)
            else:
                self._cell.view.show_ghost(None)
                self._told.content = texts.told("a plan finds out what it comes to")
        except ApiError as fault:  # while it is filled in, it is no goal now and then
            self._told.content = failed(fault.problem.code, fault.problem.detail)
        except FormError as fault:
            self._told.content = texts.told(str(fault), "bad")

    def _is_pose(self, choice: str) -> bool:
        return choice == BY_TOOL or choice.startswith(FRAME)

    def _show_solutions(self, goal: dict[str, Any]) -> None:
        cell = self._cell
        start = self._positions if self._choice.value == BY_TOOL else cell.positions
        found = cell.api.ik(cell.scene.id, cell.group.name, goal, start)
        if found["configurations"]:
            solutions = self._solutions = Solutions(found["configurations"])
            self._way.options, self._way.value = solutions.names, solutions.names[0]
            self._way.visible = len(solutions.names) > 1
            best = found["configurations"][0]
            self._told.content = texts.told(praise(best, len(found["configurations"])), "good")
            self._show_way()
            return
        self._forget_ways()
        fault = found["failure"]
        self._told.content = failed(fault["code"], fault["detail"], fault["evidence"])
        nearest = (fault["evidence"] or {}).get("nearest") or {}
        if "positions" in nearest:
            self._nearest = np.array(nearest["positions"])
            self._use_nearest.visible = True
            cell.view.show_ghost(cell.poses(self._nearest), BLOCKED)

    def _show_way(self) -> None:
        """Show the way that is chosen, and the others faintly."""
        cell, solutions = self._cell, self._solutions
        if solutions is None:
            return
        self._set_sliders(solutions.positions(self._way.value))
        cell.view.mark_pairs([], {})
        cell.view.show_ghost(cell.poses(self._positions))
        others = solutions.others(self._way.value, _MAX_OTHERS)
        cell.view.show_others([cell.poses(positions) for positions in others])

    def _choose_way(self) -> None:
        self._on_change()
        self._newest.ask(self._show_way)

    def _forget_ways(self) -> None:
        self._solutions = None
        self._way.visible = False
        self._cell.view.show_others([])

    def _take_nearest(self) -> None:
        """Make the nearest configuration that is free the goal; a dragged tool goes there."""
        nearest = self._nearest  # what is asked meanwhile may take it away
        if nearest is None:
            return
        self._set_sliders(nearest)
        if self._choice.value != BY_TOOL:
            self._slide()
            return
        self._move_gizmo(nearest)
        self._on_change()
        self._newest.ask(self._show)

    def _judge(self, positions: Array) -> None:
        """Show the ghost at some positions, red with its pairs where it collides."""
        cell = self._cell
        verdict = cell.api.check(cell.scene.id, cell.group.name, positions)[0]
        poses = cell.poses(positions)
        cell.view.show_ghost(poses, GHOST if verdict["valid"] else BLOCKED)
        cell.view.mark_pairs(verdict["collisions"], poses)
        if verdict["collisions"]:
            self._told.content = texts.pairs(verdict["collisions"])
        elif not verdict["valid"]:
            self._told.content = texts.told("outside of the joint limits", "bad")
        else:
            self._told.content = texts.told(free(verdict), "good")

    def _add_sliders(self, gui: viser.GuiApi) -> None:
        limits, group = self._cell.group.limits, self._cell.group
        for i, name in enumerate(group.position_names):
            lower, upper = limits.lower[i], limits.upper[i]
            low = -_UNLIMITED if lower is None else lower
            high = _UNLIMITED if upper is None else upper
            value = float(np.clip(self._positions[i], low, high))
            slider = gui.add_slider(name.rpartition("::")[2], low, high, _STEP, value)
            slider.on_update(lambda event: self._slide() if event.client else None)
            self._sliders.append(slider)

    def _slide(self) -> None:
        self._positions = np.array([slider.value for slider in self._sliders])
        if self._choice.value != BY_SLIDERS:
            self._choice.value = BY_SLIDERS
            self._place.visible = False
            if self._gizmo is not None:
                self._gizmo.visible = False
        self._on_change()
        self._newest.ask(self._show)

    def _set_sliders(self, positions: Array) -> None:
        self._positions = positions
        for slider, value in zip(self._sliders, positions, strict=True):
            slider.value = float(np.clip(value, slider.min, slider.max))

    def _add_gizmo(self) -> viser.TransformControlsHandle | None:
        cell = self._cell
        if not cell.group.tool_frames:
            return None
        gizmo = cell.client.scene.add_transform_controls(
            _GIZMO, scale=_GIZMO_SIZE, depth_test=False, visible=False
        )
        gizmo.on_update(lambda _: self._drag())
        return gizmo

    def _move_gizmo(self, positions: Array) -> None:
        """Put the handle to the tool of the group at some positions."""
        cell, gizmo = self._cell, self._gizmo
        if gizmo is None:
            return
        tool = cell.group.tool_frames[0]
        pose = cell.api.poses(cell.scene.id, cell.group.name, positions, [tool])[tool][0]
        gizmo.position, gizmo.wxyz = tuple(pose[:3]), tuple(pose[3:])

    def _drag(self) -> None:
        self._on_change()
        self._newest.ask(self._show)
