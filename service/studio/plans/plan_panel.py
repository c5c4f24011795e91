"""PlanPanel: ask for a plan, follow its stages, cancel it, and say what came of it."""

import threading
from collections.abc import Callable, Mapping, Sequence
from html import escape
from typing import Any

import viser

from service.studio import texts
from service.studio.cell import Cell
from service.studio.plans.failure_words import failed
from service.studio.plans.path_so_far import PathSoFar
from service.studio.plans.relaxations import Relaxation

# Words for the stages of the pipeline, as they happen.
_STAGES = {
    "load": "loading the scene",
    "goals": "looking for goal configurations",
    "search": "searching a path",
    "refine": "refining the path",
    "retime": "timing it",
    "certify": "proving it",
    "explain": "finding out why it fails",
}
# Parts of the time that are no stages of their own.
_PARTS = {
    **_STAGES,
    "setup": "preparing the planner",
    "solve": "running the planner",
    "shortcut": "shortening the path",
    "samples": "sampling the motion",
}
# Dark enough for white words.
_GREEN = (15, 118, 110)

# Pages of a plan that stand for themselves, and can be sent on.
_PAGES = {"replay.html": "replay", "report.html": "report"}
_PAGES_OF_FAILURE = {"failure.html": "picture of the failure", "report.html": "report"}


class PlanPanel:
    """The button that plans, and how far it is."""

    def __init__(
        self,
        gui: viser.GuiApi,
        bar: viser.GuiFolderHandle,
        said: viser.GuiFolderHandle,
        on_plan: Callable[[], None],
        pages: Callable[[], str | None],
        best: PathSoFar,
    ) -> None:
        """Show the button.

        Args:
            gui: Of one browser.
            bar: Where the button stands, and stays.
            said: Where it is said how far the plan is.
            on_plan: Called when it is pressed.
            pages: Returns the URL of the server's pages; None if a browser does not get them.
            best: Draws the best path while there is none that is proven.
        """
        self._gui, self._pages, self._best = gui, pages, best
        with bar:
            self._button = gui.add_button("Plan", icon=viser.Icon.ROUTE, color=_GREEN)
            # In the place of the other one, which is there whenever this one is not.
            self._cancel = gui.add_button("Cancel", icon=viser.Icon.X, color="gray", visible=False)
        with said:
            self._bar = gui.add_progress_bar(0.0, animated=True, visible=False)
            self._told = gui.add_html(texts.told(""), visible=False)
            self._instead = gui.add_folder("Ask instead", visible=False)
        self._offered: list[viser.GuiButtonHandle] = []
        self._button.on_click(lambda _: on_plan())
        self._running: tuple[Cell, str] | None = None
        self._lock = threading.Lock()
        self._cancel.on_click(lambda _: self._ask_to_cancel())

    @property
    def is_idle(self) -> bool:
        """Whether it plans nothing."""
        return self._running is None

    def plan(self, cell: Cell, request: Mapping[str, Any]) -> dict[str, Any] | None:
        """Ask for a plan, show each stage, and return the plan once it has ended.

        Args:
            cell: The scene.
            request: As the API wants it.

        Returns:
            The plan; None if another one goes on.
        """
        if not self._lock.acquire(blocking=False):
            return None
        try:
            self._show(is_planning=True)
            self._tell(texts.told("asking for a plan", "busy"))
            self.offer((), lambda _: None)
            plan = cell.api.submit_plan(dict(request))
            self._running = cell, plan.id
            self._best.begin(cell)
            for event in cell.api.plan_events(plan.id):
                if event.type == "stage":
                    self._follow(event.data)
                elif event.type == "best-so-far":
                    best = f"search: the best path so far is {event.data['length']:.2f} long"
                    self._tell(texts.told(best, "busy"))
                    self._best.show(event.data.get("waypoints"))
            return self._ended(cell.api.finished_plan(plan.id))
        finally:
            self._best.end()
            self._running = None
            self._show(is_planning=False)
            self._lock.release()

    def offer(
        self, relaxations: Sequence[Relaxation], on_choose: Callable[[Relaxation], None]
    ) -> None:
        """Show what can be asked instead, a button each; none to take them away."""
        for button in self._offered:
            button.remove()
        self._offered = []
        self._instead.visible = bool(relaxations)
        with self._instead:
            for relaxation in relaxations:
                button = self._gui.add_button(relaxation.text, color=texts.SOFT)
                button.on_click(lambda _, chosen=relaxation: on_choose(chosen))
                self._offered.append(button)

    def clear(self) -> None:
        """Say nothing, once the scene is another one."""
        self._told.visible = False
        self.offer((), lambda _: None)

    def tell_of(self, job: Mapping[str, Any]) -> None:
        """Say what came of a plan, with links to its pages."""
        if job["state"] == "succeeded":
            told, pages = _times(job["timings"]), _PAGES
        else:
            failure = job["failure"] or {}
            code, detail = failure.get("code", job["state"]), failure.get("detail", "")
            told = failed(code, detail, failure.get("evidence"))
            pages = _PAGES_OF_FAILURE
        server = self._pages()
        self._tell(told if server is None else told + texts.pages(server, job["id"], pages))

    def _ended(self, job: dict[str, Any]) -> dict[str, Any]:
        self.tell_of(job)
        return job

    def _follow(self, data: Mapping[str, Any]) -> None:
        stage = data["stage"]
        self._bar.value = 100.0 * float(data.get("progress") or 0.0)
        detail = data.get("detail") or _STAGES.get(stage, stage)
        self._tell(texts.told(f"{stage}: {detail}", "busy"))

    def _ask_to_cancel(self) -> None:
        running = self._running
        if running is not None:
            cell, plan = running
            cell.api.cancel_plan(plan)

    def _tell(self, content: str) -> None:
        self._told.content, self._told.visible = content, True

    def _show(self, *, is_planning: bool) -> None:
        self._button.visible = not is_planning
        self._bar.visible = self._cancel.visible = is_planning
        self._bar.value = 0.0


def _times(timings: Mapping[str, float]) -> str:
    """Return how long a plan took, the longest parts by name; what they are is a hint."""
    parts = {name: 1000 * time for name, time in timings.items() if name != "total"}
    longest = sorted(parts, key=lambda name: -parts[name])[:3]
    several = ", ".join(
        f'<span title="{escape(_PARTS.get(name, name))}" style="cursor:help;'
        f'text-decoration:underline dotted">{escape(name)} {parts[name]:.0f}</span>'
        for name in longest
    )
    return texts.lines(f"planned in {1000 * timings.get('total', 0.0):.0f} ms: {several}", "plain")
