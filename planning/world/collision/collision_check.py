"""Collision checks and distance queries on configurations, by Drake's exact geometry."""

from collections.abc import Callable, Iterator
from itertools import chain, combinations
from typing import Any

import numpy as np
from jaxtyping import Bool, Float64
from pydrake.common import Parallelism
from pydrake.planning import CollisionCheckerParams, SceneGraphCollisionChecker

from planning.domain.arrays import Array
from planning.domain.curves import motion_samples
from planning.domain.geometry.body_pair import BodyPair
from planning.domain.robot.joints import JointGroup
from planning.domain.robot.manifold import Manifold
from planning.world.collision.distance_rounding import TrueLengths, farther
from planning.world.collision.drake_distance import distances_within
from planning.world.collision.half_spaces import leave_out_half_spaces
from planning.world.collision.margins import PairMargins
from planning.world.collision.measured_pairs import MeasuredMargins, measured_pairs_of
from planning.world.collision.near_static import NearStatic
from planning.world.collision.shape_pairs import candidates_of
from planning.world.drake_model import DrakeModel

# With more pairs than this the nearest one is searched nearby first [m]: a far search takes longer.
_MANY = 10_000
_HORIZONS = (0.01, 0.1, 0.5)


# Largest difference between two measurements of one distance [m].
_SAME = 1e-9


class DrakeCollisionOracle:
    """Collision checker of a group, with margins, by Drake; one context, one thread."""

    def __init__(
        self,
        model: DrakeModel,
        group: JointGroup,
        state: Float64[np.ndarray, " num_positions"],
        margins: PairMargins,
        bare: Callable[[], SceneGraphCollisionChecker] | None = None,
    ) -> None:
        """Check every pair against `margins`; `bare` makes the model's checker."""
        self._model = model
        self._manifold = Manifold.of(group.joints)
        self._checker: Any = bare().Clone() if bare else make_collision_checker(model)
        if margins.largest > 0 or margins.by_pair:
            _apply_margins(self._checker, model, margins)
        self._measured = MeasuredMargins(model, margins)
        self._standing = DistanceProbe(model, margins) if len(model.standing) else None
        self._full = model.follow(np.array(state))
        self._indices = model.position_indices(group)

    def is_free(self, q: Float64[np.ndarray, " nq"]) -> bool:
        """Return whether all pairs keep their margins with the group at q, shape (nq,)."""
        self._full[self._indices] = q
        self._model.follow(self._full)
        free = bool(self._checker.CheckConfigCollisionFree(self._full))
        return free and self._is_kept(self._full)

    def are_free(self, qs: Float64[np.ndarray, "m nq"]) -> Bool[np.ndarray, " m"]:
        """Return the same for each row."""
        full = np.repeat(self._full[None], len(qs), axis=0)
        full[:, self._indices] = qs
        self._model.follow(full)
        verdicts = self._checker.CheckConfigsCollisionFree(list(full), parallelize=Parallelism(1))
        free = np.array(verdicts, dtype=bool)
        for i in np.flatnonzero(free) if self._measured.is_needed or self._standing else ():
            free[i] = self._is_kept(full[i])
        return free

    def _is_kept(self, full: Array) -> bool:
        """Return whether the pairs outside of Drake's checker keep their margins."""
        if not self._measured.are_kept(full):
            return False
        return self._standing is None or self._standing.keeps_standing(full)

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
    """Signed distance queries of pairs of bodies; one context, one thread."""

    def __init__(
        self, model: DrakeModel, margins: PairMargins, near: NearStatic | None = None
    ) -> None:
        """Use a given context of the model, or make one, which takes longer than a query."""
        self._model = model
        self._margins = margins
        self._near = near or NearStatic(model)
        self._ours = measured_pairs_of(model)
        self._lengths = TrueLengths(model)

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
        for _, (body_a, body_b), length, points in self._measured(full, distance, exactly=exactly):
            names = (body_a, body_b) if body_a < body_b else (body_b, body_a)
            if names in nearest and nearest[names].distance <= length:
                continue
            nearest[names] = BodyPair(names, length, points if body_a < body_b else points[::-1])
        return tuple(sorted(nearest.values(), key=lambda pair: (pair.distance, pair.bodies)))

    def geometries_within(
        self, full: Float64[np.ndarray, " num_positions"], distance: float
    ) -> list[tuple[tuple[Any, Any], tuple[str, str], float]]:
        """Return Drake's ids, bodies and distance of geometries at most `distance` apart [m]."""
        return [(ids, bodies, length) for ids, bodies, length, _ in self._measured(full, distance)]

    def nearest_within(
        self, full: Float64[np.ndarray, " num_positions"], horizon: float, least: float = 0.0
    ) -> tuple[BodyPair, ...]:
        """Return the nearest pair within a horizon [m], and all pairs as near as `least` [m].

        No distance is larger than the true one. Drake's may be; they bound the search for true
        ones, which take longer.
        """
        met: tuple[BodyPair, ...] = ()
        for reach in self._reaches(full, least, horizon):
            met = self.pairs_within(full, reach)
            if met:
                break
        reach = max(least, met[0].distance + _SAME, 0.0) if met else least
        return self.pairs_within(full, reach, exactly=True)

    def _reaches(self, full: Array, least: float, horizon: float) -> Iterator[float]:
        """Yield query distances [m], from near to far where there are many pairs."""
        if len(candidates_of(self._model).rows) > _MANY:
            yield from (max(least, reach) for reach in _HORIZONS if reach < horizon)
        self._near.go_to(full)
        yield min(max(least, farther(self._near.surely_within())), horizon)

    def violations(self, full: Float64[np.ndarray, " num_positions"]) -> tuple[BodyPair, ...]:
        """Return every pair of bodies that is nearer than its margin, nearest first."""
        found = self.pairs_within(full, max(self._margins.largest, 1e-9), exactly=True)
        return tuple(pair for pair in found if pair.distance < self._margins.of(*pair.bodies))

    def keeps_standing(self, full: Float64[np.ndarray, " num_positions"]) -> bool:
        """Return whether all pairs with objects outside of the model keep their margins."""
        standing, reach = self._model.standing.rows, max(self._margins.largest, 1e-9)
        return all(
            length > self._margins.of(*bodies)
            for _, bodies, length, _ in self._measured(full, reach)
            if not standing.keys().isdisjoint(bodies)
        )

    def _measured(
        self, full: Array, distance: float, *, exactly: bool = False
    ) -> Iterator[tuple[tuple[Any, Any], tuple[str, str], float, Array]]:
        """Yield ids, bodies, distance and nearest points of the geometries within `distance` [m].

        Pairs that Drake does not measure exactly are measured here; the overlap of boxes is
        Drake's.
        """
        self._near.go_to(full)
        for rows, is_first in self._near.shown_within(distance):
            yield from self._measured_here(rows, distance, is_first=is_first, exactly=exactly)

    def _measured_here(
        self, rows: list[int], distance: float, *, is_first: bool, exactly: bool
    ) -> Iterator[tuple[tuple[Any, Any], tuple[str, str], float, Array]]:
        """Yield the same for the objects in some rows, and at first for the model's own pairs."""
        query, near, chosen = self._near.query, self._near, set(rows)
        overlapping: set[tuple[Any, Any]] = set()
        reach = farther(distance) if exactly else distance
        for found in distances_within(query, reach):
            ids = found.id_A, found.id_B
            standing = {near.row(i) for i in ids} - {None}
            is_asked = standing <= chosen if standing else is_first
            bodies = near.bodies(ids) if is_asked else None
            is_ours = near.are_boxes(ids) and found.distance > 0
            if bodies and not is_ours and self._ours.is_for_drake(ids, found.distance):
                overlapping.add(ids)
                length = self._lengths.of(found, query) if exactly else float(found.distance)
                if length > distance:
                    continue
                p_wa = query.GetPoseInWorld(found.id_A).multiply(found.p_ACa)
                p_wb = query.GetPoseInWorld(found.id_B).multiply(found.p_BCb)
                yield ids, bodies, length, np.array([p_wa, p_wb])
        ours = self._ours.within(query, distance) if is_first else ()
        for own in chain(ours, near.boxes_within(rows, distance)):
            if own.ids not in overlapping and own.ids[::-1] not in overlapping:
                yield own.ids, own.bodies, own.length, own.points


def make_collision_checker(model: DrakeModel) -> SceneGraphCollisionChecker:
    """Return Drake's checker of a model, without margins.

    Making one takes longer than many plans; copying it does not.
    """
    plant = model.plant
    movers = [plant.get_joint(index).child_body() for index in model.joint_indices.values()]
    held = [plant.get_body(model.bodies[name]) for name in model.owners]
    robots = sorted({body.model_instance() for body in [*movers, *held]}, key=int)
    return distance_checker(model, robots)


def distance_checker(model: DrakeModel, robots: list[Any]) -> SceneGraphCollisionChecker:
    """Return Drake's checker of model instances; pairs with half spaces are measured elsewhere."""
    checker = SceneGraphCollisionChecker(
        CollisionCheckerParams(
            model=model.diagram,
            robot_model_instances=robots,
            edge_step_size=0.05,
            implicit_context_parallelism=Parallelism(1),
        )
    )

    def leave_out(diagram: Any, contexts: Any) -> None:
        graph = diagram.scene_graph()
        leave_out_half_spaces(graph, graph.GetMyMutableContextFromRoot(contexts.model_context()))

    checker.PerformOperationAgainstAllModelContexts(leave_out)
    return checker


def _apply_margins(checker: Any, model: DrakeModel, margins: PairMargins) -> None:
    """Set the margin of every pair of bodies as padding of Drake's checker."""
    named = [
        (int(index), name, checker.IsPartOfRobot(index)) for index, name in model.body_names.items()
    ]
    padding = np.array(checker.GetPaddingMatrix())
    for (i, a, a_moves), (j, b, b_moves) in combinations(named, 2):
        if a_moves or b_moves:
            padding[i, j] = padding[j, i] = margins.of(a, b)
    checker.SetPaddingMatrix(padding)
