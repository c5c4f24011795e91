"""Session: one browser: the scene that it looks at, and the panels beside it."""

import threading
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import httpx
import viser

from service.client.errors import ApiError
from service.studio import texts
from service.studio.api import Api, ByName
from service.studio.cell import Cell, open_cell
from service.studio.cell_panels import CellPanels, Listeners, Places
from service.studio.forms.help_text import help_text
from service.studio.forms.words import FormError
from service.studio.motions.shown_motion import ShownMotion
from service.studio.notices import Notices
from service.studio.plans.failure_view import show_failure
from service.studio.plans.failure_words import failed
from service.studio.plans.path_so_far import PathSoFar
from service.studio.plans.plan_panel import PlanPanel
from service.studio.plans.relaxations import Relaxation, relaxations_of
from service.studio.plans.search_graph import SearchGraph
from service.studio.robots.robot_panel import RobotPanel
from service.studio.scene_list import SceneList

_BRAND = (29, 111, 184)
_UNAUTHORIZED = 401
# Between looks at which scenes and plans there are [s].
_RENEWAL = 5.0


@dataclass(frozen=True)
class Terms:
    """What all sessions have in common.

    Attributes:
        server: URL of the server.
        scenes: Folder of the scenes that can be opened at once.
        key: API key, if the browsers need not give one.
    """

    server: str
    scenes: Path
    key: str | None = None


class Session:
    """The panels of one browser, and what they do together."""

    def __init__(self, client: viser.ClientHandle, terms: Terms, host: str) -> None:
        """Show the panels and open a scene.

        Args:
            client: The browser.
            terms: Of all sessions.
            host: By which name the browser knows the server; empty for its address.
        """
        self._client, self._terms, self._host = client, terms, host
        self._notices = Notices(client)
        self._tell = self._notices.tell
        self._key = terms.key
        self._api = self._connect()
        self._scenes: SceneList | None = None
        self._cell: Cell | None = None
        self._panels: CellPanels | None = None
        self._graph = SearchGraph()
        self._best = PathSoFar(self._tell)
        self._lock = threading.Lock()
        self._closed = threading.Event()
        client.gui.configure_theme(
            show_logo=False, show_share_button=False, brand_color=_BRAND, control_width="large"
        )
        client.gui.set_panel_label("Wayproof studio")
        try:
            self._begin()
        except ApiError as fault:
            if fault.problem.status != _UNAUTHORIZED:
                raise
            self._ask_for_key()

    def close(self) -> None:
        """Stop what goes on, and forget the scene that was opened for this browser."""
        self._closed.set()
        self._forget()
        self._best.close()
        if self._scenes is not None:
            self._scenes.forget()
        self._api.__exit__(None, None, None)

    def _connect(self) -> Api:
        transport = ByName(self._host) if self._host else None
        return Api(self._terms.server, key=self._key, transport=transport)

    def _pages(self) -> str | None:
        """Return the URL of the server's pages: relative to ours, unless that is another's."""
        if self._key is not None:
            return None
        return "" if self._host else self._terms.server.rstrip("/")

    def _ask_for_key(self) -> None:
        """Ask for an API key: the studio has no rights of its own."""
        with self._client.gui.add_folder("This server asks for a key") as folder:
            told = self._client.gui.add_html(texts.told("a key with the scopes plan and execute"))
            text = self._client.gui.add_text("API key", "")
            enter = self._client.gui.add_button("Open")

        @enter.on_click
        def _(_: Any) -> None:
            self._key = text.value.strip()
            self._api = self._connect()
            try:
                self._api.scenes()
            except ApiError as fault:
                told.content = failed(fault.problem.code, fault.problem.detail)
                return
            folder.remove()
            self._begin()

    def _begin(self) -> None:
        gui = self._client.gui
        self._scenes = SceneList(gui, self._api, self._terms.scenes)
        self._group: Any = gui.add_dropdown("Robot", ("",), hint="The group that is planned for")
        tabs = gui.add_tab_group()
        self._plan_tab = tabs.add_tab("Plan", viser.Icon.ROUTE)
        options_tab = tabs.add_tab("Options", viser.Icon.ADJUSTMENTS)
        scene_tab = tabs.add_tab("Scene", viser.Icon.CUBE)
        plans_tab = tabs.add_tab("Plans", viser.Icon.LIST)
        help_tab = tabs.add_tab("?")
        with self._plan_tab:
            bar = gui.add_folder(None)  # its buttons stay where they are: what is said comes below
            goal = gui.add_folder("Goal")
            said = gui.add_folder(None)
        self._plans = PlanPanel(gui, bar, said, self._plan, self._pages, self._best)
        self._robot = RobotPanel(gui, bar, said, self._execute, self._tell, self._name_of)
        self._motion = ShownMotion(gui, self._plan_tab, self._robot, self._tell)
        with help_tab:
            gui.add_html(help_text(self._pages()))
        self._places = Places(gui, goal, options_tab, scene_tab, plans_tab)
        self._scenes.field.on_update(lambda event: self._open_scene() if event.client else None)
        self._group.on_update(lambda event: self._choose_group() if event.client else None)
        self._open_scene()
        threading.Thread(target=self._renew, daemon=True).start()

    def _renew(self) -> None:
        """Look for scenes and plans that came or went, as long as the browser is there."""
        while not self._closed.wait(_RENEWAL):
            if self._scenes is not None:
                self._scenes.renew()
            if self._panels is not None:
                self._panels.plans.renew()

    def _open_scene(self) -> None:
        scenes = self._scenes
        if scenes is None:
            return
        with self._lock:
            self._forget()
            try:
                self._cell = open_cell(self._api, self._client, scenes.open())
            except (ApiError, httpx.HTTPError) as fault:
                self._tell(fault)
                return
            names = tuple(group.name for group in self._cell.scene.groups)
            self._group.options, self._group.value = names, names[0]
            self._show_panels(self._cell)

    def _choose_group(self) -> None:
        cell = self._cell
        if cell is None or self._group.value == cell.group.name:
            return
        with self._lock:
            self._forget()
            self._cell = open_cell(self._api, self._client, cell.scene.id, self._group.value)
            self._show_panels(self._cell)

    def _show_panels(self, cell: Cell) -> None:
        self._panels = CellPanels(
            self._places,
            cell,
            self._connect(),
            Listeners(
                self._look_at_plan,
                self._play_beside,
                self._motion.note_other_goal,
                self._motion.look_again,
                self._tell,
                self._notices.tell_presence,
            ),
        )

    def _plan(self) -> None:
        with self._lock:  # a scene that opens is waited for: the button is there before all of it
            panels = self._panels
        if panels is None:
            return
        try:
            request = panels.request()
        except FormError as fault:
            self._tell(fault)
            return
        self._ask(request)

    def _ask(self, request: dict[str, Any]) -> None:
        """Plan, and show what came of it."""
        cell, scenes, panels = self._cell, self._scenes, self._panels
        if cell is None or scenes is None or panels is None or not self._plans.is_idle:
            return
        self._motion.close()
        self._graph.clear()
        self._robot.clear()
        cell.view.show_others([])
        try:
            job = self._plans.plan(cell, request)
            if job is None or cell is not self._cell:
                return
            self._graph.show(cell, job)
            if job["state"] == "succeeded":
                self._show_motion(cell, job)
                panels.plans.renew()
            elif job["failure"] is not None:
                show_failure(cell, job["failure"])
                removable = cell.object_names if cell.scene.id == scenes.own else ()
                relaxations = relaxations_of(job["failure"], request, removable)
                self._plans.offer(relaxations, self._relax)
        except Exception as fault:  # noqa: BLE001  (told to the person at the browser)
            self._tell(fault)

    def _relax(self, relaxation: Relaxation) -> None:
        cell, panels = self._cell, self._panels
        if cell is None or panels is None:
            return
        try:
            if relaxation.operations:
                cell.edit(relaxation.operations)
                panels.look_again()
        except (ApiError, httpx.HTTPError) as fault:
            self._tell(fault)
            return
        self._ask(relaxation.request)

    def _look_at_plan(self, job: Mapping[str, Any]) -> None:
        """Show a plan of the table as the motion that can be carried out."""
        cell, panels = self._cell, self._panels
        if cell is None or panels is None:
            return
        group = job["request"]["group"]
        if group != cell.group.name:
            panels.plans.choose(self._motion.plan)
            self._tell(ValueError(f"The plan is of {group}: choose it as the robot first."))
            return
        self._show_motion(cell, job)
        self._plans.tell_of(job)

    def _play_beside(self) -> None:
        """Play the plans that are ticked; where none is looked at, look at the newest of them."""
        panels = self._panels
        jobs = [] if panels is None else panels.beside.jobs
        if self._motion.plan is None and jobs:
            self._look_at_plan(jobs[-1])
        else:
            self._motion.play_beside()

    def _show_motion(self, cell: Cell, job: Mapping[str, Any]) -> None:
        panels = self._panels
        if panels is not None:
            self._motion.show(cell, job, panels.beside)
            panels.plans.choose(job["id"])

    def _execute(self) -> None:
        self._motion.execute()

    def _name_of(self, plan: str) -> str:
        return "the motion" if self._panels is None else self._panels.plans.name_of(plan)

    def _forget(self) -> None:
        """Take away what belongs to the scene before."""
        self._graph.clear()
        self._best.end()
        if self._panels is not None:
            self._motion.close()
            self._panels.close()
            self._panels = None
            self._plans.clear()
            self._robot.clear()
