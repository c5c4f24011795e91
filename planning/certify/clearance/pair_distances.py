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
from typing import Any, Protocol

import numpy as np
from jaxtyping import Float64, Int

from planning.certify.clearance.candidate_pairs import candidate_pairs, geometry_of
from planning.certify.clearance.motion_bounds import MotionBounds
from planning.certify.clearance.placed_shapes import PlacedShapes
from planning.certify.intervals.joint_deviation import Segment
from planning.domain.arrays import Array, Indices
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.robot.joints import JointGroup
from planning.world.collision.drake_distance import distances_within, pair_distance
from planning.world.collision.margins import PairMargins
from planning.world.collision.near_static import NearStatic
from planning.world.drake_model import DrakeModel

# Largest number of pairs that are queried from Drake one by one.
_MAX_SINGLE_QUERIES = 24
# Gap between lower bound and distance above which another direction is tried [m].
_GAP_TOLERANCE = 5e-4
# Signed distance below which shapes overlap, so that no slab separates them [m].
_OVERLAP_DISTANCE = -1e-6


class DistanceRequest(Protocol):
    """What distances need of a request: the group, the state of other joints, and margins."""

    @property
    def group(self) -> JointGroup:
        """The joints that move."""
        ...

    @property
    def trajectory(self) -> TimedTrajectory:
        """A motion of the group, at whose start it is put first."""
        ...

    @property
    def state(self) -> Array:
        """Full plant positions, for all joints outside of the group, shape (num_positions,)."""
        ...

    @property
    def margins(self) -> PairMargins:
        """Required distances between bodies."""
        ...


@dataclass(frozen=True)
class MeasuredDistances:
    """Distances of some pairs at one configuration.

    Attributes:
        pairs: Indices of the pairs, shape (n,).
        distances: Measured signed distances; infinite where the bounds sufficed [m].
        lower_bounds: Proven lower bounds on the true distances [m].
    """

    pairs: Int[np.ndarray, " n"]
    distances: Float64[np.ndarray, " n"]
    lower_bounds: Float64[np.ndarray, " n"]


class PairDistances:
    """Distance queries for the candidate pairs, in a Drake context of its own.

    Attributes:
        pairs: All pairs that may collide.
    """

    def __init__(self, model: DrakeModel, request: DistanceRequest) -> None:
        """Make a context, and put the group at the trajectory's start.

        Raises:
            ModelInvalid: A shape or a joint of a kind that cannot be certified.
        """
        self._model, self._group, self._state = model, request.group, request.state
        geometry = geometry_of(model)
        self._shapes = geometry.shapes
        self._bounds = MotionBounds(model, request.group, geometry.shapes)
        self.pairs = candidate_pairs(geometry, self._bounds, request.margins)
        self._has_half_space = self._shapes.is_half_space[self.pairs.rows].any(axis=1)
        self._directions = np.full((len(self.pairs.ids), 3), np.nan)
        self._near_static = NearStatic(model)
        self._placed_shapes = PlacedShapes(model, self._shapes, self._bounds)
        self.set_positions(request.trajectory.start)

    @property
    def moved_bodies(self) -> set[str]:
        """Full names of the bodies moved by the group."""
        chains = self._bounds.chains
        return {name for i, name in self._model.body_names.items() if chains.get(int(i))}

    def set_positions(self, q: Float64[np.ndarray, " nq"]) -> None:
        """Put the group at q; all other joints keep the request's state."""
        full = self._model.embed(self._group, q, self._state)
        self._near_static.set_positions(full)
        self._placed_shapes.update_poses(self._near_static.plant_context)

    def max_approaches(self, segment: Segment, pairs: Indices) -> Float64[np.ndarray, " n"]:
        """Return the largest approach of some pairs within a segment, from its centre [m].

        The group must be at the segment's centre (`set_positions`).
        """
        placed = self._placed_shapes
        return self._sum_between(
            self._bounds.max_displacements(
                placed.rotations, placed.positions, segment.max_rotation, segment.max_translation
            ),
            pairs,
        )

    def sensitivities(self, pairs: Indices) -> Float64[np.ndarray, " n"]:
        """Return the growth of `max_approaches` per error of every joint [m per rad or m]."""
        placed = self._placed_shapes
        return self._sum_between(
            self._bounds.sensitivities(placed.rotations, placed.positions), pairs
        )

    def _sum_between(self, displacements: Array, pairs: Indices) -> Array:
        """Return the sum over the joints that move one shape of a pair relative to the other.

        In the frame of a half space the joints move the other shape.
        """
        is_carried_by, is_half_space = self._bounds.is_carried_by, self._shapes.is_half_space
        a, b = self.pairs.rows[pairs].T
        by_a = np.where(
            is_carried_by[a] & ~is_carried_by[b],
            displacements[np.where(is_half_space[a], b, a)],
            0.0,
        )
        by_b = np.where(
            is_carried_by[b] & ~is_carried_by[a],
            displacements[np.where(is_half_space[b], a, b)],
            0.0,
        )
        return (by_a + by_b).sum(axis=1)

    def sphere_distances(self, pairs: Indices) -> Float64[np.ndarray, " n"]:
        """Return the distances of the bounding spheres of pairs [m], as lower bounds of theirs."""
        a, b = self.pairs.rows[pairs].T
        return self._placed_shapes.sphere_distances(a, b)

    def measure(self, pairs: Indices, thresholds: Float64[np.ndarray, " n"]) -> MeasuredDistances:
        """Raise lower bounds of distances to the thresholds [m], or as far as possible.

        Pairs whose bound reaches its threshold may be left unmeasured.
        """
        a, b = self.pairs.rows[pairs].T
        lower, distances = self._placed_shapes.sphere_distances(a, b), np.full(len(pairs), np.inf)
        has_half_space = self._has_half_space[pairs]
        for i in np.flatnonzero(has_half_space):
            distances[i] = lower[i] = self._placed_shapes.height(int(a[i]), int(b[i]))
        undecided = np.flatnonzero((lower < thresholds) & ~has_half_space)
        self._raise_bounds(lower, undecided, pairs, self._directions[pairs[undecided]])
        undecided = undecided[lower[undecided] < thresholds[undecided]]
        if len(undecided):
            distances[undecided], directions = self._query_drake(
                pairs[undecided], float(thresholds[undecided].max())
            )
            self._raise_bounds(lower, undecided, pairs, directions)
        undecided = undecided[_is_improvable(lower, distances, thresholds)[undecided]]
        if len(undecided):
            self._raise_bounds(
                lower, undecided, pairs, self._placed_shapes.best_axes(a[undecided], b[undecided])
            )
        for i in undecided[_is_improvable(lower, distances, thresholds)[undecided]]:
            gjk = self._placed_shapes.bound_distance(int(a[i]), int(b[i]), float(thresholds[i]))
            self._directions[pairs[i]] = gjk.direction
            lower[i] = max(lower[i], gjk.lower)
            distances[i] = min(distances[i], gjk.upper)
        return MeasuredDistances(pairs, distances, lower)

    def tight_upper_bound(self, pair: int) -> float:
        """Return a close upper bound on the distance of a pair [m]."""
        a, b = self.pairs.rows[pair].tolist()
        if self._has_half_space[pair]:
            return self._placed_shapes.height(a, b)
        return self._placed_shapes.bound_distance(a, b, np.inf, gap_tolerance=0.0).upper

    def pairs_within(self, max_distance: float) -> tuple[Indices, Array]:
        """Return moving pairs within a distance [m], by Drake or by height above a half space."""
        rows, is_moved = self.pairs.rows, self.pairs.is_moved
        distances: dict[int, float] = {
            int(i): self._placed_shapes.height(*rows[i].tolist())
            for i in np.flatnonzero(self._has_half_space & is_moved)
        }
        # Of the static objects outside of Drake's model the first nearby batch is enough for a
        # report.
        next(self._near_static.register_within(max_distance))
        for found in distances_within(self._near_static.query, max_distance):
            i = self.pairs.index.get(self._near_static.own_ids((found.id_A, found.id_B)), -1)
            if i >= 0 and is_moved[i]:
                distances[i] = float(found.distance)
        return np.array(list(distances), dtype=np.intp), np.array(
            list(distances.values()), dtype=np.float64
        )

    def _raise_bounds(self, lower: Array, rows: Indices, pairs: Indices, directions: Array) -> None:
        """Raise lower bounds of the rows `rows` by slabs; store the directions that improved."""
        a, b = self.pairs.rows[pairs[rows]].T
        slabs = self._placed_shapes.slab_widths(a, b, directions)
        is_improved = slabs > lower[rows]
        self._directions[pairs[rows[is_improved]]] = directions[is_improved]
        lower[rows] = np.maximum(lower[rows], slabs)

    def _query_drake(self, pairs: Indices, max_distance: float) -> tuple[Array, Array]:
        """Return Drake's distances, infinite beyond `max_distance`, and directions from b to a."""
        distances, directions = np.full(len(pairs), np.inf), np.full((len(pairs), 3), np.nan)
        row_of = {int(pair): i for i, pair in enumerate(pairs)}
        for found in self._drake_distances(pairs, max_distance):
            ids = self._near_static.own_ids((found.id_A, found.id_B))
            pair = self.pairs.index.get(ids, -1)
            i = row_of.get(pair, -1)
            if i >= 0:
                distances[i] = found.distance
                is_forward = ids[0] == self.pairs.ids[pair][0]
                directions[i] = found.nhat_BA_W if is_forward else -found.nhat_BA_W
        return distances, directions

    def _drake_distances(self, pairs: Indices, max_distance: float) -> list[Any]:
        """Return Drake's signed distances of some pairs, possibly with others.

        Static objects that do not fit into Drake's context are left out: GJK bounds their
        distances.
        """
        ids = [self.pairs.ids[i] for i in pairs]
        is_shown = self._near_static.register_pairs(ids)
        query = self._near_static.query
        if len(pairs) > _MAX_SINGLE_QUERIES or not is_shown:
            return distances_within(query, max_distance)
        drakes = [self._near_static.drake_ids(both) for both in ids]
        return [pair_distance(query, *both) for both in drakes]


def _is_improvable(
    lower: Array, distances: Array, thresholds: Array
) -> np.ndarray[Any, np.dtype[np.bool_]]:
    """Return whether another direction may raise each bound to its threshold, or by much."""
    has_gap = (distances >= thresholds) | (distances > lower + _GAP_TOLERANCE)
    return (lower < thresholds) & (distances > _OVERLAP_DISTANCE) & has_gap
