"""The nearest points of two shapes at an instant of a motion: where to look, for people.

Drake finds them. Where it finds shapes farther apart than the proof did (it overstates distances of
separate boxes, docs/decisions/0006), the search that bounds distances from both sides does.
Nothing is proven by them.
"""

from typing import Any

import numpy as np
from jaxtyping import Float64
from pydrake.geometry import GeometryId, HalfSpace

from planning.certify.candidate_pairs import geometry_of
from planning.certify.collision_shapes import CollisionShapes
from planning.certify.proof_parts import Spot
from planning.certify.request import CertifyRequest
from planning.kernel.separation import nearest_point
from planning.world.contexts import shared_context
from planning.world.drake_distance import distance_of
from planning.world.drake_model import DrakeModel
from planning.world.near_standing import NearStanding

type Array = np.ndarray[Any, np.dtype[np.float64]]
type Placed = tuple[int, Array, Array]

# Drake's distance may be above that of the proof by this before it is doubted [m].
_DOUBT = 1e-6


def nearest_points(
    model: DrakeModel,
    request: CertifyRequest,
    spot: Spot,
) -> Float64[np.ndarray, "k 3"]:
    """Return p_WA and p_WB [m] of two shapes, the deepest ones if they overlap.

    Args:
        model: The scene.
        request: Has the group, its motion, and where all else is.
        spot: Which shapes and when, and what the proof measured then; no points if there are none.
    """
    if not spot.shapes:
        return np.zeros((0, 3))
    near = _near(model, request, spot.time)
    pair = spot.shapes[0], spot.shapes[1]
    near.show_ids([pair])
    query, inspector = near.query, near.query.inspector()
    a, b = shapes = near.drake_ids(pair)
    flat = [isinstance(inspector.GetShape(i), HalfSpace) for i in shapes]
    if any(flat):
        return _above(model, near, shapes, flat)
    found = distance_of(query, a, b)
    if found.distance > max(spot.distance, 0.0) + _DOUBT:
        return _searched(model, near, shapes)
    points = [
        query.GetPoseInWorld(found.id_A).multiply(found.p_ACa),
        query.GetPoseInWorld(found.id_B).multiply(found.p_BCb),
    ]
    return np.array(points if found.id_A == a else points[::-1])


def _near(model: DrakeModel, request: CertifyRequest, time: float) -> NearStanding:
    """Return a context of Drake's with the motion at an instant."""
    near = NearStanding(model, None if len(model.standing) else shared_context(model))
    q = request.trajectory.positions(np.array([time]))[0]
    near.go_to(model.embed(request.group, q, request.state))
    return near


def _placed(shapes: CollisionShapes, near: NearStanding, geometry: GeometryId) -> Placed:
    """Return a shape's row, R_WG and p_WG [m]."""
    pose = near.query.GetPoseInWorld(geometry)
    (own, _) = near.own_ids((geometry, geometry))
    return shapes.rows[own], pose.rotation().matrix(), pose.translation()


def _above(
    model: DrakeModel, near: NearStanding, ids: tuple[GeometryId, ...], flat: list[bool]
) -> Array:
    """Return the lowest point of a shape over a half space, which Drake does not find, and below.

    Two half spaces have no nearest points.
    """
    if all(flat):
        return np.zeros((0, 3))
    shapes = geometry_of(model).shapes
    ground, other = (_placed(shapes, near, ids[i]) for i in (flat.index(True), flat.index(False)))
    up = ground[1][:, 2]
    lowest = shapes.point(*other, -up)
    foot = lowest - up * (up @ (lowest - ground[2]))
    return np.array([foot, lowest] if flat[0] else [lowest, foot])


def _searched(model: DrakeModel, near: NearStanding, ids: tuple[GeometryId, ...]) -> Array:
    """Return the points by our own search."""
    shapes = geometry_of(model).shapes
    a, b = (_placed(shapes, near, i) for i in ids)
    return nearest_point(lambda n: shapes.point(*a, n), lambda n: shapes.point(*b, n), a[2] - b[2])
