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

from planning.certify.clearance.candidate_pairs import geometry_of
from planning.certify.clearance.clearance_result import WitnessPoint
from planning.certify.clearance.collision_shapes import CollisionShapes
from planning.certify.request import CertifyRequest
from planning.domain.arrays import Array
from planning.kernel.gjk import nearest_point
from planning.world.collision.distance_rounding import TrueLengths
from planning.world.collision.drake_distance import distance_of
from planning.world.collision.near_static import NearStatic
from planning.world.contexts import shared_context
from planning.world.drake_model import DrakeModel

type Ids = tuple[GeometryId, GeometryId]
type Placed = tuple[int, Array, Array]

# Drake's distance is discarded if it is above the proof's by more than this [m].
_DOUBT = 1e-6
# Largest number of shape pairs of two bodies that are measured again.
_FEW = 24
# Rounding difference between two ways to measure a distance [m].
_ROUNDING = 1e-9


def nearest_points(
    model: DrakeModel,
    request: CertifyRequest,
    spot: WitnessPoint,
) -> tuple[Float64[np.ndarray, "k 3"], float]:
    """Return the nearest points of two bodies, p_WA and p_WB [m], and their distance [m].

    For overlapping bodies they are the points of the deepest pair of shapes. The distance is at
    most that of the spot: the proof need not measure all shapes of both.

    Args:
        model: The scene.
        request: The group, its motion, and the state of all other joints.
        spot: Pair of shapes, instant and distance from the proof; without shapes there are no
            points.
    """
    if not spot.shapes:
        return np.zeros((0, 3)), spot.distance
    near = _near(model, request, spot.time)
    pairs = _pairs_of_both(model, spot)
    near.show_ids(pairs)
    inspector = near.query.inspector()
    shapes = near.drake_ids(pairs[0])
    flat = [isinstance(inspector.GetShape(i), HalfSpace) for i in shapes]
    if any(flat):
        return _above(model, near, shapes, flat), spot.distance
    nearest, distance = distance_of(near.query, *shapes), spot.distance
    for ids in pairs[1:] if distance > 0 else ():
        found = distance_of(near.query, *near.drake_ids(ids))
        if found.distance < distance - _ROUNDING:
            nearest, distance = found, min(distance, TrueLengths(model).of(found, near.query))
    return _ends(model, near, nearest, distance, shapes[0]), distance


def _pairs_of_both(model: DrakeModel, spot: WitnessPoint) -> list[Ids]:
    """Return the pair of a witness point and, if few, the other shape pairs of the two bodies."""
    first = spot.shapes[0], spot.shapes[1]
    a, b = (_shapes_of_body(model, i) for i in first)
    others = list(product(a, b))
    return [first, *(pair for pair in others if pair != first and len(others) <= _FEW)]


def _shapes_of_body(model: DrakeModel, geometry: GeometryId) -> list[GeometryId]:
    """Return the collision shapes of a geometry's body, without half spaces."""
    if geometry in model.standing.row_of:
        return [geometry]
    inspector = model.scene_graph.model_inspector()
    body = model.plant.GetBodyFromFrameId(inspector.GetFrameId(geometry))
    shapes = model.plant.GetCollisionGeometriesForBody(body)
    return [i for i in shapes if not isinstance(inspector.GetShape(i), HalfSpace)]


def _ends(
    model: DrakeModel, near: NearStatic, found: Any, distance: float, first: GeometryId
) -> Array:
    """Return the nearest points of a pair: Drake's if its distance is accurate, else our own."""
    if found.distance > max(distance, 0.0) + _DOUBT:
        ids = (found.id_A, found.id_B)
        points = _searched(model, near, ids)
    else:
        query = near.query
        p_wa = query.GetPoseInWorld(found.id_A).multiply(found.p_ACa)
        p_wb = query.GetPoseInWorld(found.id_B).multiply(found.p_BCb)
        points = np.array([p_wa, p_wb])
    frame_of = near.query.inspector().GetFrameId
    return points if frame_of(found.id_A) == frame_of(first) else points[::-1]


def _near(model: DrakeModel, request: CertifyRequest, time: float) -> NearStatic:
    """Return a Drake context with the group at an instant of the motion."""
    near = NearStatic(model, None if len(model.standing) else shared_context(model))
    q = request.trajectory.positions(np.array([time]))[0]
    near.go_to(model.embed(request.group, q, request.state))
    return near


def _placed(shapes: CollisionShapes, near: NearStatic, geometry: GeometryId) -> Placed:
    """Return a shape's row, R_WG and p_WG [m]."""
    pose = near.query.GetPoseInWorld(geometry)
    (own, _) = near.own_ids((geometry, geometry))
    return shapes.rows[own], pose.rotation().matrix(), pose.translation()


def _above(
    model: DrakeModel, near: NearStatic, ids: tuple[GeometryId, ...], flat: list[bool]
) -> Array:
    """Return the lowest point of a shape above a half space, and its projection onto the plane.

    Drake has no nearest points for half spaces. Two half spaces have none at all.
    """
    if all(flat):
        return np.zeros((0, 3))
    shapes = geometry_of(model).shapes
    ground, other = (_placed(shapes, near, ids[i]) for i in (flat.index(True), flat.index(False)))
    up = ground[1][:, 2]
    lowest = shapes.point(*other, -up)
    foot = lowest - up * (up @ (lowest - ground[2]))
    return np.array([foot, lowest] if flat[0] else [lowest, foot])


def _searched(model: DrakeModel, near: NearStatic, ids: tuple[GeometryId, ...]) -> Array:
    """Return the nearest points by our own GJK search."""
    shapes = geometry_of(model).shapes
    a, b = (_placed(shapes, near, i) for i in ids)
    return nearest_point(lambda n: shapes.point(*a, n), lambda n: shapes.point(*b, n), a[2] - b[2])
