"""NativeTrees: RRTConnect by an oracle that has it natively, in place of OMPL's.

OMPL asks Python about every edge. An oracle that grows the trees itself takes the same steps, with
the random numbers that OMPL's sampler would have, so the path is the same, bit by bit; a test
compares them. OMPL keeps whatever the oracle does not have: other spaces, parameters and planners,
graphs and approximate solutions on request.
"""

import math
from collections.abc import Callable
from typing import Any, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float64
from ompl import util as ou

from planning.domain.arrays import Array
from planning.search.edges import EdgeChecker
from planning.search.ompl.planner_list import RRT_CONNECT_RANGE
from planning.search.ompl.spaces import SearchSpace
from planning.search.query import Query

# Random generators that OMPL makes between its seed and the planner's sampler; with those that
# project a space of more than two dimensions to the plane.
_GENERATORS_BEFORE_SAMPLER, _GENERATORS_OF_PROJECTION, _PLANE = 3, 2, 2
# OMPL's own choice of the range, as a share of the space's diagonal.
_RANGE_PER_EXTENT = 0.2
# Samples allowed per allowed state, as of `TerminationCondition`.
_SAMPLES_PER_STATE = 10


class Trees(Protocol):
    """Two trees that grow toward each other from the start and the goals."""

    @property
    def num_edges_checked(self) -> int:
        """Edges checked so far."""
        ...

    @property
    def num_states_checked(self) -> int:
        """Samples of these edges, both ends of each included."""
        ...

    @property
    def num_vertices(self) -> int:
        """Vertices of both trees."""
        ...

    @property
    def num_edges(self) -> int:
        """Edges of both trees."""
        ...

    @property
    def goal_distance(self) -> float:
        """Least distance to a goal that the start's tree reached; infinite if it reached none."""
        ...

    def solve(
        self, report: Callable[[], None], max_states: float, max_samples: float
    ) -> Float64[np.ndarray, "m nq"] | None:
        """Return the path between the ends of the trees, or None if a budget is used up.

        Args:
            report: Called at intervals; ends the search by an exception.
            max_states: States after whose check there are no more samples.
            max_samples: Number of samples that is not reached.
        """
        ...


@runtime_checkable
class TreeOracle(Protocol):
    """Oracle that grows trees itself."""

    def connect_trees(
        self,
        start: Float64[np.ndarray, " nq"],
        goals: Float64[np.ndarray, "n nq"],
        bounds: tuple[Float64[np.ndarray, " nq"], Float64[np.ndarray, " nq"]],
        max_step: float,
        resolution: float,
        seed: int,
    ) -> Trees | None:
        """Return the trees before their first step; None for joints that float."""
        ...


def native_trees(query: Query, edges: EdgeChecker, seed: int) -> Trees | None:
    """Return the trees for a run of the planner, or None if OMPL has to do it.

    Args:
        query: Search problem.
        edges: Checker of the planner's motions.
        seed: Seed of OMPL's random numbers, 1 to 2^32 - 1.
    """
    oracle, space, options = query.oracle.inner, query.space, query.options
    if (
        query.planner != "RRTConnect"
        or not query.parameters.keys() <= {"range"}
        or not isinstance(oracle, TreeOracle)
        or type(space) is not SearchSpace
        or not space.is_box
        or options.keep_graph
        or options.approximate
        or options.setup_time is not None
    ):
        return None
    ou.RNG.setSeed(seed)
    is_projected = len(query.start) > _PLANE
    generators = [
        ou.RNG()
        for _ in range(_GENERATORS_BEFORE_SAMPLER + is_projected * _GENERATORS_OF_PROJECTION + 1)
    ]
    extent = math.sqrt(sum(width * width for width in (space.upper - space.lower).tolist()))
    max_step = float(query.parameters.get("range", 0))
    return oracle.connect_trees(
        space.bounded(query.start),
        space.bounded(query.goals),
        (space.lower, space.upper),
        max_step or min(RRT_CONNECT_RANGE, _RANGE_PER_EXTENT * extent),
        edges.resolution,
        generators[-1].getLocalSeed(),
    )


def grow(trees: Trees, query: Query, edges: EdgeChecker) -> Array | None:
    """Grow the trees until they meet; return the path, or None if a budget of states is used up.

    The counters of the oracle and of the edge checker go on.

    Raises:
        Canceled: The request was canceled.
        DeadlineExceeded: The time has run out.
    """
    oracle = query.oracle
    states_before, motions_before = oracle.num_states, edges.num_motions

    oracle.check_deadline()
    try:
        most = query.max_checked_states
        return trees.solve(oracle.check_deadline, most, _SAMPLES_PER_STATE * most)
    finally:
        oracle.num_states = states_before + trees.num_states_checked
        edges.num_motions = motions_before + trees.num_edges_checked


def failure_evidence(trees: Trees) -> dict[str, Any]:
    """Return the evidence of a failure, with OMPL's names."""
    has_approximation = math.isfinite(trees.goal_distance)
    return {
        "num_vertices": trees.num_vertices,
        "num_edges": trees.num_edges,
        "goal_distance": trees.goal_distance if has_approximation else None,
    }
