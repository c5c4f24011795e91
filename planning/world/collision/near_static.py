"""NearStatic: a Drake context with only those static objects registered that are near the robot.

Every registered object costs Drake a millisecond and a row of its table of pairs, so only
objects whose bounding balls are within the query distance of a moving shape are registered. The
result for a pair does not depend on the other registered objects.
"""

import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import batched
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from jaxtyping import Float64
from pydrake.geometry import Box, CollisionFilterDeclaration, GeometryId, GeometrySet
from pydrake.systems.framework import Context

from planning.domain.arrays import Array, Indices
from planning.world.collision.box_pairs import boxes_within
from planning.world.collision.collision_pairs import collision_pairs_of
from planning.world.collision.measured_pairs import GeometryDistance
from planning.world.collision.moving_shapes import MovingShapes, moving_shapes_of
from planning.world.collision.static_objects import StaticObjects
from planning.world.contexts import make_query_context
from planning.world.drake_model import DrakeModel
from planning.world.kernel.kernel_scene import kernel_scene_of

type Ids = tuple[GeometryId, GeometryId]

# Number of registrations after which a new context is made.
MAX_REGISTERED = 96


@dataclass(eq=False)
class _QueryContext:
    """Context of a model (`make_query_context`), and the rows that are registered in it."""

    root: Context
    rows: set[int] = field(default_factory=set)


# Of each table of objects, the context that all short queries share; refers to no model.
_shared: WeakKeyDictionary[StaticObjects, _QueryContext] = WeakKeyDictionary()


class NearStatic:
    """Context of a model with the objects that are registered in it; one thread."""

    def __init__(self, model: DrakeModel, context: Context | _QueryContext | None = None) -> None:
        """Make a context, with the shapes of Drake's model, or use a given one of it."""
        self._model = model
        self._last_gaps: tuple[bytes, tuple[Array, Array]] | None = None
        if not isinstance(context, _QueryContext):
            context = _QueryContext(context or make_query_context(model))
        self._context = context

    @classmethod
    def shared(cls, model: DrakeModel) -> "NearStatic":
        """Return the objects of a model in a context that others use too.

        Making a context takes longer than most queries. Every user sets all positions first, and
        is done before another one does.
        """
        context = _shared.get(model.static_objects)
        if context is None:
            context = _shared[model.static_objects] = _QueryContext(make_query_context(model))
        return cls(model, context)

    @property
    def plant_context(self) -> Any:
        """The plant's part of the present context."""
        return self._model.plant.GetMyMutableContextFromRoot(self._context.root)

    @property
    def _moving(self) -> MovingShapes:
        return moving_shapes_of(self._model)

    @property
    def _query_context(self) -> Any:
        return self._model.scene_graph.GetMyMutableContextFromRoot(self._context.root)

    @property
    def query(self) -> Any:
        """Drake's query object, at the configuration of `set_positions`."""
        return self._model.scene_graph.get_query_output_port().Eval(self._query_context)

    def set_positions(self, full: Float64[np.ndarray, " num_positions"]) -> None:
        """Set the model's full configuration."""
        self._model.plant.SetPositions(self.plant_context, full)

    def register_within(self, max_distance: float) -> Iterator[tuple[list[int], bool]]:
        """Register the objects that may be within `max_distance` [m] of a moving shape, in batches.

        Yields:
            Rows of `StaticObjects` registered now and not earlier in this call, and whether this is
            the first batch; at least one batch, and most often one.
        """
        rows = self._rows_within(max_distance)
        if len(rows) <= MAX_REGISTERED:
            self.register(rows.tolist())
            yield rows.tolist(), True
            return
        for i, batch in enumerate(batched(rows.tolist(), MAX_REGISTERED)):
            self.register(batch)
            yield list(batch), i == 0

    def register(self, rows: Sequence[int]) -> None:
        """Register some objects with Drake, at most 96; those already registered may stay."""
        new = [row for row in rows if row not in self._context.rows]
        if len(self._context.rows) + len(new) > MAX_REGISTERED:
            full = self._model.plant.GetPositions(self.plant_context)
            self._context.root = make_query_context(self._model)
            self._context.rows.clear()
            self.set_positions(full)
            new = list(rows)
        if not new:
            return
        graph: Any = self._model.scene_graph
        source = self._model.plant.get_source_id()
        context, world = self._query_context, graph.world_frame_id()
        instances = [self._model.static_objects.geometry_instance(row) for row in new]
        for instance in instances:
            graph.RegisterGeometry(context, source, world, instance)
        if self._moving.others:
            # Half spaces among them: Drake has no distance of these, and refuses the whole query.
            declaration = CollisionFilterDeclaration()
            added = GeometrySet([instance.id() for instance in instances])
            declaration.ExcludeBetween(added, GeometrySet(list(self._moving.others)))
            graph.collision_filter_manager(context).Apply(declaration)
        self._context.rows.update(new)

    def register_pairs(self, pairs: Sequence[Ids]) -> bool:
        """Register the objects of some pairs, by our ids; return whether they were few enough."""
        row_of = self._model.static_objects.row_of
        rows = sorted({row_of[i] for pair in pairs for i in pair if i in row_of})
        self.register(rows[:MAX_REGISTERED])
        return len(rows) <= MAX_REGISTERED

    def drake_ids(self, ids: Ids) -> Ids:
        """Return Drake's ids of a pair by ours."""
        static_objects = self._model.static_objects
        a, b = (
            static_objects.geometry_instance(static_objects.row_of[i]).id()
            if i in static_objects.row_of
            else i
            for i in ids
        )
        return a, b

    def own_ids(self, ids: Ids) -> Ids:
        """Return our ids of a pair by Drake's."""
        static_objects = self._model.static_objects
        rows = static_objects.drake_rows
        a, b = (static_objects.ids[rows[i]] if i in rows else i for i in ids)
        return a, b

    def row(self, geometry: GeometryId) -> int | None:
        """Return the row of an object by Drake's id, or None if it is a shape of the model."""
        return self._model.static_objects.drake_rows.get(geometry)

    def bodies(self, ids: Ids) -> tuple[str, str] | None:
        """Return full names of the bodies of a pair; None if the pair is not checked.

        Each geometry is a shape of the model or a registered object.
        """
        rows = [self.row(i) for i in ids]
        if rows == [None, None]:
            return self._names[ids[0]], self._names[ids[1]]
        model_ids = [i for i, row in zip(ids, rows, strict=True) if row is None]
        if not model_ids or model_ids[0] not in self._moving.rows:
            return None
        objects = self._model.static_objects.objects
        a, b = (
            self._names[i] if row is None else objects[row].name
            for i, row in zip(ids, rows, strict=True)
        )
        return None if frozenset((a, b)) in self._model.static_objects.allowed else (a, b)

    def are_boxes(self, ids: Ids) -> bool:
        """Return whether both are boxes, at least one of them a registered object."""
        rows = [self.row(i) for i in ids]
        return rows != [None, None] and all(
            self._moving.rows.get(i) in self._moving.boxes
            if row is None
            else isinstance(self._model.static_objects.drake_shapes[row], Box)
            for i, row in zip(ids, rows, strict=True)
        )

    def boxes_within(self, rows: Sequence[int], max_distance: float) -> Iterator[GeometryDistance]:
        """Yield pairs of boxes at most `max_distance` apart [m], one an object of these rows."""
        static_objects, moving = self._model.static_objects, self._moving
        boxes = [row for row in rows if isinstance(static_objects.drake_shapes[row], Box)]
        if not boxes or not moving.boxes:
            return
        ids, query = list(moving.rows), self.query
        own = [ids[row] for row in moving.boxes]
        poses = np.array([query.GetPoseInWorld(i).GetAsMatrix4() for i in own])
        static_poses = np.array([static_objects.poses[row].GetAsMatrix4() for row in boxes])
        static_halves = np.array([static_objects.shapes[row].size for row in boxes])
        second, first = np.indices((len(boxes), len(own))).reshape(2, -1)
        halves = moving.half_sizes[first], static_halves[second]
        placed = halves[0], poses[first], halves[1], static_poses[second]
        for row, distance, points in boxes_within(*placed, max_distance):
            instance = static_objects.geometry_instance(boxes[second[row]])
            pair = own[first[row]], instance.id()
            names = self.bodies(pair)
            if names is not None:
                yield GeometryDistance(pair, names, distance, points)

    def nearest_upper_bound(self) -> float:
        """Return an upper bound on the distance to the nearest object [m]; infinite if none."""
        if not len(self._model.static_objects) or not self._moving.rows:
            return float("inf")
        gaps, sizes = self._ball_gaps()
        return float((gaps + sizes).min())

    def are_farther_than(self, rows: Collection[int], distance: float) -> bool:
        """Return whether objects surely are farther than `distance` [m] from all moving shapes."""
        if not rows or not self._moving.rows:
            return True
        return bool((self._ball_gaps()[0][:, list(rows)] > distance).all())

    def _rows_within(self, max_distance: float) -> Indices:
        if not len(self._model.static_objects) or not self._moving.rows:
            return np.zeros(0, dtype=np.intp)
        scene = kernel_scene_of(self._model)
        if scene is not None and math.isfinite(max_distance):
            return scene.near_objects(
                self._model.plant.GetPositions(self.plant_context), max_distance
            )
        return np.flatnonzero(self._ball_gaps()[0].min(axis=0) <= max_distance)

    def _ball_gaps(self) -> tuple[Array, Array]:
        """Return gaps of bounding balls, moving shapes by objects, and twice sums of radii [m]."""
        positions = self._model.plant.GetPositions(self.plant_context).tobytes()
        if self._last_gaps is None or self._last_gaps[0] != positions:
            self._last_gaps = positions, self._compute_ball_gaps()
        return self._last_gaps[1]

    def _compute_ball_gaps(self) -> tuple[Array, Array]:
        query = self.query
        own = self._moving
        poses = np.array([query.GetPoseInWorld(i).GetAsMatrix4() for i in own.rows])
        moving_centers = np.einsum("nij,nj->ni", poses[:, :3, :3], own.centers) + poses[:, :3, 3]
        static_centers, radii = self._model.static_objects.balls
        squares = np.zeros((len(moving_centers), len(static_centers)))
        for axis in range(3):  # one after the other: a table of all three is slow to go through
            squares += (moving_centers[:, None, axis] - static_centers[None, :, axis]) ** 2
        radius_sums = own.radii[:, None] + radii[None]
        return np.sqrt(squares) - radius_sums, 2 * radius_sums

    @property
    def _names(self) -> dict[GeometryId, str]:
        return collision_pairs_of(self._model).name_of
