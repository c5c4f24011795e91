"""Roadmap: free configurations and free ways between them, for many queries."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float64, Int32, Int64

from planning.domain.value import Value, digest


@dataclass(frozen=True)
class Spokes:
    """Every edge twice, once from each of its ends, by the row that it leaves.

    Attributes:
        first: Where those of each row begin; one more at the end, for all.
        there: The row that each leads to.
        ends: The rows that it leaves and leads to, shape (2m, 2).
        edge: Which edge it is, shape (2m,).
    """

    first: list[int]
    there: list[int]
    ends: Int32[np.ndarray, "k 2"]
    edge: Int64[np.ndarray, " k"]

    def of(self, row: int) -> slice:
        """Return which of them leave a row."""
        return slice(self.first[row], self.first[row + 1])


@dataclass(frozen=True, eq=False)
class Roadmap(Value):
    """A probabilistic roadmap (PRM). No query changes it.

    Attributes:
        key: Names all that decided it: the world as the group sees it, margins, metric, bounds,
            options. Equal keys, equal roadmaps.
        states: Free configurations, the group's q, shape (n, nq).
        edges: Pairs of rows that a free geodesic joins, each pair once, the smaller row first,
            sorted, shape (m, 2).
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
        """What its arrays take."""
        return self.states.nbytes + self.edges.nbytes

    @cached_property
    def spokes(self) -> Spokes:
        """The edges as seen from their ends."""
        ends = np.concatenate([self.edges, self.edges[:, ::-1]])
        order = np.lexsort((ends[:, 1], ends[:, 0]))
        first = np.searchsorted(ends[order, 0], np.arange(len(self.states) + 1))
        return Spokes(
            first.tolist(), ends[order, 1].tolist(), ends[order], order % max(1, len(self.edges))
        )
