"""Collision checks and distance queries on configurations, by Drake's exact geometry."""

from collections.abc import Callable, Iterator
from itertools import chain
from typing import Any

import numpy as np
from jaxtyping import Bool, Float64
from pydrake.common import Parallelism
from pydrake.planning import SceneGraphCollisionChecker

from planning.domain.arrays import Array
from planning.domain.curves import motion_samples
from planning.domain.geometry.body_pair import BodyPair
from planning.domain.robot.joints import JointGroup
from planning.domain.robot.manifold import Manifold
from planning.world.collision.collision_pairs import collision_pairs_of
from planning.world.collision.distance_lower_bounds import (
    DistanceLowerBounds,
    inflated_query_distance,
)
from planning.world.collision.drake_checker import apply_margins, make_collision_checker
from planning.world.collision.drake_distance import distances_within
from planning.world.collision.margins import PairMargins
from planning.world.collision.measured_pairs import MeasuredMargins, measured_pairs_of
from planning.world.collision.near_static import NearStatic
from planning.world.drake_model import DrakeModel

# With more pairs than this the nearest one is searched nearby first [m]: a far search takes longer.
_MANY_PAIRS = 10_000
_QUERY_DISTANCES = (0.01, 0.1, 0.5)


# Largest difference between two measurements of one distance [m].
_DISTANCE_TOLERANCE = 1e-9


class DrakeCollisionOracle:
    """Collision checker of a group, with margins, by Drake; one context, one thread."""

    def __init__(
        self,
        model: DrakeModel,
        group: JointGroup,
        state: Float64[np.ndarray, " num_positions"],
        margins: PairMargins,
        make_checker: Callable[[], SceneGraphCollisionChecker] | None = None,
    ) -> None:
        """Check every pair against `margins`.

        `make_checker` makes a checker of the model without margins, for this oracle alone.
        """
        self._model = model
        self._manifold = Manifold.of(group.joints)
        self._checker: Any = make_checker() if make_checker else make_collision_checker(model)
        if margins.largest > 0 or margins.by_pair:
            apply_margins(self._checker, model, margins)
        self._measured_margins = MeasuredMargins(model, margins)
        self._static_probe = DistanceProbe(model, margins) if len(model.static_objects) else None
        self._full = model.apply_couplings(np.array(state))
        self._indices = model.position_indices(group)

    def is_free(self, q: Float64[np.ndarray, " nq"]) -> bool:
        """Return whether all pairs keep their margins with the group at q, shape (nq,)."""
        self._full[self._indices] = q
        self._model.apply_couplings(self._full)
        free = bool(self._checker.CheckConfigCollisionFree(self._full))
        return free and self._keeps_measured_margins(self._full)

    def are_free(self, qs: Float64[np.ndarray, "m nq"]) -> Bool[np.ndarray, " m"]:
        """Return the same for each row."""
        full = np.repeat(self._full[None], len(qs), axis=0)
        full[:, self._indices] = qs
        self._model.apply_couplings(full)
        verdicts = self._checker.CheckConfigsCollisionFree(list(full), parallelize=Parallelism(1))
        free = np.array(verdicts, dtype=bool)
        if self._measured_margins.is_needed or self._static_probe:
            for i in np.flatnonzero(free):
                free[i] = self._keeps_measured_margins(full[i])
        return free

    def _keeps_measured_margins(self, full: Array) -> bool:
        """Return whether the pairs outside of Drake's checker keep their margins."""
        if not self._measured_margins.are_satisfied(full):
            return False
        return self._static_probe is None or self._static_probe.keeps_static_margins(full)

    def is_motion_free(
        self,
        origin: Float64[np.ndarray, " nq"],
        displacement: Float64[np.ndarray, " nv"],
        resolution: float,
    ) -> bool:
        """Return whether every sample of a motion is free, as `motion_samples` defines them."""
        motion = origin, displacement
        return motion_samples.is_motion_free(self._manifold, self.are_free, motion, resolution)

    def are_motions_free(
        self,
        origins: Float64[np.ndarray, "m nq"],
        displacements: Float64[np.ndarray, "m nv"],
        resolution: float,
    ) -> Bool[np.ndarray, " m"]:
        """Return the same for each pair of rows."""
        motions = origins, displacements
        return motion_samples.are_motions_free(self._manifold, self.are_free, motions, resolution)


class DistanceProbe:
    """Signed distance queries of pairs of bodies; one thread."""

    def __init__(self, model: DrakeModel, margins: PairMargins) -> None:
        """Prepare queries in the context that all probes of the model share."""
        self._model = model
        self._margins = margins
        self._near_static = NearStatic.shared(model)
        self._measured_pairs = measured_pairs_of(model)
        self._lower_bounds = DistanceLowerBounds(model)

    def pairs_within(
        self,
        full: Float64[np.ndarray, " num_positions"],
        distance: float,
        *,
        exactly: bool = False,
    ) -> tuple[BodyPair, ...]:
        """Return every pair of bodies at most `distance` [m] apart, nearest first.

        One entry per pair of bodies: that of its two nearest geometries.

        Args:
            full: Full configuration of the plant.
            distance: Largest distance [m].
            exactly: Whether no distance may be larger than the true one: Drake's of round shapes
                are, by up to 0.1 mm. That takes longer.
        """
        nearest: dict[tuple[str, str], BodyPair] = {}
        for _, (body_a, body_b), length, points in self._geometry_distances(
            full, distance, exactly=exactly
        ):
            names = (body_a, body_b) if body_a < body_b else (body_b, body_a)
            if names in nearest and nearest[names].distance <= length:
                continue
            nearest[names] = BodyPair(names, length, points if body_a < body_b else points[::-1])
        return tuple(sorted(nearest.values(), key=lambda pair: (pair.distance, pair.bodies)))

    def geometries_within(
        self, full: Float64[np.ndarray, " num_positions"], distance: float
    ) -> list[tuple[tuple[Any, Any], tuple[str, str], float]]:
        """Return Drake's ids, bodies and distance of geometries at most `distance` apart [m]."""
        return [
            (ids, bodies, length)
            for ids, bodies, length, _ in self._geometry_distances(full, distance)
        ]

    def nearest_within(
        self,
        full: Float64[np.ndarray, " num_positions"],
        max_distance: float,
        include_within: float = 0.0,
    ) -> tuple[BodyPair, ...]:
        """Return the nearest pair within a horizon [m], and all pairs within `include_within` [m].

        No distance is larger than the true one. Drake's may be; they bound the search for true
        ones, which take longer.
        """
        smallest: float | None = None
        for query_distance in self._query_distances(full, include_within, max_distance):
            smallest = self._smallest_within(full, query_distance)
            if smallest is not None:
                break
        query_distance = (
            include_within
            if smallest is None
            else max(include_within, smallest + _DISTANCE_TOLERANCE, 0.0)
        )
        return self.pairs_within(full, query_distance, exactly=True)

    def _smallest_within(self, full: Array, distance: float) -> float | None:
        """Return the smallest distance of all pairs, if it is at most `distance` [m].

        Where shapes overlap it is any distance of two that do.
        """
        self._near_static.set_positions(full)
        found = [
            length
            for rows, is_first in self._near_static.register_within(distance)
            for length in self._smallest_of_batch(rows, distance, is_first=is_first)
        ]
        return min(found, default=None)

    def _smallest_of_batch(
        self, rows: list[int], distance: float, *, is_first: bool
    ) -> Iterator[float]:
        """Yield Drake's smallest distance, if any, and all that are measured here [m]."""
        query, chosen = self._near_static.query, set(rows)
        for drake_pair in sorted(distances_within(query, distance), key=lambda p: p.distance):
            if self._drake_bodies(drake_pair, chosen, is_first=is_first):
                yield float(drake_pair.distance)
                break
        for pair in self._measured(rows, distance, is_first=is_first):
            yield pair.distance

    def _query_distances(
        self, full: Array, include_within: float, max_distance: float
    ) -> Iterator[float]:
        """Yield query distances [m], from near to far where there are many pairs."""
        if len(collision_pairs_of(self._model).rows) > _MANY_PAIRS:
            yield from (
                max(include_within, reach) for reach in _QUERY_DISTANCES if reach < max_distance
            )
        self._near_static.set_positions(full)
        yield min(
            max(include_within, inflated_query_distance(self._near_static.nearest_upper_bound())),
            max_distance,
        )

    def violations(self, full: Float64[np.ndarray, " num_positions"]) -> tuple[BodyPair, ...]:
        """Return every pair of bodies that is nearer than its margin, nearest first."""
        found = self.pairs_within(full, max(self._margins.largest, 1e-9), exactly=True)
        return tuple(pair for pair in found if pair.distance < self._margins.of(*pair.bodies))

    def keeps_static_margins(self, full: Float64[np.ndarray, " num_positions"]) -> bool:
        """Return whether all pairs with objects outside of the model keep their margins."""
        static_rows = self._model.static_objects.rows
        query_distance = max(self._margins.largest, 1e-9)
        return all(
            length > self._margins.of(*bodies)
            for _, bodies, length, _ in self._geometry_distances(full, query_distance)
            if not static_rows.keys().isdisjoint(bodies)
        )

    def _geometry_distances(
        self, full: Array, distance: float, *, exactly: bool = False
    ) -> Iterator[tuple[tuple[Any, Any], tuple[str, str], float, Array]]:
        """Yield ids, bodies, distance and nearest points of the geometries within `distance` [m].

        Pairs that Drake does not measure exactly are measured here; the overlap of boxes is
        Drake's.
        """
        self._near_static.set_positions(full)
        for rows, is_first in self._near_static.register_within(distance):
            yield from self._batch_distances(rows, distance, is_first=is_first, exactly=exactly)

    def _batch_distances(
        self, rows: list[int], distance: float, *, is_first: bool, exactly: bool
    ) -> Iterator[tuple[tuple[Any, Any], tuple[str, str], float, Array]]:
        """Yield the same for the objects in some rows, and at first for the model's own pairs."""
        query, chosen = self._near_static.query, set(rows)
        overlapping: set[tuple[Any, Any]] = set()
        query_distance = inflated_query_distance(distance) if exactly else distance
        for drake_pair in distances_within(query, query_distance):
            ids = drake_pair.id_A, drake_pair.id_B
            bodies = self._drake_bodies(drake_pair, chosen, is_first=is_first)
            if bodies:
                overlapping.add(ids)
                length = (
                    self._lower_bounds.lower_bound(drake_pair, query)
                    if exactly
                    else float(drake_pair.distance)
                )
                if length > distance:
                    continue
                p_wa = query.GetPoseInWorld(drake_pair.id_A).multiply(drake_pair.p_ACa)
                p_wb = query.GetPoseInWorld(drake_pair.id_B).multiply(drake_pair.p_BCb)
                yield ids, bodies, length, np.array([p_wa, p_wb])
        for pair in self._measured(rows, distance, is_first=is_first):
            if pair.ids not in overlapping and pair.ids[::-1] not in overlapping:
                yield pair.ids, pair.bodies, pair.distance, pair.points

    def _drake_bodies(
        self, drake_pair: Any, chosen: set[int], *, is_first: bool
    ) -> tuple[str, str] | None:
        """Return the bodies of a pair whose distance is Drake's, not measured here; else None."""
        near_static, ids = self._near_static, (drake_pair.id_A, drake_pair.id_B)
        static_rows = {near_static.row(i) for i in ids} - {None}
        is_in_batch = static_rows <= chosen if static_rows else is_first
        bodies = near_static.bodies(ids) if is_in_batch else None
        is_measured_here = drake_pair.distance > 0 and near_static.are_boxes(ids)
        if not bodies or is_measured_here:
            return None
        is_drakes = self._measured_pairs.uses_drake_distance(ids, drake_pair.distance)
        return bodies if is_drakes else None

    def _measured(self, rows: list[int], distance: float, *, is_first: bool) -> Iterator[Any]:
        """Return the pairs within `distance` [m] that are measured here, by rows as of a batch."""
        own = self._measured_pairs.within(self._near_static.query, distance) if is_first else ()
        return chain(own, self._near_static.boxes_within(rows, distance))
