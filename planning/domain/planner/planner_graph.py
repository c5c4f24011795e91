"""PlannerGraph: tree or roadmap that a sampling-based planner has built."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class PlannerGraph(Value):
    """Graph of a sampling-based planner: configurations as vertices, motions as edges.

    Not promised: that every edge was checked; lazy planners keep edges that they never checked.

    Attributes:
        planner: OMPL's name.
        vertices: The group's q, shape (n, nq).
        edges: Pairs of rows, each pair once, the smaller row first.
        starts: Rows of starts.
        goals: Rows of goals.
        path: Rows of the planner's solution, in order; empty if there is none.
        num_vertices: Number of vertices of the planner; more than n where some were left out.
        num_edges: Number of edges of the planner.
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
    def as_json(self) -> dict[str, Any]:
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
