"""MovingShapes: shapes of Drake's model that can collide with objects outside of it."""

from dataclasses import dataclass
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from jaxtyping import Float64
from pydrake.geometry import Box, GeometryId, Role

from planning.world.collision.collision_pairs import CollisionPairs, collision_pairs_of
from planning.world.drake_model import DrakeModel
from planning.world.kernel.convex_shapes import convex_shape


@dataclass(frozen=True, eq=False)
class MovingShapes:
    """Table of shapes; refers to no model.

    Attributes:
        rows: Row of each by Drake's id, in order.
        others: Ids of the model's shapes that are none of them.
        centers: Of their bounding balls, in their own frames [m].
        radii: Of these balls [m].
        boxes: Rows of those that are boxes.
        half_sizes: Half of their sides [m].
    """

    rows: dict[GeometryId, int]
    others: tuple[GeometryId, ...]
    centers: Float64[np.ndarray, "n 3"]
    radii: Float64[np.ndarray, " n"]
    boxes: tuple[int, ...]
    half_sizes: Float64[np.ndarray, "b 3"]


_cache: WeakKeyDictionary[CollisionPairs, MovingShapes] = WeakKeyDictionary()


def moving_shapes_of(model: DrakeModel) -> MovingShapes:
    """Return the moving shapes of a model, cached by its pairs: where objects are does not matter.

    Raises:
        SceneInvalid: Too many objects meet too many shapes.
    """
    pairs = collision_pairs_of(model)
    found = _cache.get(pairs)
    if found is None:
        found = _cache[pairs] = _moving_shapes(model, pairs)
    return found


def _moving_shapes(model: DrakeModel, pairs: CollisionPairs) -> MovingShapes:
    inspector: Any = model.scene_graph.model_inspector()
    rows = {identifier: row for row, identifier in enumerate(pairs.moving)}
    shapes = [inspector.GetShape(i) for i in rows]
    convex_shapes = [convex for shape in shapes if (convex := convex_shape(shape)) is not None]
    assert len(convex_shapes) == len(shapes)  # noqa: S101  (else no object is outside of the model)
    boxes = tuple(row for row, shape in enumerate(shapes) if isinstance(shape, Box))
    return MovingShapes(
        rows=rows,
        others=tuple(i for i in inspector.GetAllGeometryIds(Role.kProximity) if i not in rows),
        centers=np.array([convex.ball[0] for convex in convex_shapes]).reshape(-1, 3),
        radii=np.array([convex.ball[1] for convex in convex_shapes]),
        boxes=boxes,
        half_sizes=np.array([shapes[row].size() / 2 for row in boxes]).reshape(-1, 3),
    )
