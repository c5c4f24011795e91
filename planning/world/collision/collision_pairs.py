"""Collision pairs: pairs of shapes of Drake's model, and of static objects, that may collide."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from jaxtyping import Int
from pydrake.geometry import GeometryId, Role
from pydrake.multibody.tree import BodyIndex

from planning.errors import SceneInvalid
from planning.world.collision.static_objects import StaticObjects
from planning.world.drake_model import DrakeModel

# Largest number of pairs of a moving shape and a static object: a quarter of a gigabyte.
MAX_PAIRS = 3_000_000

type Ids = tuple[GeometryId, GeometryId]


@dataclass(frozen=True, eq=False)
class CollisionPairs:
    """Unfiltered pairs of collision shapes, in a fixed order; holds no reference to the model.

    Attributes:
        ids: All collision shapes, Drake's first, in the order in which they were made.
        bodies: Index of the body of each; objects outside of the plant have the world's.
        names: Full name of the body of each.
        rows: Both shapes of every pair, as rows of `ids`, shape (n, 2), sorted.
        num_drake_shapes: Number of `ids` in Drake's model.
    """

    ids: tuple[GeometryId, ...]
    bodies: tuple[BodyIndex, ...]
    names: tuple[str, ...]
    rows: Int[np.ndarray, "n 2"]
    num_drake_shapes: int

    @cached_property
    def pairs(self) -> tuple[Ids, ...]:
        """Ids of both shapes of every pair: Drake's, and ours of objects outside of the model."""
        ids = self.ids
        return tuple([(ids[a], ids[b]) for a, b in self.rows.tolist()])

    @cached_property
    def pair_names(self) -> tuple[tuple[str, str], ...]:
        """Full names of both bodies of every pair."""
        names = self.names
        return tuple([(names[a], names[b]) for a, b in self.rows.tolist()])

    @cached_property
    def moving(self) -> tuple[GeometryId, ...]:
        """Shapes of Drake's model that can collide with objects outside of it, in order."""
        first = self.rows[self.rows[:, 1] >= self.num_drake_shapes, 0]
        is_moving = np.zeros(len(self.ids), dtype=bool)
        is_moving[first] = True
        return tuple(self.ids[row] for row in np.flatnonzero(is_moving).tolist())

    @cached_property
    def name_of(self) -> dict[GeometryId, str]:
        """The full name of the body of each shape."""
        return dict(zip(self.ids, self.names, strict=True))

    @property
    def drake_pairs(self) -> list[Ids]:
        """Pairs with both shapes in Drake's model."""
        rows = self.rows[(self.rows < self.num_drake_shapes).all(axis=1)]
        return [(self.ids[a], self.ids[b]) for a, b in rows.tolist()]


_cache: WeakKeyDictionary[StaticObjects, CollisionPairs] = WeakKeyDictionary()


def collision_pairs_of(model: DrakeModel) -> CollisionPairs:
    """Return the pairs of a model, cached by model.

    Raises:
        SceneInvalid: Too many objects meet too many shapes.
    """
    candidates = _cache.get(model.static_objects)
    if candidates is None:
        candidates = _cache[model.static_objects] = _candidates(model)
    return candidates


def copy_candidates(before: DrakeModel, after: DrakeModel) -> None:
    """Copy the cached pairs of one model to another whose objects have moved."""
    _cache[after.static_objects] = collision_pairs_of(before)


def _candidates(model: DrakeModel) -> CollisionPairs:
    inspector: Any = model.scene_graph.model_inspector()
    plant, static_objects = model.plant, model.static_objects
    ids: list[GeometryId] = sorted([
        *inspector.GetAllGeometryIds(Role.kProximity),
        *model.half_spaces,
    ])
    bodies = [plant.GetBodyFromFrameId(inspector.GetFrameId(i)).index() for i in ids]
    names = [model.body_names.get(i, plant.get_body(i).name()) for i in bodies]
    # One by one: Drake's own list of pairs takes twenty times as long to convert.
    is_filtered = inspector.CollisionFiltered
    drake_ids = [(row, i) for row, i in enumerate(ids) if i not in model.half_spaces]
    drake_rows = [
        (row, other)
        for k, (row, a) in enumerate(drake_ids)
        for other, b in drake_ids[k + 1 :]
        if not is_filtered(a, b)
    ]
    drake_rows += _half_space_pairs(model, ids, bodies, names)
    rows = [np.array(drake_rows, dtype=np.intp).reshape(-1, 2)]
    if len(static_objects):
        rows.append(_static_pairs(model, bodies, names))
    all_rows = np.concatenate(rows)
    return CollisionPairs(
        ids=(*ids, *static_objects.ids),
        bodies=(*bodies, *[plant.world_body().index()] * len(static_objects)),
        names=(*names, *(thing.name for thing in static_objects.objects)),
        rows=all_rows[np.lexsort((all_rows[:, 1], all_rows[:, 0]))],
        num_drake_shapes=len(ids),
    )


def _half_space_pairs(
    model: DrakeModel, ids: list[GeometryId], bodies: list[BodyIndex], names: list[str]
) -> list[tuple[int, int]]:
    """Return the rows of pairs of a half space that is fixed to the world and a moving shape."""
    if not model.half_spaces:
        return []
    plant = model.plant
    fixed = {int(body.index()) for body in plant.GetBodiesWeldedTo(plant.world_body())}
    moving = [row for row, body in enumerate(bodies) if int(body) not in fixed]
    return [
        (min(row, other), max(row, other))
        for row, i in enumerate(ids)
        if i in model.half_spaces
        for other in moving
        if frozenset((names[row], names[other])) not in model.unchecked_reasons
    ]


def _static_pairs(model: DrakeModel, bodies: list[BodyIndex], names: list[str]) -> Any:
    """Return the rows of pairs of a moving shape and an object outside of the plant."""
    plant, static_objects = model.plant, model.static_objects
    fixed = {int(body.index()) for body in plant.GetBodiesWeldedTo(plant.world_body())}
    moving = [row for row, body in enumerate(bodies) if int(body) not in fixed]
    first, count = len(bodies), len(static_objects)
    if len(moving) * count > MAX_PAIRS:
        message = f"objects: {count} static objects and {len(moving)} moving collision shapes make "
        message += f"{len(moving) * count} collision pairs; the limit is {MAX_PAIRS}"
        evidence = {"path": "objects", "count": len(moving) * count, "bound": MAX_PAIRS}
        raise SceneInvalid(message, evidence)
    is_checked = np.ones((len(moving), count), dtype=bool)
    indices_by_name: dict[str, list[int]] = {}
    for index, row in enumerate(moving):
        indices_by_name.setdefault(names[row], []).append(index)
    for pair in static_objects.allowed:
        for name in pair & static_objects.rows.keys():
            for other in pair - {name}:
                is_checked[indices_by_name.get(other, []), static_objects.rows[name]] = False
    a, b = np.nonzero(is_checked)
    return np.column_stack([np.array(moving, dtype=np.intp)[a], b + first])
