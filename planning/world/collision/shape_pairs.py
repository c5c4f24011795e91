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
MOST_PAIRS = 3_000_000

type Ids = tuple[GeometryId, GeometryId]


@dataclass(frozen=True)
class Candidates:
    """Unfiltered pairs of collision shapes, in a fixed order; holds no reference to the model.

    Attributes:
        ids: All collision shapes, Drake's first, in the order in which they were made.
        bodies: Index of the body of each; objects outside of the plant have the world's.
        names: Full name of the body of each.
        rows: Both shapes of every pair, as rows of `ids`, shape (n, 2), sorted.
        num_of_drake: Number of `ids` in Drake's model.
    """

    ids: tuple[GeometryId, ...]
    bodies: tuple[BodyIndex, ...]
    names: tuple[str, ...]
    rows: Int[np.ndarray, "n 2"]
    num_of_drake: int

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
        first = self.rows[self.rows[:, 1] >= self.num_of_drake, 0]
        is_moving = np.zeros(len(self.ids), dtype=bool)
        is_moving[first] = True
        return tuple(self.ids[row] for row in np.flatnonzero(is_moving).tolist())

    @cached_property
    def name_of(self) -> dict[GeometryId, str]:
        """The full name of the body of each shape."""
        return dict(zip(self.ids, self.names, strict=True))

    @property
    def pairs_of_drake(self) -> list[Ids]:
        """Pairs with both shapes in Drake's model."""
        rows = self.rows[(self.rows < self.num_of_drake).all(axis=1)]
        return [(self.ids[a], self.ids[b]) for a, b in rows.tolist()]


_found: WeakKeyDictionary[StaticObjects, Candidates] = WeakKeyDictionary()


def candidates_of(model: DrakeModel) -> Candidates:
    """Return the pairs of a model, cached by model.

    Raises:
        SceneInvalid: Too many objects meet too many shapes.
    """
    found = _found.get(model.standing)
    if found is None:
        found = _found[model.standing] = _candidates(model)
    return found


def share_candidates(before: DrakeModel, after: DrakeModel) -> None:
    """Copy the cached pairs of one model to another whose objects have moved."""
    _found[after.standing] = candidates_of(before)


def _candidates(model: DrakeModel) -> Candidates:
    inspector: Any = model.scene_graph.model_inspector()
    plant, standing = model.plant, model.standing
    ids: list[GeometryId] = sorted(inspector.GetAllGeometryIds(Role.kProximity))
    bodies = [plant.GetBodyFromFrameId(inspector.GetFrameId(i)).index() for i in ids]
    names = [model.body_names.get(i, plant.get_body(i).name()) for i in bodies]
    # One by one: Drake's own list of pairs takes twenty times as long to convert.
    is_filtered = inspector.CollisionFiltered
    of_drake = [
        (i, k)
        for i, a in enumerate(ids)
        for k, b in enumerate(ids[i + 1 :], i + 1)
        if not is_filtered(a, b)
    ]
    rows = [np.array(of_drake, dtype=np.intp).reshape(-1, 2)]
    if len(standing):
        rows.append(_with_standing(model, bodies, names))
    together = np.concatenate(rows)
    return Candidates(
        ids=(*ids, *standing.ids),
        bodies=(*bodies, *[plant.world_body().index()] * len(standing)),
        names=(*names, *(thing.name for thing in standing.things)),
        rows=together[np.lexsort((together[:, 1], together[:, 0]))],
        num_of_drake=len(ids),
    )


def _with_standing(model: DrakeModel, bodies: list[BodyIndex], names: list[str]) -> Any:
    """Return the rows of pairs of a moving shape and an object outside of the plant."""
    plant, standing = model.plant, model.standing
    fixed = {int(body.index()) for body in plant.GetBodiesWeldedTo(plant.world_body())}
    moving = [row for row, body in enumerate(bodies) if int(body) not in fixed]
    first, count = len(bodies), len(standing)
    if len(moving) * count > MOST_PAIRS:
        message = f"objects: {count} of them and {len(moving)} collision shapes that move make "
        message += f"{len(moving) * count} pairs, and at most {MOST_PAIRS} are looked at"
        evidence = {"path": "objects", "count": len(moving) * count, "bound": MOST_PAIRS}
        raise SceneInvalid(message, evidence)
    is_left = np.ones((len(moving), count), dtype=bool)
    places: dict[str, list[int]] = {}
    for place, row in enumerate(moving):
        places.setdefault(names[row], []).append(place)
    for pair in standing.allowed:
        for name in pair & standing.rows.keys():
            for other in pair - {name}:
                is_left[places.get(other, []), standing.rows[name]] = False
    a, b = np.nonzero(is_left)
    return np.column_stack([np.array(moving, dtype=np.intp)[a], b + first])
