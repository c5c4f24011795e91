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
from planning.search.projection import projected
from planning.search.roadmap.local_planner import LocalPlanner
from planning.search.roadmap.uniform_samples import uniform_samples
from planning.search.space_options import bounded_limits, held_rotations, metric_weights
from planning.search.verified_path import FINER

# Most samples per requested state: where next to nothing is free, there are fewer states.
_MOST_TRIES = 100
# For a car, candidates per requested neighbour, of which the nearest by steering path are kept.
_CANDIDATES = 5
# Number of distances in one batch.
_AT_ONCE = 50_000


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
        """Return the build request for a search's options; of the start held rotations count."""
        held = held_rotations(group, options.spaces)
        rest = np.zeros(group.num_positions)
        rest[held] = start[held]
        return cls(
            group=group,
            limits=bounded_limits(group, limits, options.bounds),
            weights=metric_weights(group, options.weights),
            held=tuple(held),
            rest=rest,
            resolution=options.resolution / FINER,
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
    recipe: RoadmapBuildRequest,
    oracle: CollisionOracle,
    key: str,
    deadline: Deadline,
    residual: Residual | None = None,
) -> Roadmap:
    """Return the roadmap of a build request in a world.

    Not promised: that all states are connected, or freedom between the checked samples of an edge.

    Args:
        recipe: Build request.
        oracle: Collision oracle.
        key: Key of the roadmap; equal keys, equal roadmaps.
        deadline: End of the construction.
        residual: Constraint residual of a set that is too thin to be sampled; states are projected
            onto it, and edges along it bend: where they do there are more states.

    Raises:
        Canceled: The request was canceled.
        DeadlineExceeded: The time has run out.
    """
    watched = WatchedOracle(oracle, recipe.group, recipe.limits, deadline)
    space = recipe.space
    states = _free_states(recipe, space, watched, residual, deadline)
    edges = space.checker(watched, recipe.resolution, recipe.metric.norm)
    pairs = _nearest_pairs(recipe, edges, states, deadline)
    between = LocalPlanner(edges, residual).between(states[pairs[:, 0]], states[pairs[:, 1]])
    return _roadmap(key, states, pairs, between, watched.num_states)


def _roadmap(
    key: str,
    states: Array,
    pairs: Int32[np.ndarray, "m 2"],
    between: list[Array | None],
    num_states_checked: int,
) -> Roadmap:
    """Return the roadmap of states and edges; waypoints of bent edges become states as well."""
    rows, joined, count = [states], list[list[int]](), len(states)
    for (i, j), way in zip(pairs.tolist(), between, strict=True):
        if way is None:
            continue
        chain = [i, *range(count, count + len(way)), j]
        joined += [sorted(pair) for pair in pairwise(chain)]
        rows.append(way)
        count += len(way)
    edges = np.array(sorted(joined), dtype=np.int32).reshape(-1, 2)
    return Roadmap(key, np.concatenate(rows), edges, num_states_checked)


def _free_states(
    recipe: RoadmapBuildRequest,
    space: SearchSpace,
    oracle: WatchedOracle,
    residual: Residual | None,
    deadline: Deadline,
) -> Array:
    count = recipe.options.states
    rng = np.random.default_rng(recipe.options.seed)
    kept = np.empty((0, recipe.group.num_positions))
    for _ in range(_MOST_TRIES):
        samples = uniform_samples(recipe.group, space, count, rng)
        if residual is not None:
            samples = _on_set(samples, space, residual, deadline)
        kept = np.concatenate([kept, samples[oracle.are_free(samples)]])
        if len(kept) >= count:
            break
    return kept[:count]


def _on_set(samples: Array, space: SearchSpace, residual: Residual, deadline: Deadline) -> Array:
    """Return the projections of samples onto the set, without failures and those off the box."""
    found: list[Array] = []
    for sample in samples:
        deadline.check("search")
        q = projected(residual, sample)
        if q is not None and space.contains(q):
            found.append(np.clip(q, space.lower, space.upper))
    return np.array(found).reshape(-1, samples.shape[1])


def _nearest_pairs(
    recipe: RoadmapBuildRequest, edges: EdgeChecker, states: Array, deadline: Deadline
) -> Int32[np.ndarray, "m 2"]:
    """Return pairs of each state and its nearest neighbours, every pair once, sorted."""
    count, manifold = len(states), edges.manifold
    is_driven = isinstance(edges, SteeringEdgeChecker)
    if is_driven:
        # Lengths of steering paths are computed only for states that are near in the joint-space
        # metric.
        manifold = Manifold(recipe.group.joints)
    neighbours = recipe.options.neighbours
    wanted = min(_CANDIDATES * neighbours if is_driven else neighbours, count - 1)
    if wanted < 1:
        return np.empty((0, 2), dtype=np.int32)
    metric = recipe.metric
    found: list[Indices] = []
    for rows in np.array_split(np.arange(count), max(1, count * count // _AT_ONCE)):
        deadline.check("search")
        distances = metric.norm(manifold.minus(states[None], states[rows, None]))
        distances[np.arange(len(rows)), rows] = np.inf
        nearest = np.argpartition(distances, wanted - 1, axis=1)[:, :wanted]
        if is_driven:
            nearest = _nearest_driven(edges, states, rows, nearest, neighbours)
        ends = np.stack([np.repeat(rows, nearest.shape[1]), nearest.ravel()], axis=1)
        found.append(np.sort(ends, axis=1))
    return np.unique(np.concatenate(found), axis=0).astype(np.int32)


def _nearest_driven(
    edges: EdgeChecker, states: Array, rows: Indices, near: Indices, wanted: int
) -> Indices:
    """Return the neighbours of each row by length of steering path, of the near ones, (m, k)."""
    ends = np.repeat(rows, near.shape[1])
    lengths = edges.lengths(states[ends], states[near.ravel()]).reshape(near.shape)
    order = np.argsort(lengths, axis=1, kind="stable")[:, :wanted]
    return np.take_along_axis(near, order, axis=1)
