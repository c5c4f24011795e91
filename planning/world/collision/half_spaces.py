"""Half-space pairs: exact heights of convex shapes over half spaces, which Drake does not measure.

The distance of a convex shape from a half space is the height of its lowest point, negative below
the plane; that is exact for every shape. Two half spaces overlap without bound.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from jaxtyping import Float64
from pydrake.geometry import (
    CollisionFilterDeclaration,
    GeometryId,
    GeometrySet,
    HalfSpace,
    Role,
    SceneGraph,
)
from pydrake.planning import RobotDiagram

from planning.domain.arrays import Array
from planning.errors import ModelInvalid
from planning.kernel.shape import ConvexShape, ShapeKind
from planning.kernel.support import farthest_point
from planning.world.collision.collision_pairs import collision_pairs_of
from planning.world.drake_model import DrakeModel
from planning.world.kernel.convex_shapes import convex_shape

type Ids = tuple[GeometryId, GeometryId]


@dataclass(frozen=True)
class HalfSpacePairs:
    """Pairs of a model with a half space that may collide; holds no reference to the model.

    Attributes:
        ids: Drake's ids of both.
        bodies: Full names of their bodies.
        shapes: Both shapes of every pair.
        row_by_ids: Row by Drake's ids, in either order.
    """

    ids: tuple[Ids, ...]
    bodies: tuple[tuple[str, str], ...]
    shapes: tuple[tuple[ConvexShape, ConvexShape], ...]
    row_by_ids: dict[Ids, int]

    def within(
        self, query: Any, max_distance: float | Float64[np.ndarray, " n"]
    ) -> Iterator[tuple[int, float, Array]]:
        """Yield row, signed distance and nearest points of pairs at most `max_distance` apart [m].

        Args:
            query: Drake's query object, at the model's present state.
            max_distance: Largest distance [m], one for all pairs or one a pair.
        """
        if not self.ids:
            return
        max_distances = np.broadcast_to(max_distance, len(self.ids))
        for row, (ids, shapes) in enumerate(zip(self.ids, self.shapes, strict=True)):
            poses = [query.GetPoseInWorld(i).GetAsMatrix4() for i in ids]
            distance, points = height(shapes, (poses[0], poses[1]))
            if distance <= max_distances[row]:
                yield row, distance, points


def height(
    shapes: tuple[ConvexShape, ConvexShape], poses: tuple[Array, Array]
) -> tuple[float, Array]:
    """Return the signed distance [m] of two shapes of which one is a half space, and p_WA, p_WB.

    Two half spaces are minus infinity apart; their points are their origins.

    Args:
        shapes: A and B.
        poses: X_WA and X_WB, shape (4, 4).
    """
    a, b = (shape.kind is ShapeKind.HALF_SPACE for shape in shapes)
    if a and b:
        return -np.inf, np.array([pose[:3, 3] for pose in poses])
    half_space_pose, other_pose = (poses[0], poses[1]) if a else (poses[1], poses[0])
    normal = half_space_pose[:3, 2]
    point = farthest_point(shapes[1] if a else shapes[0], -normal @ other_pose[:3, :3])
    lowest = other_pose[:3, :3] @ point + other_pose[:3, 3]
    signed_height = float(normal @ (lowest - half_space_pose[:3, 3]))
    foot = lowest - signed_height * normal
    return signed_height, np.array([foot, lowest] if a else [lowest, foot])


_cache: WeakKeyDictionary[RobotDiagram, HalfSpacePairs] = WeakKeyDictionary()


def half_space_pairs_of(model: DrakeModel) -> HalfSpacePairs:
    """Return the model's pairs with a half space, cached by model.

    Raises:
        ModelInvalid: A shape in such a pair is of a kind that cannot be measured.
    """
    pairs = _cache.get(model.diagram)
    if pairs is None:
        pairs = _cache[model.diagram] = _pairs(model)
    return pairs


def has_half_space(inspector: Any, pair: Ids) -> bool:
    """Return whether one of two geometries is a half space."""
    return any(isinstance(inspector.GetShape(i), HalfSpace) for i in pair)


def has_moving_half_space(model: DrakeModel) -> bool:
    """Return whether a half space is fixed to a body of the model that moves."""
    plant, inspector = model.plant, model.scene_graph.model_inspector()
    fixed = {int(body.index()) for body in plant.GetBodiesWeldedTo(plant.world_body())}
    return any(
        isinstance(inspector.GetShape(geometry), HalfSpace)
        for index in model.body_names
        if int(index) not in fixed
        for geometry in plant.GetCollisionGeometriesForBody(plant.get_body(index))
    )


def resolve_convex_shape(inspector: Any, geometry: GeometryId) -> ConvexShape:
    """Return a geometry's shape as one whose height over a half space can be computed.

    Raises:
        ModelInvalid: The shape is of an unsupported kind.
    """
    shape = inspector.GetShape(geometry)
    convex = convex_shape(shape)
    if convex is None:
        message = f"the distance of a {type(shape).__name__!r} from a half space is not supported"
        raise ModelInvalid(message, {"reason": message})
    return convex


def exclude_half_spaces(scene_graph: SceneGraph, context: Any) -> None:
    """Filter half spaces from Drake's distance queries, in one scene graph context only."""
    inspector: Any = scene_graph.model_inspector()
    geometries = list(inspector.GetAllGeometryIds(Role.kProximity))
    half_spaces = [i for i in geometries if isinstance(inspector.GetShape(i), HalfSpace)]
    if half_spaces:
        declaration = CollisionFilterDeclaration()
        declaration.ExcludeBetween(GeometrySet(half_spaces), GeometrySet(geometries))
        scene_graph.collision_filter_manager(context).Apply(declaration)


def _pairs(model: DrakeModel) -> HalfSpacePairs:
    inspector: Any = model.scene_graph.model_inspector()
    geometries = inspector.GetAllGeometryIds(Role.kProximity)
    of_drake = {i for i in geometries if isinstance(inspector.GetShape(i), HalfSpace)}
    half_spaces = of_drake | set(model.half_spaces)
    pairs = collision_pairs_of(model).drake_pairs if half_spaces else []
    ids: list[Ids] = [pair for pair in pairs if not half_spaces.isdisjoint(pair)]
    return HalfSpacePairs(
        ids=tuple(ids),
        bodies=tuple((_body(model, a), _body(model, b)) for a, b in ids),
        shapes=tuple(
            (resolve_convex_shape(inspector, a), resolve_convex_shape(inspector, b)) for a, b in ids
        ),
        row_by_ids={both: i for i, (a, b) in enumerate(ids) for both in ((a, b), (b, a))},
    )


def _body(model: DrakeModel, geometry: GeometryId) -> str:
    inspector = model.scene_graph.model_inspector()
    body = model.plant.GetBodyFromFrameId(inspector.GetFrameId(geometry))
    return model.body_names.get(body.index(), body.name())
