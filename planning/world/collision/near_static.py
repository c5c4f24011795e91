"""NearStatic: a Drake context with only those static objects registered that are near the robot.

Every registered object costs Drake a millisecond and a row of its table of pairs, so only
objects whose bounding balls are within the query distance of a moving shape are registered. The
result for a pair does not depend on the other registered objects.
"""

from collections.abc import Collection, Iterator, Sequence
from functools import cached_property
from itertools import batched
from typing import Any

import numpy as np
from jaxtyping import Float64
from pydrake.geometry import Box, GeometryId
from pydrake.systems.framework import Context

from planning.domain.arrays import Array, Indices
from planning.world.collision.box_pairs import signed_box_distances
from planning.world.collision.collision_pairs import collision_pairs_of
from planning.world.collision.measured_pairs import GeometryDistance
from planning.world.contexts import make_query_context
from planning.world.drake_model import DrakeModel
from planning.world.kernel.convex_shapes import convex_shape

type Ids = tuple[GeometryId, GeometryId]

# Number of registrations after which a new context is made.
MAX_REGISTERED = 96


class NearStatic:
    """Context of a model (`make_query_context`) with its registered objects; one thread.

    Attributes:
        plant_context: The plant's part of the present context.
    """

    def __init__(self, model: DrakeModel, context: Context | None = None) -> None:
        """Make the context, with the shapes of Drake's model, or use a given one of it."""
        self._model = model
        self._registered: set[int] = set()
        self._last_gaps: tuple[bytes, tuple[Array, Array]] | None = None
        self._use_context(context or make_query_context(model))

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
        new = [row for row in rows if row not in self._registered]
        if len(self._registered) + len(new) > MAX_REGISTERED:
            full = self._model.plant.GetPositions(self.plant_context)
            self._use_context(make_query_context(self._model))
            self.set_positions(full)
            new = list(rows)
        graph: Any = self._model.scene_graph
        source = self._model.plant.get_source_id()
        context: Any = self._query_context
        for row in new:
            instance = self._model.static_objects.geometry_instance(row)
            graph.RegisterGeometry(context, source, graph.world_frame_id(), instance)
        self._registered.update(new)

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
        if not model_ids or model_ids[0] not in self._moving:
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
            i in self._boxes
            if row is None
            else isinstance(self._model.static_objects.drake_shapes[row], Box)
            for i, row in zip(ids, rows, strict=True)
        )

    def boxes_within(self, rows: Sequence[int], max_distance: float) -> Iterator[GeometryDistance]:
        """Yield pairs of boxes at most `max_distance` apart [m], one an object of these rows."""
        static_objects = self._model.static_objects
        boxes = [row for row in rows if isinstance(static_objects.drake_shapes[row], Box)]
        own = list(self._boxes)
        if not boxes or not own:
            return
        query = self.query
        poses = np.array([query.GetPoseInWorld(i).GetAsMatrix4() for i in own])
        halves = np.array([self._boxes[i] for i in own])
        for row in boxes:
            x = np.broadcast_to(static_objects.poses[row].GetAsMatrix4(), poses.shape)
            half = np.broadcast_to(static_objects.shapes[row].size, halves.shape)
            lengths, points = signed_box_distances(halves, poses, half, x)
            for k in np.flatnonzero(lengths <= max_distance).tolist():
                ids = own[k], static_objects.geometry_instance(row).id()
                names = self.bodies(ids)
                if names is not None:
                    yield GeometryDistance(ids, names, float(lengths[k]), points[k])

    def nearest_upper_bound(self) -> float:
        """Return an upper bound on the distance to the nearest object [m]; infinite if none."""
        if not len(self._model.static_objects) or not self._moving:
            return float("inf")
        gaps, sizes = self._ball_gaps()
        return float((gaps + sizes).min())

    def are_farther_than(self, rows: Collection[int], distance: float) -> bool:
        """Return whether objects surely are farther than `distance` [m] from all moving shapes."""
        if not rows or not self._moving:
            return True
        return bool((self._ball_gaps()[0][:, list(rows)] > distance).all())

    def _rows_within(self, max_distance: float) -> Indices:
        if not len(self._model.static_objects) or not self._moving:
            return np.zeros(0, dtype=np.intp)
        return np.flatnonzero(self._ball_gaps()[0].min(axis=0) <= max_distance)

    def _ball_gaps(self) -> tuple[Array, Array]:
        """Return gaps of bounding balls, moving shapes by objects, and twice sums of radii [m]."""
        positions = self._model.plant.GetPositions(self.plant_context).tobytes()
        if self._last_gaps is None or self._last_gaps[0] != positions:
            self._last_gaps = positions, self._compute_ball_gaps()
        return self._last_gaps[1]

    def _compute_ball_gaps(self) -> tuple[Array, Array]:
        query = self.query
        own_centers, own_radii = self._balls
        poses = np.array([query.GetPoseInWorld(i).GetAsMatrix4() for i in self._moving])
        moving_centers = np.einsum("nij,nj->ni", poses[:, :3, :3], own_centers) + poses[:, :3, 3]
        static_centers, radii = self._model.static_objects.balls
        squares = np.zeros((len(moving_centers), len(static_centers)))
        for axis in range(3):  # one after the other: a table of all three is slow to go through
            squares += (moving_centers[:, None, axis] - static_centers[None, :, axis]) ** 2
        radius_sums = own_radii[:, None] + radii[None]
        return np.sqrt(squares) - radius_sums, 2 * radius_sums

    def _use_context(self, context: Context) -> None:
        model = self._model
        self._registered.clear()
        self._context = context
        self.plant_context = model.plant.GetMyMutableContextFromRoot(context)
        self._query_context = model.scene_graph.GetMyMutableContextFromRoot(context)

    @cached_property
    def _names(self) -> dict[GeometryId, str]:
        return collision_pairs_of(self._model).name_of

    @cached_property
    def _moving(self) -> dict[GeometryId, None]:
        """Shapes of the model that can collide with static objects, in order."""
        return dict.fromkeys(collision_pairs_of(self._model).moving)

    @cached_property
    def _boxes(self) -> dict[GeometryId, Array]:
        """Half sizes of the boxes among `_moving` [m]."""
        inspector = self._model.scene_graph.model_inspector()
        shapes = {i: inspector.GetShape(i) for i in self._moving}
        return {i: s.size() / 2 for i, s in shapes.items() if isinstance(s, Box)}

    @cached_property
    def _balls(self) -> tuple[Array, Array]:
        inspector = self._model.scene_graph.model_inspector()
        centers, radii = [], []
        for geometry in self._moving:
            shape = convex_shape(inspector.GetShape(geometry))
            assert shape is not None  # noqa: S101  (else no object is outside of the model)
            center, radius = shape.ball
            centers.append(center)
            radii.append(radius)
        return np.array(centers).reshape(-1, 3), np.array(radii)
