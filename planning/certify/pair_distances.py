"""Distances of all pairs of shapes that may collide, and bounds on how they change.

Drake finds the nearest points of two shapes; its answer is never below the true distance but for
rounding, and may be above it by the tolerance of its iterations (its documentation observes up to
0.05 mm). So Drake's distances are reported, and decide that a pair is too near; that a pair is far
enough is decided by the slab along Drake's direction, which is exact (see `collision_shapes`). Only
of pairs that Drake leaves out, being farther apart than asked for, its word is taken, less a
tolerance. Half spaces, which Drake does not measure, are slabs already.
"""

from dataclasses import dataclass
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from jaxtyping import Bool, Float64, Int
from pydrake.geometry import CollisionFilterDeclaration, GeometryId, GeometrySet
from pydrake.multibody.tree import BodyIndex
from pydrake.planning import RobotDiagram

from planning.certify.collision_shapes import CollisionShapes, collision_shapes
from planning.certify.motion_bounds import MotionBounds
from planning.certify.request import CertifyRequest
from planning.certify.segments import Segment
from planning.world.drake_model import DrakeModel

type Array = np.ndarray[Any, np.dtype[np.float64]]
type Indices = np.ndarray[Any, np.dtype[np.intp]]

# How far Drake may be wrong about pairs that it leaves out [m].
LEFT_OUT_TOLERANCE = 1e-3
# Up to so many pairs are asked for one by one.
_FEW = 6


@dataclass(frozen=True)
class Measured:
    """Distances of some pairs at one configuration.

    Attributes:
        pairs: Which ones, shape (n,).
        distances: Drake's signed distances, or the distance asked for where it is farther [m].
        lower: Proven lower bounds on them [m].
        is_exact: Whether the pair was measured, not left out.
    """

    pairs: Int[np.ndarray, " n"]
    distances: Float64[np.ndarray, " n"]
    lower: Float64[np.ndarray, " n"]
    is_exact: Bool[np.ndarray, " n"]


@dataclass(frozen=True)
class _Geometry:
    """What is read of a model once; holds no reference to it."""

    shapes: CollisionShapes
    candidates: list[tuple[GeometryId, GeometryId]]


_read: WeakKeyDictionary[RobotDiagram, _Geometry] = WeakKeyDictionary()


def _geometry(model: DrakeModel) -> _Geometry:
    """Return the model's collision geometry, reading it the first time only."""
    found = _read.get(model.diagram)
    if found is None:
        candidates = sorted(model.scene_graph.model_inspector().GetCollisionCandidates())
        found = _read[model.diagram] = _Geometry(collision_shapes(model), candidates)
    return found


def _names(model: DrakeModel) -> dict[int, str]:
    bodies = [model.plant.get_body(BodyIndex(i)) for i in range(model.plant.num_bodies())]
    return {int(b.index()): model.body_names.get(b.index(), b.name()) for b in bodies}


class PairDistances:
    """Measures distances in a context of its own.

    Attributes:
        names: The bodies of every pair that the group can move relative to each other.
        margins: The distance demanded of each [m], shape (num_pairs,).
        fixed: Bodies and distance demanded of the pairs that nothing moves, by their geometries.
    """

    def __init__(self, model: DrakeModel, request: CertifyRequest) -> None:
        """Make a context, and find out which pairs the group moves.

        Raises:
            ModelInvalid: A shape or a joint of a kind that cannot be certified.
        """
        self._model, self._group, self._state = model, request.group, request.state
        geometry = _geometry(model)
        self._shapes = geometry.shapes
        self._bounds = MotionBounds(model, request.group, geometry.shapes)
        self._context = model.diagram.CreateDefaultContext()
        self._plant_context = model.plant.GetMyMutableContextFromRoot(self._context)
        self._query_context = model.scene_graph.GetMyMutableContextFromRoot(self._context)
        self._port = model.scene_graph.get_query_output_port()
        self._sort_pairs(geometry.candidates, request)
        self._leave_out_half_spaces()
        count = model.plant.num_bodies()
        self._R_WB, self._p_wb = np.tile(np.eye(3), (count, 1, 1)), np.zeros((count, 3))
        of_interest = {*map(int, self._shapes.bodies), *map(int, self._bounds.joint_bodies)}
        bodies = [model.plant.get_body(BodyIndex(i)) for i in sorted(of_interest)]
        self._moving = [body for body in bodies if self._bounds.chains[int(body.index())]]
        self.go_to(request.trajectory.start)
        self._read_poses(bodies)

    @property
    def num_pairs(self) -> int:
        """How many pairs the group moves."""
        return len(self.names)

    def go_to(self, q: Float64[np.ndarray, " nq"]) -> None:
        """Put the group at q, and all else where it is."""
        full = self._model.embed(self._group, q, self._state)
        self._model.plant.SetPositions(self._plant_context, full)
        self._read_poses(self._moving)

    def approaches(self, segment: Segment, pairs: Indices) -> Float64[np.ndarray, " n"]:
        """Return how much nearer some pairs can come within a segment from its centre [m].

        The centre is where the group must be.
        """
        reaches = self._bounds.reaches(self._R_WB, self._p_wb, segment.turn, segment.shift)
        a, b = self._rows[pairs].T
        relative = self._bounds.carries[a] != self._bounds.carries[b]
        return np.where(relative, reaches[a] + reaches[b], 0.0).sum(axis=1)

    def measure(self, pairs: Indices, enough: float) -> Measured:
        """Measure some pairs here, at least those that are nearer than `enough` [m]."""
        distances, directions = np.full(len(pairs), enough), np.full((len(pairs), 3), np.nan)
        rows, is_exact = self._rows[pairs], np.zeros(len(pairs), dtype=bool)
        place = {int(pair): i for i, pair in enumerate(pairs)}
        for found in self._ask(pairs, enough):
            key = found.id_A, found.id_B
            i = place.get(self._index.get(key, -1), -1)
            if i >= 0:
                distances[i], directions[i], is_exact[i] = found.distance, found.nhat_BA_W, True
                rows[i] = self._shapes.rows[found.id_A], self._shapes.rows[found.id_B]
        lower = np.where(is_exact, -np.inf, distances - LEFT_OUT_TOLERANCE)
        known = is_exact & np.isfinite(directions).all(axis=1)
        lower[known] = self._slabs(rows[known, 0], rows[known, 1], directions[known])
        for i in np.flatnonzero(self._has_half_space[pairs]):
            distances[i] = lower[i] = self._above_half_space(*self._rows[pairs[i]].tolist())
            is_exact[i] = True
        return Measured(pairs, distances, lower, is_exact)

    def fixed_distances(self, within: float) -> list[tuple[tuple[str, str], float, float]]:
        """Return names, distance and demand of the near pairs that nothing moves."""
        query: Any = self._port.Eval(self._query_context)
        near: list[tuple[tuple[str, str], float, float]] = []
        for found in query.ComputeSignedDistancePairwiseClosestPoints(within):
            key = found.id_A, found.id_B
            fixed = self._fixed.get(key) or self._fixed.get((found.id_B, found.id_A))
            if fixed is not None:
                near.append((fixed[0], float(found.distance), fixed[1]))
        for (a, b), (names, margin) in self._fixed.items():
            rows = self._shapes.rows[a], self._shapes.rows[b]
            if self._shapes.is_half_space[list(rows)].any():
                near.append((names, self._above_half_space(*rows), margin))
        return near

    def _sort_pairs(
        self, candidates: list[tuple[GeometryId, GeometryId]], request: CertifyRequest
    ) -> None:
        rows_of, bodies = self._shapes.rows, self._shapes.bodies
        names = _names(self._model)
        margins: dict[tuple[str, str], float] = {}
        self.names: list[tuple[str, str]] = []
        self._fixed: dict[tuple[GeometryId, GeometryId], tuple[tuple[str, str], float]] = {}
        self._index: dict[tuple[GeometryId, GeometryId], int] = {}
        self._ids: list[tuple[GeometryId, GeometryId]] = []
        for ids in candidates:
            a, b = (int(bodies[rows_of[i]]) for i in ids)
            both = names[a], names[b]
            if both not in margins:
                margins[both] = request.margins.of(*both)
            if self._bounds.chains[a] == self._bounds.chains[b]:
                self._fixed[ids] = both, margins[both]
            else:
                self._index[ids] = self._index[ids[1], ids[0]] = len(self.names)
                self._ids.append(ids)
                self.names.append(both)
        rows = [[rows_of[a], rows_of[b]] for a, b in self._ids]
        self._rows = np.array(rows, dtype=np.intp).reshape(-1, 2)
        self._has_half_space = self._shapes.is_half_space[self._rows].any(axis=1)
        self.margins = np.array([margins[both] for both in self.names], dtype=np.float64)

    def _leave_out_half_spaces(self) -> None:
        """Keep Drake, in our context, from measuring what it cannot."""
        flat = [i for i, row in self._shapes.rows.items() if self._shapes.is_half_space[row]]
        if flat:
            rest = GeometrySet(list(self._shapes.rows))
            filters = self._model.scene_graph.collision_filter_manager(self._query_context)
            filters.Apply(CollisionFilterDeclaration().ExcludeBetween(GeometrySet(flat), rest))

    def _ask(self, pairs: Indices, enough: float) -> list[Any]:
        query: Any = self._port.Eval(self._query_context)
        if len(pairs) > _FEW:
            return query.ComputeSignedDistancePairwiseClosestPoints(enough)
        return [
            query.ComputeSignedDistancePairClosestPoints(*self._ids[i])
            for i in pairs
            if not self._has_half_space[i]
        ]

    def _read_poses(self, bodies: list[Any]) -> None:
        plant, context = self._model.plant, self._plant_context
        for body in bodies:
            matrix = plant.EvalBodyPoseInWorld(context, body).GetAsMatrix34()
            self._R_WB[int(body.index())], self._p_wb[int(body.index())] = (
                matrix[:, :3],
                matrix[:, 3],
            )

    def _slabs(self, a: Indices, b: Indices, n: Array) -> Array:
        """Return the width of the slab across n between shapes a, ahead, and b, behind [m]."""
        ahead = -self._reach(a, -n)
        return (ahead - self._reach(b, n)) / np.linalg.norm(n, axis=1)

    def _reach(self, rows: Indices, n: Array) -> Array:
        shapes, bodies = self._shapes, self._shapes.bodies[rows]
        R_WG = self._R_WB[bodies] @ shapes.R_BG[rows]
        p_wg = np.einsum("mij,mj->mi", self._R_WB[bodies], shapes.p_bg[rows]) + self._p_wb[bodies]
        return shapes.reach(rows, R_WG, p_wg, n)

    def _above_half_space(self, a: int, b: int) -> float:
        """Return the height of the lowest point of one shape above the other, a half space [m]."""
        flat, other = (a, b) if self._shapes.is_half_space[a] else (b, a)
        body = self._shapes.bodies[flat]
        up = self._R_WB[body] @ self._shapes.R_BG[flat][:, 2]
        level = up @ (self._R_WB[body] @ self._shapes.p_bg[flat] + self._p_wb[body])
        return float(-self._reach(np.array([other]), -up[None])[0] - level)
