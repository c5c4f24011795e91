"""Distances of all pairs of shapes that may collide, and bounds on how they change.

Drake measures; it does not prove. Its distances of separate shapes are never too small, but they
can be too large: its documentation observes 0.05 mm, and of two boxes with parallel edges Drake
1.58 was seen to say 60 mm where 25 mm are true. So Drake's distances are what is reported and what
refuses a motion, and its directions are used, but that a pair is far enough is shown by a slab that
contains neither shape (see `collision_shapes`): first of the bounding spheres, then along the
direction that did last time, then along Drake's, along the axes of both shapes, and at last along
the one that `separation` finds. Half spaces, which Drake does not measure, are slabs already.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64, Int

from planning.certify.clearance.candidate_pairs import candidate_pairs, geometry_of
from planning.certify.clearance.motion_bounds import MotionBounds
from planning.certify.clearance.placed_shapes import PlacedShapes
from planning.certify.intervals.joint_deviation import Segment
from planning.certify.request import CertifyRequest
from planning.world.collision.drake_distance import distance_of, distances_within
from planning.world.collision.near_static import NearStatic
from planning.world.drake_model import DrakeModel

type Array = np.ndarray[Any, np.dtype[np.float64]]
type Indices = np.ndarray[Any, np.dtype[np.intp]]

# Up to so many pairs Drake is asked for one by one.
_FEW = 24
# A bound that is this far below a distance is worth another direction [m].
_MUCH = 5e-4
# Shapes that overlap by more have no slab to be looked for [m].
_TOUCHING = -1e-6


@dataclass(frozen=True)
class Measured:
    """Distances of some pairs at one configuration.

    Attributes:
        pairs: Which ones, shape (n,).
        distances: Signed distances as measured; infinite where bounds were enough [m].
        lower: Proven lower bounds on the true ones [m].
    """

    pairs: Int[np.ndarray, " n"]
    distances: Float64[np.ndarray, " n"]
    lower: Float64[np.ndarray, " n"]


class PairDistances:
    """Measures distances in a context of its own.

    Attributes:
        pairs: All pairs that may collide.
    """

    def __init__(self, model: DrakeModel, request: CertifyRequest) -> None:
        """Make a context, and put the group at the trajectory's start.

        Raises:
            ModelInvalid: A shape or a joint of a kind that cannot be certified.
        """
        self._model, self._group, self._state = model, request.group, request.state
        geometry = geometry_of(model)
        self._shapes = geometry.shapes
        self._bounds = MotionBounds(model, request.group, geometry.shapes)
        self.pairs = candidate_pairs(geometry, self._bounds, request.margins)
        self._is_flat = self._shapes.is_half_space[self.pairs.rows].any(axis=1)
        self._directions = np.full((len(self.pairs.ids), 3), np.nan)
        self._near = NearStatic(model)
        self._placed = PlacedShapes(model, self._shapes, self._bounds)
        self.go_to(request.trajectory.start)

    @property
    def moved_bodies(self) -> set[str]:
        """Full names of the bodies that the group moves."""
        chains = self._bounds.chains
        return {name for i, name in self._model.body_names.items() if chains.get(int(i))}

    def go_to(self, q: Float64[np.ndarray, " nq"]) -> None:
        """Put the group at q, and all else where it is."""
        full = self._model.embed(self._group, q, self._state)
        self._near.go_to(full)
        self._placed.place(self._near.plant_context)

    def approaches(self, segment: Segment, pairs: Indices) -> Float64[np.ndarray, " n"]:
        """Return how much nearer some pairs can come within a segment from its centre [m].

        The centre is where the group must be.
        """
        placed = self._placed
        return self._between(
            self._bounds.reaches(placed.rotations, placed.positions, segment.turn, segment.shift),
            pairs,
        )

    def sensitivities(self, pairs: Indices) -> Float64[np.ndarray, " n"]:
        """Return how much nearer some pairs come at most per error of every joint.

        That is by how much `approaches` grows if every joint turns and shifts by so much more
        [m per rad or m].
        """
        placed = self._placed
        return self._between(self._bounds.sensitivities(placed.rotations, placed.positions), pairs)

    def _between(self, moved: Array, pairs: Indices) -> Array:
        """Return the sum over the joints that move one shape of a pair relative to the other.

        In the frame of a half space it is the other shape that they move.
        """
        carries, is_flat = self._bounds.carries, self._shapes.is_half_space
        a, b = self.pairs.rows[pairs].T
        by_a = np.where(carries[a] & ~carries[b], moved[np.where(is_flat[a], b, a)], 0.0)
        by_b = np.where(carries[b] & ~carries[a], moved[np.where(is_flat[b], a, b)], 0.0)
        return (by_a + by_b).sum(axis=1)

    def measure(self, pairs: Indices, wanted: Float64[np.ndarray, " n"]) -> Measured:
        """Bound distances here until each bound is as large as wanted, or as good as can be.

        Pairs that are farther apart than wanted may be left unmeasured.
        """
        a, b = self.pairs.rows[pairs].T
        lower, distances = self._placed.sphere_gaps(a, b), np.full(len(pairs), np.inf)
        is_flat = self._is_flat[pairs]
        for i in np.flatnonzero(is_flat):
            distances[i] = lower[i] = self._placed.height(int(a[i]), int(b[i]))
        left = np.flatnonzero((lower < wanted) & ~is_flat)
        self._raise(lower, left, pairs, self._directions[pairs[left]])
        left = left[lower[left] < wanted[left]]
        if len(left):
            distances[left], directions = self._ask(pairs[left], float(wanted[left].max()))
            self._raise(lower, left, pairs, directions)
        left = left[_may_rise(lower, distances, wanted)[left]]
        if len(left):
            self._raise(lower, left, pairs, self._placed.best_axes(a[left], b[left]))
        for i in left[_may_rise(lower, distances, wanted)[left]]:
            found = self._placed.separate(int(a[i]), int(b[i]), float(wanted[i]))
            self._directions[pairs[i]] = found.direction
            lower[i] = max(lower[i], found.lower)
            distances[i] = min(distances[i], found.upper)
        return Measured(pairs, distances, lower)

    def closely(self, pair: int) -> float:
        """Return an upper bound on the distance of a pair that is hardly larger than it [m]."""
        a, b = self.pairs.rows[pair].tolist()
        if self._is_flat[pair]:
            return self._placed.height(a, b)
        return self._placed.separate(a, b, np.inf, close=0.0).upper

    def sample(self, within: float) -> tuple[Indices, Array]:
        """Return the moved pairs that Drake, or the height above a half space, finds near [m]."""
        rows, is_moved = self.pairs.rows, self.pairs.is_moved
        near: dict[int, float] = {
            int(i): self._placed.height(*rows[i].tolist())
            for i in np.flatnonzero(self._is_flat & is_moved)
        }
        # Of what stands outside of Drake's model those that are shown first are enough to tell of.
        next(self._near.shown_within(within))
        for found in distances_within(self._near.query, within):
            i = self.pairs.index.get(self._near.own_ids((found.id_A, found.id_B)), -1)
            if i >= 0 and is_moved[i]:
                near[i] = float(found.distance)
        return np.array(list(near), dtype=np.intp), np.array(list(near.values()), dtype=np.float64)

    def _raise(self, lower: Array, left: Indices, pairs: Indices, directions: Array) -> None:
        """Raise the lower bounds that are `left` by slabs, and keep the directions that did."""
        a, b = self.pairs.rows[pairs[left]].T
        slabs = self._placed.slabs(a, b, directions)
        better = slabs > lower[left]
        self._directions[pairs[left[better]]] = directions[better]
        lower[left] = np.maximum(lower[left], slabs)

    def _ask(self, pairs: Indices, within: float) -> tuple[Array, Array]:
        """Return Drake's distances, infinite beyond `within`, and directions from b to a."""
        distances, directions = np.full(len(pairs), np.inf), np.full((len(pairs), 3), np.nan)
        place = {int(pair): i for i, pair in enumerate(pairs)}
        for found in self._asked(pairs, within):
            ids = self._near.own_ids((found.id_A, found.id_B))
            pair = self.pairs.index.get(ids, -1)
            i = place.get(pair, -1)
            if i >= 0:
                distances[i] = found.distance
                forwards = ids[0] == self.pairs.ids[pair][0]
                directions[i] = found.nhat_BA_W if forwards else -found.nhat_BA_W
        return distances, directions

    def _asked(self, pairs: Indices, within: float) -> list[Any]:
        """Return what Drake says of some pairs, and maybe of others.

        It is not asked of more than it can be shown: those bounds are left to our own search.
        """
        ids = [self.pairs.ids[i] for i in pairs]
        is_shown = self._near.show_ids(ids)
        query = self._near.query
        if len(pairs) > _FEW or not is_shown:
            return distances_within(query, within)
        drakes = [self._near.drake_ids(both) for both in ids]
        return [distance_of(query, *both) for both in drakes]


def _may_rise(lower: Array, distances: Array, wanted: Array) -> np.ndarray[Any, np.dtype[np.bool_]]:
    """Return which bounds a better direction may lift to what is wanted, or at least by much."""
    hopeful = (distances >= wanted) | (distances > lower + _MUCH)
    return (lower < wanted) & (distances > _TOUCHING) & hopeful
