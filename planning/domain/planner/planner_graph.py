"""PlannerGraph: what a sampling-based planner has explored."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class PlannerGraph(Value):
    """Trees or a roadmap: configurations, and which of them motions join.

    Not promised: that every edge was checked; planners that check late keep edges that they never
    looked at.

    Attributes:
        planner: OMPL's name.
        vertices: The group's q, shape (n, nq).
        edges: Pairs of rows, each pair once, the smaller row first.
        starts: Rows of starts.
        goals: Rows of goals.
        path: Rows of the solution as the planner found it, in order; empty if it found none.
        num_vertices: How many there were; more than n where some were left out.
        num_edges: How many pairs there were.
    """

    planner: str
    vertices: Float64[np.ndarray, "n nq"]
    edges: tuple[tuple[int, int], ...]
    starts: tuple[int, ...]
    goals: tuple[int, ...]
    path: tuple[int, ...]
    num_vertices: int
    num_edges: int

    @property
    def plain(self) -> dict[str, Any]:
        """The same as lists and numbers, for JSON."""
        return {
            "planner": self.planner,
            "vertices": self.vertices.tolist(),
            "edges": [list(edge) for edge in self.edges],
            "starts": list(self.starts),
            "goals": list(self.goals),
            "path": list(self.path),
            "num_vertices": self.num_vertices,
            "num_edges": self.num_edges,
        }
