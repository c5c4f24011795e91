"""A roadmap, grown: samples, their nearest neighbours, and the ways between them that are free.

Kavraki, Svestka, Latombe, Overmars, "Probabilistic roadmaps for path planning in high-dimensional
configuration spaces" (1996). It is a function of a recipe and of what is free, and of nothing else:
of no query, and of the clock only whether there is time for it. OMPL's spaces lend their bounds and
metrics; none of its planners is asked.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64, Int32

from planning.domain.deadline import Deadline
from planning.domain.joints import JointGroup, JointLimits
from planning.domain.manifold import Manifold
from planning.domain.options import RoadmapOptions, SearchOptions
from planning.domain.roadmap import Roadmap
from planning.domain.value import Value
from planning.search.demands import block_weights, bounded, held_rotations
from planning.search.edges import EdgeChecker
from planning.search.objective import Objective
from planning.search.oracle import CollisionOracle, WatchedOracle
from planning.search.sampling import uniform_samples
from planning.search.sound import FINER
from planning.search.spaces import SearchSpace

type Array = np.ndarray[Any, np.dtype[np.float64]]
type Rows = np.ndarray[Any, np.dtype[np.intp]]

# Samples for each state that is wanted, at most: where next to nothing is free, states are fewer.
_MOST_TRIES = 100
# Distances that are computed at once.
_AT_ONCE = 500_000


@dataclass(frozen=True, eq=False)
class RoadmapRecipe(Value):
    """All that decides a roadmap but for what is free.

    Attributes:
        group: Whose joints move.
        limits: The box to sample, with the bounds of the search.
        weights: Of the group's blocks, for which states are neighbours, shape (num_blocks,).
        held: Coordinates of q that are the same in every state.
        rest: Their values; zeros elsewhere, shape (nq,).
        resolution: Largest distance between two checked states of an edge.
        options: States, neighbours and seed.
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
    ) -> "RoadmapRecipe":
        """Build the recipe that a search asks for; of the start only held rotations count.

        Edges are checked as finely as what is delivered.

        Raises:
            UnknownName: The options name a joint, block or coordinate that does not exist.
            ProblemInvalid: Weights or bounds make no sense.
        """
        held = held_rotations(group, options.spaces)
        rest = np.zeros(group.num_positions)
        rest[held] = start[held]
        return cls(
            group=group,
            limits=bounded(group, limits, options.bounds),
            weights=block_weights(group, options.weights),
            held=tuple(held),
            rest=rest,
            resolution=options.resolution / FINER,
            options=options.roadmap or RoadmapOptions(),
        )

    @property
    def metric(self) -> Objective:
        """How far apart states are."""
        return Objective("weighted_length", self.group, self.limits, self.weights)

    @property
    def space(self) -> SearchSpace:
        """Where states lie; made anew each time."""
        return SearchSpace(self.group, self.limits, self.rest[None], self.weights, self.held)


def grow_roadmap(
    recipe: RoadmapRecipe, oracle: CollisionOracle, key: str, deadline: Deadline
) -> Roadmap:
    """Return the roadmap of a recipe in a world.

    Not promised: that all states are connected, or freedom between the checked samples of an edge.

    Args:
        recipe: What to grow.
        oracle: What is free.
        key: What the roadmap shall be known by.
        deadline: When to give up.

    Raises:
        Canceled: Somebody asked for the end.
        DeadlineExceeded: The time has run out.
    """
    watched = WatchedOracle(oracle, recipe.group, recipe.limits, deadline)
    space = recipe.space
    states = _free_states(recipe, space, watched)
    pairs = _nearest_pairs(recipe, space.manifold, states, deadline)
    checker = EdgeChecker(space.manifold, watched, recipe.resolution)
    free = checker.are_free(states[pairs[:, 0]], states[pairs[:, 1]])
    return Roadmap(key, states, pairs[free], watched.num_states)


def _free_states(recipe: RoadmapRecipe, space: SearchSpace, oracle: WatchedOracle) -> Array:
    count = recipe.options.states
    rng = np.random.default_rng(recipe.options.seed)
    kept = np.empty((0, recipe.group.num_positions))
    for _ in range(_MOST_TRIES):
        samples = uniform_samples(recipe.group, space, count, rng)
        kept = np.concatenate([kept, samples[oracle.are_free(samples)]])
        if len(kept) >= count:
            break
    return kept[:count]


def _nearest_pairs(
    recipe: RoadmapRecipe, manifold: Manifold, states: Array, deadline: Deadline
) -> Int32[np.ndarray, "m 2"]:
    """Return each state with each of its nearest neighbours, every pair once, sorted."""
    count = len(states)
    wanted = min(recipe.options.neighbours, count - 1)
    if wanted < 1:
        return np.empty((0, 2), dtype=np.int32)
    metric = recipe.metric
    found: list[Rows] = []
    for rows in np.array_split(np.arange(count), max(1, count * count // _AT_ONCE)):
        deadline.check("search")
        distances = metric.norm(manifold.minus(states[None], states[rows, None]))
        distances[np.arange(len(rows)), rows] = np.inf
        nearest = np.argpartition(distances, wanted - 1, axis=1)[:, :wanted]
        ends = np.stack([np.repeat(rows, wanted), nearest.ravel()], axis=1)
        found.append(np.sort(ends, axis=1))
    return np.unique(np.concatenate(found), axis=0).astype(np.int32)
