"""PlanTable: the plans of a scene side by side, each with its path in a colour of its own."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import viser

from service.studio import texts
from service.studio.cell import Cell
from service.studio.motions.side_by_side import Companion, SideBySide
from service.studio.newest import Newest
from service.studio.numbers import Array
from service.studio.plans.ticks import PlanTicks

_MOST = 8
# None is the blue of the ghost: that is the plan that is looked at.
_COLORS = (
    (224, 122, 31),
    (42, 157, 143),
    (217, 39, 190),
    (140, 109, 70),
    (122, 92, 199),
    (194, 50, 91),
    (75, 85, 99),
    (181, 162, 27),
)
# Points of a path that are drawn.
_NUM_POINTS = 40
_NONE = "(choose)"


@dataclass(frozen=True)
class PlanRow:
    """A plan in the table.

    Attributes:
        job: The plan, with its result.
        number: By which the table calls it.
        color: Of its path.
    """

    job: Mapping[str, Any]
    number: int
    color: tuple[int, int, int]

    @property
    def cells(self) -> list[str]:
        """Duration, clearance, and the length of the tool's path."""
        result = self.job["result"]
        gap = result["certificate"]["min_clearance"]
        return [
            f"{result['trajectory']['duration']:.2f} s",
            "" if gap is None else texts.millimetres(gap),
            f"{sum(part['length'] for part in result['parts']):.2f} m",
        ]

    @property
    def revision(self) -> int:
        """Of the scene that it was planned in."""
        return int(self.job["request"]["revision"])

    def proof(self, newest: int) -> str:
        """Return where it is proven, as HTML.

        Args:
            newest: Revision that the scene has now.
        """
        if not self.job["result"]["certificate"]["proven"]:
            return "not proven"
        if self.revision == newest:
            return f"proven in {newest}"
        return f'<span style="color:{texts.COLORS["warn"]}">proven in {self.revision}</span>'


class PlanTable:
    """The newest plans of a scene that succeeded, of this browser and of all others."""

    def __init__(
        self,
        gui: viser.GuiApi,
        cell: Cell,
        beside: SideBySide,
        on_choose: Callable[[Mapping[str, Any]], None],
        on_fault: Callable[[Exception], None],
    ) -> None:
        """Show the plans of a cell.

        Args:
            gui: Where it is shown, in the container that is open.
            cell: The scene.
            beside: Shows the plans that are ticked.
            on_choose: Called with the plan that was chosen.
            on_fault: Is told what goes wrong.
        """
        self._cell, self._beside, self._on_choose = cell, beside, on_choose
        self._newest = Newest(on_fault)
        self._rows: dict[str, PlanRow] = {}
        self._shown: list[str] = []
        self._plan: str | None = None
        self._traces: dict[str, viser.SceneNodeHandle] = {}
        self._folder = gui.add_folder("Plans of this scene")
        with self._folder:
            self._table = gui.add_html(texts.told("There is none yet."))
            self._chosen: Any = gui.add_dropdown("Look at", (_NONE,), visible=False)
            self._paths = gui.add_checkbox("Paths", initial_value=True)
            self._ticks = PlanTicks(gui, self._show_beside, self._show_beside)
        self._chosen.on_update(lambda event: self._choose() if event.client else None)
        self._paths.on_update(lambda _: self._show_paths())
        self.renew()

    def renew(self) -> None:
        """Look for plans that came."""
        self._newest.ask(self._look)

    def look_again(self) -> None:
        """Say which proofs are of the scene as it is now."""
        rows = [self._rows[name] for name in self._shown]
        if rows:
            self._table.content = table_of(rows, self._cell.scene.revision)

    def choose(self, plan: str | None) -> None:
        """Say that a plan is looked at: its id."""
        self._plan = plan
        self._show_choice()

    def name_of(self, plan: str) -> str:
        """Return what a plan is called."""
        row = self._rows.get(plan)
        return "the motion" if row is None else f"plan {row.number}"

    def close(self) -> None:
        """Take the table and its paths away."""
        self._newest.close()
        for trace in self._traces.values():
            trace.remove()
        self._folder.remove()

    def _look(self) -> None:
        cell = self._cell
        names = cell.api.succeeded_plans(cell.scene.id, _MOST)
        if all(name in self._rows for name in names):
            return
        for name in reversed(names):
            if name not in self._rows:
                job = cell.api.finished_plan(name)
                number = len(self._rows) + 1
                color = _COLORS[(number - 1) % len(_COLORS)]
                self._rows[name] = row = PlanRow(job, number, color)
                self._draw(name, row)
        self._shown = names
        self.look_again()
        self._chosen.options = (_NONE, *map(self.name_of, names))
        self._show_choice()
        self._chosen.visible = True
        self._ticks.renew({name: self.name_of(name) for name in reversed(names)})
        self._show_paths()

    def _draw(self, name: str, row: PlanRow) -> None:
        points = self._tool_points(row.job)
        if points is not None:
            colors = np.tile(np.array(row.color, dtype=float), (len(points), 1))
            self._traces[name] = self._cell.view.draw_trace(f"plans/{row.number}", points, colors)

    def _tool_points(self, job: Mapping[str, Any]) -> Array | None:
        """Return the tool's way, p_WT [m], shape (n, 3); None of a group without a tool."""
        cell, name = self._cell, job["request"]["group"]
        group = next((group for group in cell.scene.groups if group.name == name), None)
        if group is None or not group.tool_frames:
            return None
        positions = np.array(job["result"]["trajectory"]["positions"])
        rows = np.unique(np.linspace(0, len(positions) - 1, _NUM_POINTS).astype(int))
        tool = group.tool_frames[0]
        return cell.api.poses(cell.scene.id, name, positions[rows], [tool])[tool][:, :3]

    def _show_choice(self) -> None:
        plan = self._plan
        self._chosen.value = (
            self.name_of(plan) if plan is not None and plan in self._shown else _NONE
        )

    def _show_paths(self) -> None:
        for trace in self._traces.values():
            trace.visible = bool(self._paths.value)

    def _show_beside(self) -> None:
        rows = [self._rows[plan] for plan in self._ticks.ticked]
        self._beside.choose([Companion(row.job, row.color) for row in rows])

    def _choose(self) -> None:
        chosen = self._chosen.value
        for row in self._rows.values():
            if chosen == f"plan {row.number}":
                self._on_choose(row.job)


def table_of(rows: list[PlanRow], newest: int) -> str:
    """Return plans as an HTML table, newest first.

    Args:
        rows: The plans.
        newest: Revision that the scene has now.
    """
    names = ("", "time", "clear", "tool path", "revision")
    head = "".join(f"<th>{name}</th>" for name in names)
    body = "".join(
        f"<tr><td>{texts.spot(row.color)}{row.number}</td>"
        + "".join(f'<td style="text-align:right">{cell}</td>' for cell in row.cells)
        + f'<td style="text-align:right">{row.proof(newest)}</td></tr>'
        for row in rows
    )
    told = f"The scene is at revision {newest}. Plans that are ticked below move side by side."
    table = f'<table style="width:100%"><tr>{head}</tr>{body}</table>'
    return texts.boxed(f'{table}<span style="color:{texts.COLORS["plain"]}">{told}</span>')
