"""Candidate pairs: pairs of collision shapes that may collide, with their margins."""

from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np
from jaxtyping import Bool, Float64, Int
from pydrake.geometry import GeometryId

from planning.certify.clearance.collision_shapes import CollisionShapes, collision_shapes
from planning.certify.clearance.motion_bounds import MotionBounds
from planning.world.collision.collision_pairs import CollisionPairs, collision_pairs_of
from planning.world.collision.margins import PairMargins
from planning.world.collision.static_objects import StaticObjects
from planning.world.drake_model import DrakeModel

type Ids = tuple[GeometryId, GeometryId]


@dataclass(frozen=True)
class CollisionGeometry:
    """Collision geometry of a model, computed once per model; holds no reference to the model.

    Attributes:
        shapes: All collision shapes.
        candidates: Pairs of them that no filter excludes, in a fixed order.
    """

    shapes: CollisionShapes
    candidates: CollisionPairs


_geometry_cache: WeakKeyDictionary[StaticObjects, CollisionGeometry] = WeakKeyDictionary()


def geometry_of(model: DrakeModel) -> CollisionGeometry:
    """Return the model's collision geometry, cached per model.

    Raises:
        ModelInvalid: A shape of a kind that cannot be certified.
    """
    geometry = _geometry_cache.get(model.static_objects)
    if geometry is None:
        geometry = _geometry_cache[model.static_objects] = CollisionGeometry(
            collision_shapes(model), collision_pairs_of(model)
        )
    return geometry


@dataclass(frozen=True)
class CandidatePairs:
    """Pairs of collision shapes, a row each.

    Attributes:
        ids: Drake's geometry ids of both shapes.
        rows: Their rows in `CollisionShapes`, shape (n, 2).
        names: Full names of their bodies.
        margins: Required distance [m], shape (n,).
        is_moved: Whether the group moves one relative to the other, shape (n,).
        index: Row by Drake's geometry ids, in either order.
    """

    ids: tuple[Ids, ...]
    rows: Int[np.ndarray, "n 2"]
    names: tuple[tuple[str, str], ...]
    margins: Float64[np.ndarray, " n"]
    is_moved: Bool[np.ndarray, " n"]
    index: dict[Ids, int]


def candidate_pairs(
    geometry: CollisionGeometry, bounds: MotionBounds, margins: PairMargins
) -> CandidatePairs:
    """Return all candidate pairs of a model for one group and one set of margins."""
    bodies, candidates = geometry.shapes.bodies, geometry.candidates
    names, rows = candidates.pair_names, candidates.rows
    required = {pair: margins.of(*pair) for pair in set(names)}
    moved = [bounds.chains[a] != bounds.chains[b] for a, b in bodies[rows].tolist()]
    index = {pair: i for i, pair in enumerate(candidates.pairs)}
    return CandidatePairs(
        ids=candidates.pairs,
        rows=rows,
        names=names,
        margins=np.array([required[pair] for pair in names], dtype=np.float64),
        is_moved=np.array(moved, dtype=bool),
        index=index | {(b, a): i for (a, b), i in index.items()},
    )
