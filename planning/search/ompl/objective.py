"""Objective: the cost by which paths are compared, and minimized by optimizing planners.

    length           sum of |delta|, radians and metres weighing the same
    weighted_length  sum of |W delta|, W the request's weights
    duration         sum of max_b |delta_b| / v_b over the blocks b of joints: the least time that
                     the velocity limits v allow [s]; acceleration is left out
    clearance        sum of |delta| / (d + 0.01 m), d the mean of the distances of both ends to
                     obstacles: a path near them costs up to 100 times its length

The first three are norms of tangents, so a geodesic never costs more than a detour, and shortcuts
are measured by them too.
"""

import math
import operator
from collections.abc import Callable
from functools import cached_property
from itertools import pairwise
from typing import Any, Literal, override

import numpy as np
from jaxtyping import Float64
from ompl import base as ob

from planning.domain.arrays import Array
from planning.domain.robot.joints import JointGroup, JointLimits
from planning.domain.robot.steering import manifold_of
from planning.search.ompl.spaces import SearchSpace

type Name = Literal["length", "weighted_length", "clearance", "duration"]
type Clearances = Callable[[Array], Array]

# Distance added before the division, so that costs are finite in contact [m].
_DISTANCE_OFFSET = 0.01
# Spacing of distance evaluations along an edge (joint-space length).
_EVALUATION_SPACING = 0.1
_MAX_CACHED_DISTANCES = 50_000
_METRIC_PLANNERS = ("FMT", "BFMT")


class Objective:
    """Cost of tangents, edges and paths.

    Attributes:
        name: As in the search options.
        is_length: Whether costs are plain lengths.
        is_euclidean: Whether `norm` is the Euclidean length.
    """

    def __init__(
        self,
        name: Name,
        group: JointGroup,
        limits: JointLimits,
        weights: Float64[np.ndarray, " num_blocks"],
        clearances: Clearances | None = None,
    ) -> None:
        """Prepare for the motions of a group.

        Args:
            name: As in the search options.
            group: The joints.
            limits: Their velocity limits count for "duration".
            weights: Weights of the group's blocks, for "weighted_length".
            clearances: Returns distances [m] of configurations to obstacles, for "clearance".
        """
        self.name = name
        self.is_length = name == "length"
        self.is_euclidean = name not in {"weighted_length", "duration"}
        self._manifold = manifold_of(group)
        self._velocity, self._block_weights = limits.velocity, weights
        self._limited_blocks = limits.blocks
        self._clearances = clearances or _unit_distances
        self._distance_cache: dict[bytes, float] = {}
        # With weights OMPL's own length is the weighted one, not the plain one.
        self._is_ompl_length = name == "weighted_length" or (
            self.is_length and (weights == 1).all()
        )

    @cached_property
    def _blocks(self) -> list[list[int]]:
        return [list(block) for block in self._limited_blocks]

    @cached_property
    def _inverse_velocity(self) -> list[float]:
        """For a vector space, where every block is one coordinate."""
        return (1 / self._velocity).tolist()

    @cached_property
    def _weights(self) -> Array:
        """Of coordinates, shape (nv,)."""
        weights = np.empty(self._manifold.num_velocities)
        for block, weight in zip(self._blocks, self._block_weights, strict=True):
            weights[block] = weight
        return weights

    @cached_property
    def _weight_list(self) -> list[float]:
        return self._weights.tolist()

    def norm(self, delta: Float64[np.ndarray, "*n nv"]) -> Array:
        """Return the norm of tangents, shape (...); for "clearance" it is the length."""
        match self.name:
            case "weighted_length":
                return np.asarray(np.linalg.norm(delta * self._weights, axis=-1))
            case "duration":
                block_durations = [
                    np.linalg.norm(delta[..., block], axis=-1) / rate
                    for block, rate in zip(self._blocks, self._velocity, strict=True)
                ]
                return np.asarray(np.max(np.array(block_durations), axis=0), dtype=np.float64)
            case _:
                return np.asarray(np.sqrt(np.einsum("...v,...v->...", delta, delta)))

    def edge_costs(
        self, q0s: Float64[np.ndarray, "*#m nq"], q1s: Float64[np.ndarray, "*#m nq"]
    ) -> Array:
        """Return the costs of geodesics by their ends alone, as planners use them, shape (m,)."""
        if self.is_length:
            return self._manifold.distance(q1s, q0s)
        norms = self.norm(self._manifold.minus(q1s, q0s))
        if self.name != "clearance":
            return norms
        q0s, q1s = np.broadcast_arrays(q0s, q1s)
        distance_sums = [
            self._obstacle_distance(q0) + self._obstacle_distance(q1)
            for q0, q1 in zip(q0s, q1s, strict=True)
        ]
        return norms / (np.array(distance_sums) / 2 + _DISTANCE_OFFSET)

    def edge_cost(self, q0: list[float], q1: list[float]) -> float:
        """Return the cost of one edge as `edge_costs` does, faster: planners call it very often."""
        if not self._manifold.is_vector_space:
            return float(self.edge_costs(np.array(q0)[None], np.array(q1)[None])[0])
        match self.name:
            case "duration":
                return max(
                    map(operator.mul, map(abs, map(operator.sub, q1, q0)), self._inverse_velocity)
                )
            case "clearance":
                distances = [self._obstacle_distance(np.array(q)) for q in (q0, q1)]
                return math.dist(q0, q1) / (sum(distances) / 2 + _DISTANCE_OFFSET)
            case "weighted_length":
                return math.dist(
                    list(map(operator.mul, q0, self._weight_list)),
                    list(map(operator.mul, q1, self._weight_list)),
                )
            case _:
                return math.dist(q0, q1)

    def cost(self, waypoints: Float64[np.ndarray, "n nq"]) -> float:
        """Return the cost of a path of geodesics."""
        norms = self.norm(self._manifold.minus(waypoints[1:], waypoints[:-1]))
        if self.name != "clearance":
            return float(norms.sum())
        return sum(self._sampled_edge_cost(q0, q1) for q0, q1 in pairwise(waypoints))

    def make_ompl_objective(self, information: Any, space: SearchSpace, planner: str) -> Any | None:
        """Return the objective for OMPL, or None for OMPL's own, which is length in its space.

        FMT and BFMT select neighbours by cost, which must be a metric: in place of clearance, which
        is no metric, they get the length.
        """
        is_metric_required = planner in _METRIC_PLANNERS and self.name == "clearance"
        if not (self._is_ompl_length or is_metric_required):
            return _MotionCost(information, space, self)
        return _length_objective(information) if space.is_mixed else None

    def _sampled_edge_cost(self, q0: Array, q1: Array) -> float:
        delta = self._manifold.minus(q1, q0)
        count = max(1, int(np.ceil(float(self.norm(delta)) / _EVALUATION_SPACING)))
        qs = self._manifold.interpolate(q0, q1, np.arange(count + 1) / count)
        return float(self.edge_costs(qs[:-1], qs[1:]).sum())

    def _obstacle_distance(self, q: Array) -> float:
        key = q.tobytes()
        if key not in self._distance_cache:
            if len(self._distance_cache) >= _MAX_CACHED_DISTANCES:
                self._distance_cache.clear()
            self._distance_cache[key] = max(0.0, float(self._clearances(q[None])[0]))
        return self._distance_cache[key]


class _MotionCost(ob.OptimizationObjective):
    """OMPL objective by the cost of motions."""

    def __init__(self, information: Any, space: SearchSpace, objective: Objective) -> None:
        """Prepare for an OMPL space information."""
        super().__init__(information)
        self._read_list = space.read_list
        self._edge_cost = objective.edge_cost

    @override
    def stateCost(self, state: Any) -> Any:
        """Return zero: only motions have a cost."""
        return ob.Cost(0.0)

    @override
    def motionCost(self, s1: Any, s2: Any) -> Any:
        """Return the cost of the geodesic."""
        return ob.Cost(self._edge_cost(self._read_list(s1), self._read_list(s2)))


def _length_objective(information: Any) -> Any:
    """Return the path length as an objective that planners can use in a compound space.

    For OMPL's own length objective planners use an informed sampler, which does not support
    compound spaces; wrapped, the objective makes them sample uniformly and reject.
    """
    length = ob.MultiOptimizationObjective(information)
    length.addObjective(ob.PathLengthOptimizationObjective(information), 1.0)
    length.lock()
    return length


def _unit_distances(qs: Array) -> Array:
    return np.ones(len(qs))
