"""CellPanels: the panels that belong to one scene, and are made anew for the next one."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import viser

from service.studio.api import Api
from service.studio.cell import Cell
from service.studio.editing.edit_panel import EditPanel
from service.studio.editing.overlay_panel import OverlayPanel
from service.studio.forms.options_panel import OptionsPanel
from service.studio.goals.goal_panel import GoalPanel
from service.studio.motions.side_by_side import SideBySide
from service.studio.plans.plan_table import PlanTable
from service.studio.robots.live import LiveRobots


@dataclass(frozen=True)
class Places:
    """Where panels stand.

    Attributes:
        gui: Of one browser.
        goal: The folder of the goal.
        options: The tab of the options.
        scene: The tab of the scene.
        plans: The tab of its plans.
    """

    gui: viser.GuiApi
    goal: viser.GuiFolderHandle
    options: viser.GuiTabHandle
    scene: viser.GuiTabHandle
    plans: viser.GuiTabHandle


@dataclass(frozen=True)
class Listeners:
    """Who is told what goes on in the panels.

    Attributes:
        on_plan: Called with a plan that was chosen from the table.
        on_beside: Called once other plans are to be shown beside it.
        on_goal: Called when the person at the browser asks for another goal.
        on_edit: Called once the scene is another one.
        on_fault: Is told what goes wrong.
        on_presence: Is told when the server is gone, and when it is back.
    """

    on_plan: Callable[[Mapping[str, Any]], None]
    on_beside: Callable[[], None]
    on_goal: Callable[[], None]
    on_edit: Callable[[], None]
    on_fault: Callable[[Exception], None]
    on_presence: Callable[[bool], None]


class CellPanels:
    """Goal, objects, switches, plans and live robots of one scene."""

    def __init__(
        self,
        places: Places,
        cell: Cell,
        live: Api,
        listeners: Listeners,
    ) -> None:
        """Show the panels of a cell.

        Args:
            places: Where they stand.
            cell: The scene.
            live: A connection for the live state, which is closed at the end.
            listeners: Are told what goes on.
        """
        on_plan, on_fault = listeners.on_plan, listeners.on_fault
        self._cell, self._listeners = cell, listeners
        gui = places.gui
        words = _words(cell)
        with places.scene:
            self._edits = EditPanel(gui, cell, self.look_again, on_fault)
            self._overlays = OverlayPanel(gui, cell)
        with places.goal:
            self.goals = GoalPanel(gui, cell, words, self._see_goal, on_fault)
        self.beside = SideBySide(cell, listeners.on_beside, on_fault)
        with places.plans:
            self.plans = PlanTable(gui, cell, self.beside, on_plan, on_fault)
        self._live = LiveRobots(cell, live, self._see_edit, listeners.on_presence)
        self._options = OptionsPanel(gui, places.options, cell, words, on_fault)

    def request(self) -> dict[str, Any]:
        """Return the request for a plan that is filled in.

        Raises:
            FormError: What was written by hand cannot be read.
        """
        cell = self._cell
        chosen = {"scene": cell.scene.id, "group": cell.group.name, "goal": self.goals.goal()}
        return {**chosen, **self._options.options()}

    def look_again(self) -> None:
        """Show the scene as it is now, after an edit."""
        self._edits.refresh()
        self._overlays.refresh()
        self.plans.look_again()
        self._listeners.on_edit()
        self.goals.look_again()

    def close(self) -> None:
        """Take the panels away."""
        self._live.close()
        several = (self._edits, self._overlays, self.plans, self.goals, self._options)
        for panel in (*several, self.beside):
            panel.close()

    def _see_goal(self) -> None:
        self._edits.rest()
        self._listeners.on_goal()

    def _see_edit(self, revision: int) -> None:
        """Draw the scene as another browser, or another client, has changed it."""
        if self._cell.catch_up(revision):
            self.look_again()


def _words(cell: Cell) -> dict[str, list[str]]:
    """Return what may be chosen in forms, by `group.field` or by the field's name."""
    frames = ["world", *(frame for frame in cell.scene.frames if frame != "world")]
    return {
        "planner": cell.api.planner_names,
        "frame": frames,
        "reference": frames,
        "configuration.name": list(cell.group.configurations),
    }
