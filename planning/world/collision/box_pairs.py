"""Box pairs: exact distances of boxes, which Drake 1.58 overstates (docs/decisions/0006)."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from jaxtyping import Float64, Int
from pydrake.geometry import Box, GeometryId, Role
from pydrake.planning import RobotDiagram

from planning.domain.arrays import Array
from planning.kernel.box_distance import box_distances, box_gaps
from planning.world.collision.collision_pairs import collision_pairs_of
from planning.world.drake_model import DrakeModel


@dataclass(frozen=True)
class BoxPairs:
    """Pairs of boxes of a model that may collide; holds no reference to the model.

    Attributes:
        ids: Drake's ids of both.
        bodies: Full names of their bodies.
        boxes: Every box that is in a pair.
        rows: Rows of both boxes in `boxes`, shape (n, 2).
        halves: Half sizes of `boxes` [m].
        row_by_ids: Row by Drake's ids, in either order.
    """

    ids: tuple[tuple[GeometryId, GeometryId], ...]
    bodies: tuple[tuple[str, str], ...]
    boxes: tuple[GeometryId, ...]
    rows: Int[np.ndarray, "n 2"]
    halves: Float64[np.ndarray, "k 3"]
    row_by_ids: dict[tuple[GeometryId, GeometryId], int]

    def within(
        self, query: Any, max_distance: float | Float64[np.ndarray, " n"]
    ) -> dict[int, tuple[float, Array]]:
        """Return distance and nearest points of pairs at most `max_distance` apart [m].

        Distances of boxes that overlap are negative, or zero if they touch; their points are
        undefined.

        Args:
            query: Drake's query object, at the model's present state.
            max_distance: Largest distance [m], one for all pairs or one a pair.
        """
        if not self.ids:
            return {}
        poses = np.array([query.GetPoseInWorld(i).GetAsMatrix4() for i in self.boxes])
        a, b = self.rows.T
        found = boxes_within(self.halves[a], poses[a], self.halves[b], poses[b], max_distance)
        return {row: (distance, points) for row, distance, points in found}


def boxes_within(
    halves_a: Float64[np.ndarray, "n 3"],
    poses_a: Float64[np.ndarray, "n 4 4"],
    halves_b: Float64[np.ndarray, "n 3"],
    poses_b: Float64[np.ndarray, "n 4 4"],
    max_distance: float | Float64[np.ndarray, " n"],
) -> Iterator[tuple[int, float, Float64[np.ndarray, "2 3"]]]:
    """Yield row, distance and nearest points of pairs of boxes that are near, as `within` has them.

    Args:
        halves_a: Half sizes [m].
        poses_a: X_WA.
        halves_b: Half sizes [m].
        poses_b: X_WB.
        max_distance: Largest distance [m], one for all pairs or one a pair.
    """
    boxes = halves_a, poses_a, halves_b, poses_b
    gaps = np.maximum(_ball_gaps(*boxes), _ball_gaps(halves_b, poses_b, halves_a, poses_a))
    near = np.flatnonzero(gaps <= max_distance)
    if len(near) == 0:
        return
    distances, points = _signed_distances(*(table[near] for table in boxes))
    largest = np.broadcast_to(max_distance, len(gaps))[near]
    for i in np.flatnonzero(distances <= largest):
        yield int(near[i]), float(distances[i]), points[i]


def _ball_gaps(halves_a: Array, poses_a: Array, halves_b: Array, poses_b: Array) -> Array:
    """Return lower bounds on the distances of boxes b from the balls around boxes a [m]."""
    offsets = poses_a[:, :3, 3] - poses_b[:, :3, 3]
    local = np.einsum("nji,nj->ni", poses_b[:, :3, :3], offsets)
    excess = np.maximum(np.abs(local) - halves_b, 0.0)
    return np.linalg.norm(excess, axis=1) - np.linalg.norm(halves_a, axis=1)


def _signed_distances(
    halves_a: Float64[np.ndarray, "n 3"],
    poses_a: Float64[np.ndarray, "n 4 4"],
    halves_b: Float64[np.ndarray, "n 3"],
    poses_b: Float64[np.ndarray, "n 4 4"],
) -> tuple[Float64[np.ndarray, " n"], Float64[np.ndarray, "n 2 3"]]:
    """Return distances of boxes and their nearest points; of boxes that overlap as `within` says.

    Args:
        halves_a: Half sizes [m].
        poses_a: X_WA.
        halves_b: Half sizes [m].
        poses_b: X_WB.
    """
    distances, points = box_distances(halves_a, poses_a, halves_b, poses_b)
    gaps = box_gaps(halves_a, poses_a, halves_b, poses_b)
    return np.where(gaps <= 0, gaps, distances), points


_cache: WeakKeyDictionary[RobotDiagram, BoxPairs] = WeakKeyDictionary()


def box_pairs_of(model: DrakeModel) -> BoxPairs:
    """Return the model's pairs of boxes, cached by model."""
    pairs = _cache.get(model.diagram)
    if pairs is None:
        pairs = _cache[model.diagram] = _pairs(model)
    return pairs


def _pairs(model: DrakeModel) -> BoxPairs:
    inspector: Any = model.scene_graph.model_inspector()
    geometries = inspector.GetAllGeometryIds(Role.kProximity)
    box_ids = {i for i in geometries if isinstance(inspector.GetShape(i), Box)}
    pairs: list[tuple[GeometryId, GeometryId]] = [
        (a, b) for a, b in collision_pairs_of(model).drake_pairs if a in box_ids and b in box_ids
    ]
    boxes = sorted({i for pair in pairs for i in pair})
    row_of = {i: k for k, i in enumerate(boxes)}
    halves = [inspector.GetShape(i).size() / 2 for i in boxes]
    return BoxPairs(
        ids=tuple(pairs),
        bodies=tuple((_body(model, a), _body(model, b)) for a, b in pairs),
        boxes=tuple(boxes),
        rows=np.array([[row_of[a], row_of[b]] for a, b in pairs], dtype=np.intp).reshape(-1, 2),
        halves=np.array(halves, dtype=np.float64).reshape(-1, 3),
        row_by_ids={both: i for i, (a, b) in enumerate(pairs) for both in ((a, b), (b, a))},
    )


def _body(model: DrakeModel, geometry: GeometryId) -> str:
    inspector = model.scene_graph.model_inspector()
    body = model.plant.GetBodyFromFrameId(inspector.GetFrameId(geometry))
    return model.body_names.get(body.index(), body.name())
