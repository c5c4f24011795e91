"""PathSoFar: the best path of a search that goes on, drawn until the plan has ended."""

import threading
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from service.studio.cell import Cell
from service.studio.newest import Newest
from service.studio.numbers import Array

_COLOR = np.array([84.0, 36.0, 196.0])
# Points of the tool's way, and ghosts of the robot along it.
_NUM_POINTS, _NUM_GHOSTS = 61, 4
# The first of the four positions of a quaternion ends in this.
_QUATERNION = ".qw"


class PathSoFar:
    """The tool's way along the path, and faint ghosts of the robot on it; the newest path only."""

    def __init__(self, on_fault: Callable[[Exception], None]) -> None:
        """Show nothing yet.

        Args:
            on_fault: Is told what goes wrong.
        """
        self._newest = Newest(on_fault)
        self._lock = threading.Lock()
        self._cell: Cell | None = None
        self._trace: Any = None
        self._num_drawn = 0

    def begin(self, cell: Cell) -> None:
        """Draw from now on what is shown, in a scene."""
        self.end()
        with self._lock:
            self._cell = cell

    def show(self, waypoints: Sequence[Sequence[float]] | None) -> None:
        """Draw a path in place of the one before, soon; of a path that came later, only that.

        Args:
            waypoints: Configurations of the group; None where they are not told.
        """
        cell = self._cell
        if cell is not None and waypoints is not None and len(waypoints) > 1:
            rows = along(np.array(waypoints, dtype=float), cell.group.position_names, _NUM_POINTS)
            self._newest.ask(lambda: self._draw(cell, rows))

    def end(self) -> None:
        """Take it away; what is still asked for is not drawn any more."""
        with self._lock:
            cell, self._cell = self._cell, None
            if self._trace is not None:
                self._trace.remove()
                self._trace = None
            if cell is not None:
                cell.view.show_others([])

    def close(self) -> None:
        """End for good."""
        self.end()
        self._newest.close()

    def _draw(self, cell: Cell, rows: Array) -> None:
        # A body that flies or drives has no tool: its own way is drawn.
        tracked = [*cell.group.tool_frames, *reversed(cell.view.moving)][:1]
        name, scene = cell.group.name, cell.scene.id
        ways = cell.api.poses(scene, name, rows, tracked)
        chosen = rows[np.linspace(0, len(rows) - 1, _NUM_GHOSTS + 2).round().astype(int)[1:-1]]
        placed = cell.api.poses(scene, name, chosen, cell.view.moving)
        ghosts = [{body: poses[i] for body, poses in placed.items()} for i in range(len(chosen))]
        with self._lock:
            if cell is not self._cell:
                return
            before = self._trace
            with cell.client.atomic():
                cell.view.show_others(ghosts)
                if tracked:
                    self._num_drawn += 1
                    points = ways[tracked[0]][:, :3]
                    colors = np.tile(_COLOR, (len(points), 1))
                    self._trace = cell.view.draw_trace(f"best/{self._num_drawn}", points, colors)
                if before is not None:
                    before.remove()


def along(waypoints: Array, names: Sequence[str], num: int) -> Array:
    """Return configurations on the straight lines between waypoints, evenly by length.

    Args:
        waypoints: Shape (n, nq), n >= 2.
        names: Of the positions: those of a quaternion are normalised.
        num: How many, the ends among them.

    Returns:
        Shape (num, nq).
    """
    lengths = np.linalg.norm(np.diff(waypoints, axis=0), axis=1)
    at = np.concatenate([[0.0], np.cumsum(lengths)])
    wanted = np.linspace(0.0, at[-1], num)
    rows = np.stack([np.interp(wanted, at, column) for column in waypoints.T], axis=1)
    for first in (k for k, name in enumerate(names) if name.endswith(_QUATERNION)):
        turned = rows[:, first : first + 4]
        turned /= np.linalg.norm(turned, axis=1, keepdims=True)
    return rows
