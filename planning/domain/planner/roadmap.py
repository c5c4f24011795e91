"""Roadmap: free configurations and free edges between them, for many queries (PRM)."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float64, Int32

from planning.domain.value import Value, digest


@dataclass(frozen=True, eq=False)
class Roadmap(Value):
    """Probabilistic roadmap (PRM). No query changes it.

    Attributes:
        key: Digest of all inputs: the world as the group sees it, margins, metric, bounds,
            options, path constraints. Equal keys, equal roadmaps.
        states: Free configurations, the q of the joints that are not locked, shape (n, nq).
        edges: Pairs of rows joined by a free geodesic, or by a car's steering path, each pair once,
            the smaller row first, sorted, shape (m, 2).
        num_states_checked: Configurations that were checked to build it.
    """

    key: str
    states: Float64[np.ndarray, "n nq"]
    edges: Int32[np.ndarray, "m 2"]
    num_states_checked: int

    @cached_property
    def digest(self) -> str:
        """sha256 of the content."""
        return digest(self)

    @property
    def num_bytes(self) -> int:
        """Size of its arrays in bytes."""
        return self.states.nbytes + self.edges.nbytes

    @cached_property
    def neighbours(self) -> tuple[tuple[int, ...], ...]:
        """Rows that each row has an edge with, ascending."""
        found: list[list[int]] = [[] for _ in self.states]
        for i, j in self.edges.tolist():
            found[i].append(j)
            found[j].append(i)
        return tuple(tuple(sorted(rows)) for rows in found)
