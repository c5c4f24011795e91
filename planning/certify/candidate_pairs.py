"""Pairs of collision shapes that may collide, and what is demanded of each."""

from dataclasses import dataclass
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from jaxtyping import Bool, Float64, Int
from pydrake.geometry import GeometryId
from pydrake.multibody.tree import BodyIndex
from pydrake.planning import RobotDiagram

from planning.certify.collision_shapes import CollisionShapes, collision_shapes
from planning.certify.motion_bounds import MotionBounds
from planning.world.drake_model import DrakeModel
from planning.world.margins import PairMargins

type Ids = tuple[GeometryId, GeometryId]


@dataclass(frozen=True)
class Geometry:
    """What is read of a model once; holds no reference to it.

    Attributes:
        shapes: All collision shapes.
        candidates: Pairs that no filter excludes, in a fixed order.
    """

    shapes: CollisionShapes
    candidates: tuple[Ids, ...]


_read: WeakKeyDictionary[RobotDiagram, Geometry] = WeakKeyDictionary()


def geometry_of(model: DrakeModel) -> Geometry:
    """Return the model's collision geometry, reading it the first time only.

    Raises:
        ModelInvalid: A shape of a kind that cannot be certified.
    """
    found = _read.get(model.diagram)
    if found is None:
        candidates: list[Ids] = sorted(model.scene_graph.model_inspector().GetCollisionCandidates())
        found = _read[model.diagram] = Geometry(collision_shapes(model), tuple(candidates))
    return found


@dataclass(frozen=True)
class CandidatePairs:
    """Pairs of shapes, a row each.

    Attributes:
        ids: Drake's names of both shapes.
        rows: Their rows in `CollisionShapes`, shape (n, 2).
        names: Full names of their bodies.
        margins: The distance demanded [m], shape (n,).
        is_moved: Whether the group moves one relative to the other, shape (n,).
        index: Row by Drake's names, in either order.
    """

    ids: tuple[Ids, ...]
    rows: Int[np.ndarray, "n 2"]
    names: tuple[tuple[str, str], ...]
    margins: Float64[np.ndarray, " n"]
    is_moved: Bool[np.ndarray, " n"]
    index: dict[Ids, int]


def candidate_pairs(
    model: DrakeModel, geometry: Geometry, bounds: MotionBounds, margins: PairMargins
) -> CandidatePairs:
    """Return all pairs of a model, with what one group and one set of margins make of them."""
    row_of, bodies = geometry.shapes.rows, geometry.shapes.bodies
    ids = geometry.candidates
    rows = np.array([[row_of[a], row_of[b]] for a, b in ids], dtype=np.intp).reshape(-1, 2)
    body_names = _body_names(model)
    names = tuple((body_names[int(a)], body_names[int(b)]) for a, b in bodies[rows])
    demanded = {pair: margins.of(*pair) for pair in set(names)}
    moved = [bounds.chains[int(a)] != bounds.chains[int(b)] for a, b in bodies[rows]]
    index = {pair: i for i, pair in enumerate(ids)}
    return CandidatePairs(
        ids=ids,
        rows=rows,
        names=names,
        margins=np.array([demanded[pair] for pair in names], dtype=np.float64),
        is_moved=np.array(moved, dtype=bool),
        index=index | {(b, a): i for (a, b), i in index.items()},
    )


def _body_names(model: DrakeModel) -> dict[int, str]:
    bodies: list[Any] = [
        model.plant.get_body(BodyIndex(i)) for i in range(model.plant.num_bodies())
    ]
    return {int(b.index()): model.body_names.get(b.index(), b.name()) for b in bodies}
