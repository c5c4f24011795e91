"""Roadmap construction (PRM): free samples, their nearest neighbours, and the free edges between.

Kavraki, Svestka, Latombe, Overmars, "Probabilistic roadmaps for path planning in high-dimensional
configuration spaces" (1996). The result is a function of the build request and of the world alone:
not of a query, and not of the clock, which can only end the construction. OMPL's spaces provide
bounds and metrics; none of its planners is used.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from jaxtyping import Float64, Int32

from planning.domain.arrays import Array, Indices
from planning.domain.planner.roadmap import Roadmap
from planning.domain.request.deadline import Deadline
from planning.domain.request.options import RoadmapOptions, SearchOptions
from planning.domain.robot.joints import JointGroup, JointLimits
from planning.domain.robot.manifold import Manifold
from planning.domain.robot.steering import steering_of
from planning.domain.value import Value
from planning.search.cars.steering_edges import SteeringEdgeChecker
from planning.search.collision_oracle import CollisionOracle, WatchedOracle
from planning.search.edges import EdgeChecker
from planning.search.ompl.car_space import CarSpace
from planning.search.ompl.objective import Objective
from planning.search.ompl.projected_space import Residual
from planning.search.ompl.spaces import SearchSpace
from planning.search.projection import project
from planning.search.roadmap.local_planner import LocalPlanner
from planning.search.roadmap.uniform_samples import uniform_samples
from planning.search.space_options import bounded_limits, held_rotations, metric_weights
from planning.search.verified_path import FINE_FACTOR

# Most samples per requested state: where next to nothing is free, there are fewer states.
_MAX_ROUNDS = 100
# For a car, candidates per requested neighbour, of which the nearest by steering path are kept.
_CANDIDATES_PER_NEIGHBOUR = 5
# Number of distances in one batch.
_BATCH_DISTANCES = 50_000


@dataclass(frozen=True, eq=False)
class RoadmapBuildRequest(Value):
    """Inputs of a roadmap's construction besides the world.

    Attributes:
        group: The joints that move.
        limits: The box to sample, with the bounds of the search.
        weights: Metric weights of the group's blocks, for neighbours, shape (num_blocks,).
        held: Coordinates of q that are the same in every state.
        rest: Their values; zeros elsewhere, shape (nq,).
        resolution: Largest distance between two checked states of an edge.
        options: Number of states and neighbours, and seed.
    """

    group: JointGroup
    limits: JointLimits
    weights: Float64[np.ndarray, " num_blocks"]
    held: tuple[int, ...]
    rest: Float64[np.ndarray, " nq"]
    resolution: float
    options: RoadmapOptions

    @classmethod
    def from_search(
        cls,
        group: JointGroup,
        limits: JointLimits,
        start: Float64[np.ndarray, " nq"],
        options: SearchOptions,
    ) -> "RoadmapBuildRequest":
        """Return the build request of a search; of its start, only held rotations count."""
        held_indices = held_rotations(group, options.spaces)
        held_values = np.zeros(group.num_positions)
        held_values[held_indices] = start[held_indices]
        return cls(
            group=group,
            limits=bounded_limits(group, limits, options.bounds),
            weights=metric_weights(group, options.weights),
            held=tuple(held_indices),
            rest=held_values,
            resolution=options.resolution / FINE_FACTOR,
            options=options.roadmap or RoadmapOptions(),
        )

    @property
    def metric(self) -> Objective:
        """Metric of the distance between states."""
        return Objective("weighted_length", self.group, self.limits, self.weights)

    @property
    def space(self) -> SearchSpace:
        """Search space of the states, made anew at each access."""
        if steering_of(self.group):
            return CarSpace(self.group, self.limits, self.rest[None], self.weights)
        return SearchSpace(self.group, self.limits, self.rest[None], self.weights, self.held)


def grow_roadmap(
    request: RoadmapBuildRequest,
    oracle: CollisionOracle,
    key: str,
    deadline: Deadline,
    residual: Residual | None = None,
) -> Roadmap:
    """Return the roadmap of a build request in a world.

    Not promised: that all states are connected, or freedom between the checked samples of an edge.

    Args:
        request: Build request.
        oracle: Collision oracle.
        key: Key of the roadmap; equal keys, equal roadmaps.
        deadline: End of the construction.
        residual: Constraint residual of a set that is too thin to be sampled; states are projected
            onto it, and edges follow it: the waypoints of bent edges are additional states.

    Raises:
        Canceled: The request was canceled.
        DeadlineExceeded: The time has run out.
    """
    watched = WatchedOracle(oracle, request.group, request.limits, deadline)
    space = request.space
    states = _free_states(request, space, watched, residual, deadline)
    edges = space.checker(watched, request.resolution, request.metric.norm)
    pairs = _nearest_pairs(request, edges, states, deadline)
    connections = LocalPlanner(edges, residual).connections(
        states[pairs[:, 0]], states[pairs[:, 1]]
    )
    return _assemble_roadmap(key, states, pairs, connections, watched.num_states)


def _assemble_roadmap(
    key: str,
    states: Array,
    pairs: Int32[np.ndarray, "m 2"],
    connections: list[Array | None],
    num_states_checked: int,
) -> Roadmap:
    """Return the roadmap of states and edges; waypoints of bent edges become states as well."""
    rows, edge_rows, count = [states], list[list[int]](), len(states)
    for (i, j), waypoints in zip(pairs.tolist(), connections, strict=True):
        if waypoints is None:
            continue
        chain = [i, *range(count, count + len(waypoints)), j]
        edge_rows += [sorted(pair) for pair in pairwise(chain)]
        rows.append(waypoints)
        count += len(waypoints)
    edges = np.array(sorted(edge_rows), dtype=np.int32).reshape(-1, 2)
    return Roadmap(key, np.concatenate(rows), edges, num_states_checked)


def _free_states(
    request: RoadmapBuildRequest,
    space: SearchSpace,
    oracle: WatchedOracle,
    residual: Residual | None,
    deadline: Deadline,
) -> Array:
    count = request.options.states
    rng = np.random.default_rng(request.options.seed)
    states = np.empty((0, request.group.num_positions))
    for _ in range(_MAX_ROUNDS):
        samples = uniform_samples(request.group, space, count, rng)
        if residual is not None:
            samples = _project_samples(samples, space, residual, deadline)
        states = np.concatenate([states, samples[oracle.are_free(samples)]])
        if len(states) >= count:
            break
    return states[:count]


def _project_samples(
    samples: Array, space: SearchSpace, residual: Residual, deadline: Deadline
) -> Array:
    """Return the projections of samples onto the set, without failures and those off the box."""
    states: list[Array] = []
    for sample in samples:
        deadline.check("search")
        q = project(residual, sample)
        if q is not None and space.contains(q[None])[0]:
            states.append(np.clip(q, space.lower, space.upper))
    return np.array(states).reshape(-1, samples.shape[1])


def _nearest_pairs(
    request: RoadmapBuildRequest, edges: EdgeChecker, states: Array, deadline: Deadline
) -> Int32[np.ndarray, "m 2"]:
    """Return pairs of each state and its nearest neighbours, every pair once, sorted."""
    count, manifold = len(states), edges.manifold
    is_steered = isinstance(edges, SteeringEdgeChecker)
    if is_steered:
        # Lengths of steering paths are computed only for states that are near in the joint-space
        # metric.
        manifold = Manifold(request.group.joints)
    neighbours = request.options.neighbours
    num_candidates = min(
        _CANDIDATES_PER_NEIGHBOUR * neighbours if is_steered else neighbours, count - 1
    )
    if num_candidates < 1:
        return np.empty((0, 2), dtype=np.int32)
    metric = request.metric
    pairs: list[Indices] = []
    for rows in np.array_split(np.arange(count), max(1, count * count // _BATCH_DISTANCES)):
        deadline.check("search")
        distances = metric.norm(manifold.minus(states[None], states[rows, None]))
        distances[np.arange(len(rows)), rows] = np.inf
        nearest = np.argpartition(distances, num_candidates - 1, axis=1)[:, :num_candidates]
        if is_steered:
            nearest = _nearest_by_steering(edges, states, rows, nearest, neighbours)
        ends = np.stack([np.repeat(rows, nearest.shape[1]), nearest.ravel()], axis=1)
        pairs.append(np.sort(ends, axis=1))
    return np.unique(np.concatenate(pairs), axis=0).astype(np.int32)


def _nearest_by_steering(
    edges: EdgeChecker, states: Array, rows: Indices, candidates: Indices, num_neighbours: int
) -> Indices:
    """Return the neighbours of each row by length of steering path, of the near ones, (m, k)."""
    ends = np.repeat(rows, candidates.shape[1])
    lengths = edges.lengths(states[ends], states[candidates.ravel()]).reshape(candidates.shape)
    order = np.argsort(lengths, axis=1, kind="stable")[:, :num_neighbours]
    return np.take_along_axis(candidates, order, axis=1)
