"""Nearest points of two bodies at an instant of a motion, for reports.

Drake computes them. Where Drake's distance is larger than the proof's (it overestimates distances
of separate boxes, docs/decisions/0006), our own GJK search, which bounds distances from both sides,
is used. The smallest distance reported by a proof is measured accurately here. Neither result is
part of a proof.
"""

from itertools import product
from typing import Any

import numpy as np
from jaxtyping import Float64
from pydrake.geometry import GeometryId, HalfSpace

from planning.certify.clearance.clearance_result import WitnessPoint
from planning.certify.clearance.collision_shapes import CollisionShapes, collision_shapes
from planning.certify.request import CertifyRequest
from planning.domain.arrays import Array
from planning.kernel.gjk import closest_points
from planning.world.collision.distance_lower_bounds import DistanceLowerBounds
from planning.world.collision.drake_distance import pair_distance
from planning.world.collision.near_static import NearStatic
from planning.world.drake_model import DrakeModel

type Ids = tuple[GeometryId, GeometryId]
type PlacedShape = tuple[int, Array, Array]

# Drake's distance is discarded if it is above the proof's by more than this [m].
_DISTANCE_TOLERANCE = 1e-6
# Largest number of shape pairs of two bodies that are measured again.
_MAX_SHAPE_PAIRS = 24
# Rounding difference between two ways to measure a distance [m].
_ROUNDING = 1e-9


def nearest_points(
    model: DrakeModel,
    request: CertifyRequest,
    witness: WitnessPoint,
) -> tuple[Float64[np.ndarray, "k 3"], float]:
    """Return the nearest points of two bodies, p_WA and p_WB [m], and their distance [m].

    For overlapping bodies they are the points of the deepest pair of shapes. The distance is at
    most that of the witness: the proof need not measure all shapes of both.

    Args:
        model: The scene.
        request: The group, its motion, and the state of all other joints.
        witness: Pair of shapes, instant and distance from the proof; without shapes there are no
            points.
    """
    if not witness.shapes:
        return np.zeros((0, 3)), witness.distance
    near_static = _scene_at(model, request, witness.time)
    pairs = _shape_pairs(model, witness)
    near_static.register_pairs(pairs)
    inspector = near_static.query.inspector()
    shapes = near_static.drake_ids(pairs[0])
    is_half_space = [isinstance(inspector.GetShape(i), HalfSpace) for i in shapes]
    if any(is_half_space):
        return _half_space_points(model, near_static, shapes, is_half_space), witness.distance
    nearest, distance = pair_distance(near_static.query, *shapes), witness.distance
    for ids in pairs[1:] if distance > 0 else ():
        candidate = pair_distance(near_static.query, *near_static.drake_ids(ids))
        if candidate.distance < distance - _ROUNDING:
            nearest, distance = (
                candidate,
                min(distance, DistanceLowerBounds(model).lower_bound(candidate, near_static.query)),
            )
    return _point_pair(model, near_static, nearest, distance, shapes[0]), distance


def _shape_pairs(model: DrakeModel, witness: WitnessPoint) -> list[Ids]:
    """Return the pair of a witness point and, if few, the other shape pairs of the two bodies."""
    first = witness.shapes[0], witness.shapes[1]
    a, b = (_shapes_of_body(model, i) for i in first)
    others = list(product(a, b))
    return [first, *(pair for pair in others if pair != first and len(others) <= _MAX_SHAPE_PAIRS)]


def _shapes_of_body(model: DrakeModel, geometry: GeometryId) -> list[GeometryId]:
    """Return the collision shapes of a geometry's body, without half spaces."""
    if geometry in model.static_objects.row_of:
        return [geometry]
    inspector = model.scene_graph.model_inspector()
    body = model.plant.GetBodyFromFrameId(inspector.GetFrameId(geometry))
    shapes = model.plant.GetCollisionGeometriesForBody(body)
    return [i for i in shapes if not isinstance(inspector.GetShape(i), HalfSpace)]


def _point_pair(
    model: DrakeModel,
    near_static: NearStatic,
    signed_distance: Any,
    distance: float,
    first: GeometryId,
) -> Array:
    """Return the nearest points of a pair: Drake's if its distance is accurate, else our own."""
    if signed_distance.distance > max(distance, 0.0) + _DISTANCE_TOLERANCE:
        ids = (signed_distance.id_A, signed_distance.id_B)
        points = _gjk_points(model, near_static, ids)
    else:
        query = near_static.query
        p_wa = query.GetPoseInWorld(signed_distance.id_A).multiply(signed_distance.p_ACa)
        p_wb = query.GetPoseInWorld(signed_distance.id_B).multiply(signed_distance.p_BCb)
        points = np.array([p_wa, p_wb])
    frame_of = near_static.query.inspector().GetFrameId
    return points if frame_of(signed_distance.id_A) == frame_of(first) else points[::-1]


def _scene_at(model: DrakeModel, request: CertifyRequest, time: float) -> NearStatic:
    """Return a Drake context with the group at an instant of the motion."""
    near_static = NearStatic.shared(model)
    q = request.trajectory.positions(np.array([time]))[0]
    near_static.set_positions(model.embed(request.group, q, request.state))
    return near_static


def _shape_pose(
    shapes: CollisionShapes, near_static: NearStatic, geometry: GeometryId
) -> PlacedShape:
    """Return a shape's row, R_WG and p_WG [m]."""
    pose = near_static.query.GetPoseInWorld(geometry)
    (own, _) = near_static.own_ids((geometry, geometry))
    return shapes.rows[own], pose.rotation().matrix(), pose.translation()


def _half_space_points(
    model: DrakeModel,
    near_static: NearStatic,
    ids: tuple[GeometryId, ...],
    is_half_space: list[bool],
) -> Array:
    """Return the lowest point of a shape above a half space, and its projection onto the plane.

    Drake has no nearest points for half spaces. Two half spaces have none at all.
    """
    if all(is_half_space):
        return np.zeros((0, 3))
    shapes = collision_shapes(model, near_static.own_ids((ids[0], ids[1])))
    half_space, other = (
        _shape_pose(shapes, near_static, ids[i])
        for i in (is_half_space.index(True), is_half_space.index(False))
    )
    normal = half_space[1][:, 2]
    lowest = shapes.support_point(*other, -normal)
    projection = lowest - normal * (normal @ (lowest - half_space[2]))
    return np.array([projection, lowest] if is_half_space[0] else [lowest, projection])


def _gjk_points(model: DrakeModel, near_static: NearStatic, ids: tuple[GeometryId, ...]) -> Array:
    """Return the nearest points by our own GJK search."""
    shapes = collision_shapes(model, near_static.own_ids((ids[0], ids[1])))
    a, b = (_shape_pose(shapes, near_static, i) for i in ids)
    return closest_points(
        lambda n: shapes.support_point(*a, n), lambda n: shapes.support_point(*b, n), a[2] - b[2]
    )
