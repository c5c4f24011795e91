"""PairDistances: distances of candidate pairs of shapes, with proven lower bounds.

Drake measures distances; it does not prove them. Its distances of separate shapes are never too
small, but they can be too large: its documentation observes 0.05 mm, and for two boxes with
parallel edges Drake 1.58 returned 60 mm where 25 mm are true. So Drake's distances are reported and
refuse a motion, and its directions are used, but the lower bound is the width of a slab that
contains neither shape (see `collision_shapes`): first of the bounding spheres, then along the last
successful direction, then along Drake's, along the axes of both shapes, and at last along the one
that GJK (`gjk`) finds. Half spaces, which Drake does not measure, are slabs already.
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
from planning.domain.arrays import Array, Indices
from planning.world.collision.drake_distance import distance_of, distances_within
from planning.world.collision.near_static import NearStatic
from planning.world.drake_model import DrakeModel

# Largest number of pairs that are queried from Drake one by one.
_FEW = 24
# Gap between lower bound and distance above which another direction is tried [m].
_MUCH = 5e-4
# Signed distance below which shapes overlap, so that no slab separates them [m].
_TOUCHING = -1e-6


@dataclass(frozen=True)
class Measured:
    """Distances of some pairs at one configuration.

    Attributes:
        pairs: Indices of the pairs, shape (n,).
        distances: Measured signed distances; infinite where the bounds sufficed [m].
        lower: Proven lower bounds on the true distances [m].
    """

    pairs: Int[np.ndarray, " n"]
    distances: Float64[np.ndarray, " n"]
    lower: Float64[np.ndarray, " n"]


class PairDistances:
    """Distance queries for the candidate pairs, in a Drake context of its own.

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
        """Full names of the bodies moved by the group."""
        chains = self._bounds.chains
        return {name for i, name in self._model.body_names.items() if chains.get(int(i))}

    def go_to(self, q: Float64[np.ndarray, " nq"]) -> None:
        """Put the group at q; all other joints keep the request's state."""
        full = self._model.embed(self._group, q, self._state)
        self._near.go_to(full)
        self._placed.place(self._near.plant_context)

    def approaches(self, segment: Segment, pairs: Indices) -> Float64[np.ndarray, " n"]:
        """Return the largest approach of some pairs within a segment, from its centre [m].

        The group must be at the segment's centre (`go_to`).
        """
        placed = self._placed
        return self._between(
            self._bounds.reaches(placed.rotations, placed.positions, segment.turn, segment.shift),
            pairs,
        )

    def sensitivities(self, pairs: Indices) -> Float64[np.ndarray, " n"]:
        """Return the growth of `approaches` per error of every joint [m per rad or m]."""
        placed = self._placed
        return self._between(self._bounds.sensitivities(placed.rotations, placed.positions), pairs)

    def _between(self, moved: Array, pairs: Indices) -> Array:
        """Return the sum over the joints that move one shape of a pair relative to the other.

        In the frame of a half space the joints move the other shape.
        """
        carries, is_flat = self._bounds.carries, self._shapes.is_half_space
        a, b = self.pairs.rows[pairs].T
        by_a = np.where(carries[a] & ~carries[b], moved[np.where(is_flat[a], b, a)], 0.0)
        by_b = np.where(carries[b] & ~carries[a], moved[np.where(is_flat[b], a, b)], 0.0)
        return (by_a + by_b).sum(axis=1)

    def measure(self, pairs: Indices, wanted: Float64[np.ndarray, " n"]) -> Measured:
        """Raise lower bounds of distances to the wanted values, or as far as possible.

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
        """Return a close upper bound on the distance of a pair [m]."""
        a, b = self.pairs.rows[pair].tolist()
        if self._is_flat[pair]:
            return self._placed.height(a, b)
        return self._placed.separate(a, b, np.inf, close=0.0).upper

    def sample(self, within: float) -> tuple[Indices, Array]:
        """Return moving pairs within a distance [m], by Drake or by height above a half space."""
        rows, is_moved = self.pairs.rows, self.pairs.is_moved
        near: dict[int, float] = {
            int(i): self._placed.height(*rows[i].tolist())
            for i in np.flatnonzero(self._is_flat & is_moved)
        }
        # Of the static objects outside of Drake's model the first nearby batch is enough for a
        # report.
        next(self._near.shown_within(within))
        for found in distances_within(self._near.query, within):
            i = self.pairs.index.get(self._near.own_ids((found.id_A, found.id_B)), -1)
            if i >= 0 and is_moved[i]:
                near[i] = float(found.distance)
        return np.array(list(near), dtype=np.intp), np.array(list(near.values()), dtype=np.float64)

    def _raise(self, lower: Array, left: Indices, pairs: Indices, directions: Array) -> None:
        """Raise lower bounds of the rows `left` by slabs; store the directions that improved."""
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
        """Return Drake's signed distances of some pairs, possibly with others.

        Static objects that do not fit into Drake's context are left out: GJK bounds their
        distances.
        """
        ids = [self.pairs.ids[i] for i in pairs]
        is_shown = self._near.show_ids(ids)
        query = self._near.query
        if len(pairs) > _FEW or not is_shown:
            return distances_within(query, within)
        drakes = [self._near.drake_ids(both) for both in ids]
        return [distance_of(query, *both) for both in drakes]


def _may_rise(lower: Array, distances: Array, wanted: Array) -> np.ndarray[Any, np.dtype[np.bool_]]:
    """Return whether another direction may raise each bound to the wanted value, or by much."""
    hopeful = (distances >= wanted) | (distances > lower + _MUCH)
    return (lower < wanted) & (distances > _TOUCHING) & hopeful
