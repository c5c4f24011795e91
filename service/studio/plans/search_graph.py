"""SearchGraph: where the tool is at what a planner explored, if the request had that kept."""

import itertools
from collections.abc import Mapping
from typing import Any

import numpy as np

from service.client.errors import ApiError
from service.studio.cell import Cell
from service.studio.numbers import Array

_TREE, _PATH = (148, 163, 184), (122, 92, 199)
_THIN, _THICK = 0.0015, 0.005
# There is none: its planner tells none, or it ended before.
_NO_GRAPH = 409


class SearchGraph:
    """The planner's trees or roadmap, as ways of the tool, and its solution among them."""

    def __init__(self) -> None:
        """Show nothing yet."""
        self._nodes: list[Any] = []

    def show(self, cell: Cell, job: Mapping[str, Any]) -> None:
        """Draw the graph of a plan; nothing if it was not kept, or the group has no tool.

        Args:
            cell: The scene.
            job: The plan, once it has ended.

        Raises:
            ApiError: The server refuses it.
        """
        self.clear()
        tools = cell.group.tool_frames[:1]
        if not job["request"]["search"].get("keep_graph") or not tools:
            return
        try:
            graph = cell.api.graph(job["id"])
        except ApiError as fault:
            if fault.problem.status == _NO_GRAPH:
                return
            raise
        if not graph["edges"]:
            return
        rows = np.array(graph["vertices"])
        points = cell.api.poses(cell.scene.id, cell.group.name, rows, tools)[tools[0]][:, :3]
        self._draw(cell, "edges", ways_of(points, graph["edges"]), _TREE, _THIN)
        path = graph["path"]
        if len(path) > 1:
            steps = list(itertools.pairwise(path))
            self._draw(cell, "path", ways_of(points, steps), _PATH, _THICK)

    def clear(self) -> None:
        """Take it away."""
        for node in self._nodes:
            node.remove()
        self._nodes = []

    def _draw(
        self,
        cell: Cell,
        name: str,
        segments: Array,
        color: tuple[int, int, int],
        thickness: float,
    ) -> None:
        self._nodes.append(
            cell.client.scene.add_line_segments(
                f"/graph/{name}", segments, color, thickness=thickness
            )
        )


def ways_of(points: Array, edges: Any) -> Array:
    """Return the segments that edges are, shape (edges, 2, 3).

    Args:
        points: Of the vertices [m], shape (n, 3).
        edges: Pairs of rows.
    """
    return points[np.array(edges, dtype=int)]
