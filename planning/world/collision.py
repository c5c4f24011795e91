"""Collision verdicts on configurations, by Drake's exact geometry."""

from collections.abc import Iterator
from itertools import combinations
from typing import Any

import numpy as np
from jaxtyping import Bool, Float64
from pydrake.common import Parallelism
from pydrake.planning import CollisionCheckerParams, SceneGraphCollisionChecker
from pydrake.systems.framework import Context

from planning.domain import motion_samples
from planning.domain.body_pair import BodyPair
from planning.domain.joints import JointGroup
from planning.domain.manifold import Manifold
from planning.world.contexts import measuring_context
from planning.world.drake_model import DrakeModel
from planning.world.half_spaces import leave_out_half_spaces
from planning.world.margins import PairMargins
from planning.world.measured_pairs import MeasuredMargins, measured_pairs_of
from planning.world.true_lengths import TrueLengths, farther

type Array = np.ndarray[Any, np.dtype[np.float64]]

# A distance that is measured again, among others, differs by less [m].
_SAME = 1e-9


class DrakeCollisionOracle:
    """Says whether configurations of a group keep their distances; one context, one thread."""

    def __init__(
        self,
        model: DrakeModel,
        group: JointGroup,
        state: Float64[np.ndarray, " num_positions"],
        margins: PairMargins,
        bare: SceneGraphCollisionChecker | None = None,
    ) -> None:
        """Demand `margins` of every pair of bodies; `bare` is the model's `bare_checker`."""
        self._model = model
        self._manifold = Manifold.of(group.joints)
        self._checker: Any = bare.Clone() if bare else bare_checker(model)
        if margins.largest > 0 or margins.by_pair:
            _apply_margins(self._checker, model, margins)
        self._measured = MeasuredMargins(model, margins)
        self._full = model.follow(np.array(state))
        self._indices = model.position_indices(group)

    def is_free(self, q: Float64[np.ndarray, " nq"]) -> bool:
        """Return whether the group at q, shape (nq,), keeps its distances."""
        self._full[self._indices] = q
        self._model.follow(self._full)
        free = bool(self._checker.CheckConfigCollisionFree(self._full))
        return free and self._measured.are_kept(self._full)

    def are_free(self, qs: Float64[np.ndarray, "m nq"]) -> Bool[np.ndarray, " m"]:
        """Return the same for each row."""
        full = np.repeat(self._full[None], len(qs), axis=0)
        full[:, self._indices] = qs
        self._model.follow(full)
        verdicts = self._checker.CheckConfigsCollisionFree(list(full), parallelize=Parallelism(1))
        free = np.array(verdicts, dtype=bool)
        for i in np.flatnonzero(free) if self._measured.is_needed else ():
            free[i] = self._measured.are_kept(full[i])
        return free

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
    """Measures signed distances of pairs of bodies; one context, one thread."""

    def __init__(
        self, model: DrakeModel, margins: PairMargins, context: Context | None = None
    ) -> None:
        """Use a `measuring_context` of the model, or make one, which takes longer than a query."""
        self._model = model
        self._margins = margins
        self._context = measuring_context(model) if context is None else context
        self._plant_context = model.plant.GetMyMutableContextFromRoot(self._context)
        self._query_port = model.scene_graph.get_query_output_port()
        self._query_context = model.scene_graph.GetMyContextFromRoot(self._context)
        self._ours = measured_pairs_of(model)
        self._lengths = TrueLengths(model.scene_graph)

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
            full: Where the plant is.
            distance: How far to look [m].
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
        """Return Drake's ids, the bodies and the distance of geometries at most so far apart."""
        return [(ids, bodies, length) for ids, bodies, length, _ in self._measured(full, distance)]

    def nearest_within(
        self, full: Float64[np.ndarray, " num_positions"], horizon: float, least: float = 0.0
    ) -> tuple[BodyPair, ...]:
        """Return the nearest pair within a horizon [m], and all that are as near as `least` [m].

        No distance is larger than the true one. Drake's may be, and say how far to look for true
        ones, which take longer.
        """
        met = self.pairs_within(full, horizon)
        reach = max(least, met[0].distance + _SAME, 0.0) if met else least
        return self.pairs_within(full, reach, exactly=True)

    def violations(self, full: Float64[np.ndarray, " num_positions"]) -> tuple[BodyPair, ...]:
        """Return every pair of bodies that is nearer than its margin, nearest first."""
        found = self.pairs_within(full, max(self._margins.largest, 1e-9), exactly=True)
        return tuple(pair for pair in found if pair.distance < self._margins.of(*pair.bodies))

    def _query(self, full: Array) -> Any:
        self._model.plant.SetPositions(self._plant_context, full)
        return self._query_port.Eval(self._query_context)

    def _measured(
        self, full: Array, distance: float, *, exactly: bool = False
    ) -> Iterator[tuple[tuple[Any, Any], tuple[str, str], float, Array]]:
        """Yield ids, bodies, distance and nearest points of all geometries at most so far apart.

        Pairs that are ours are measured here; that boxes overlap Drake knows.
        """
        query = self._query(full)
        overlapping: set[tuple[Any, Any]] = set()
        reach = farther(distance) if exactly else distance
        for found in query.ComputeSignedDistancePairwiseClosestPoints(reach):
            ids = found.id_A, found.id_B
            if self._ours.is_for_drake(ids, found.distance):
                overlapping.add(ids)
                length = self._lengths.of(found, query) if exactly else float(found.distance)
                if length > distance:
                    continue
                p_wa = query.GetPoseInWorld(found.id_A).multiply(found.p_ACa)
                p_wb = query.GetPoseInWorld(found.id_B).multiply(found.p_BCb)
                yield ids, self._bodies(query, ids), length, np.array([p_wa, p_wb])
        for own in self._ours.within(query, distance):
            if own.ids not in overlapping and own.ids[::-1] not in overlapping:
                yield own.ids, own.bodies, own.length, own.points

    def _bodies(self, query: Any, ids: tuple[Any, Any]) -> tuple[str, str]:
        inspector = query.inspector()
        return self._body(inspector, ids[0]), self._body(inspector, ids[1])

    def _body(self, inspector: Any, geometry: Any) -> str:
        body = self._model.plant.GetBodyFromFrameId(inspector.GetFrameId(geometry))
        return self._model.body_names.get(body.index(), body.name())


def bare_checker(model: DrakeModel) -> SceneGraphCollisionChecker:
    """Return Drake's checker of a model, without margins.

    Making one takes longer than many a plan; copying it does not.
    """
    plant = model.plant
    movers = [plant.get_joint(index).child_body() for index in model.joint_indices.values()]
    held = [plant.get_body(model.bodies[name]) for name in model.owners]
    robots = sorted({body.model_instance() for body in [*movers, *held]}, key=int)
    return distance_checker(model, robots)


def distance_checker(model: DrakeModel, robots: list[Any]) -> SceneGraphCollisionChecker:
    """Return Drake's checker of model instances; pairs with half spaces are left to us."""
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
    """Tell Drake's checker the margin of every pair of bodies as its padding."""
    named = [
        (int(index), name, checker.IsPartOfRobot(index)) for index, name in model.body_names.items()
    ]
    padding = np.array(checker.GetPaddingMatrix())
    for (i, a, a_moves), (j, b, b_moves) in combinations(named, 2):
        if a_moves or b_moves:
            padding[i, j] = padding[j, i] = margins.of(a, b)
    checker.SetPaddingMatrix(padding)
