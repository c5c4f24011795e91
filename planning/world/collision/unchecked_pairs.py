"""Unchecked pairs of bodies, with the reason for each."""

from itertools import combinations
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from pydrake.multibody.tree import BodyIndex

from planning.domain.geometry.unchecked_pair import UncheckedPair, UncheckedReason
from planning.world.collision.collision_pairs import collision_pairs_of
from planning.world.collision.static_objects import StaticObjects
from planning.world.drake_model import DrakeModel

_cache: WeakKeyDictionary[StaticObjects, tuple[UncheckedPair, ...]] = WeakKeyDictionary()


def unchecked_pairs(model: DrakeModel) -> tuple[UncheckedPair, ...]:
    """Return every pair of bodies with collision shapes that is filtered out, sorted.

    Objects that are fixed to the world are not checked against each other either; of these pairs,
    which grow with the square of the objects, only those with a body of a robot are listed.
    """
    found = _cache.get(model.static_objects)
    if found is None:
        pairs = [*_plant_pairs(model), *_static_pairs(model)]
        found = _cache[model.static_objects] = tuple(sorted(pairs, key=lambda pair: pair.bodies))
    return found


def copy_unchecked_pairs(before: DrakeModel, after: DrakeModel) -> None:
    """Copy the cached pairs of one model, if known, to another with objects moved."""
    if before.static_objects in _cache:
        _cache[after.static_objects] = _cache[before.static_objects]


def _plant_pairs(model: DrakeModel) -> list[UncheckedPair]:
    candidates = collision_pairs_of(model)
    bodies = np.array([int(body) for body in candidates.bodies], dtype=np.int64)
    a, b = bodies[candidates.rows].T
    count = model.plant.num_bodies()
    checked = {frozenset(divmod(pair, count)) for pair in np.unique(a * count + b).tolist()}
    shaped_bodies = sorted({
        body for body in _bodies_with_shapes(model) if BodyIndex(body) in model.body_names
    })
    clusters = _weld_clusters(model.plant, shaped_bodies)
    world = clusters[int(model.plant.world_body().index())]
    found: list[UncheckedPair] = []
    for a, b in combinations(shaped_bodies, 2):
        if frozenset((a, b)) in checked:
            continue
        both = sorted((model.body_names[BodyIndex(a)], model.body_names[BodyIndex(b)]))
        reason = model.unchecked_reasons.get(frozenset(both))
        if reason is None:
            is_fixed = clusters[a] == world and clusters[b] == world
            if is_fixed and not any("::" in name for name in both):
                continue
            reason = _weld_reason(is_welded=clusters[a] == clusters[b], is_fixed=is_fixed)
        found.append(UncheckedPair((both[0], both[1]), *reason))
    return found


def _static_pairs(model: DrakeModel) -> list[UncheckedPair]:
    """Return the pairs of a robot's body and an object outside of the plant."""
    static_objects = model.static_objects
    if not len(static_objects):
        return []
    found = [
        UncheckedPair((min(pair), max(pair)), *model.unchecked_reasons[pair])
        for pair in static_objects.allowed
        if pair in model.unchecked_reasons and len(pair) == 2
    ]
    plant = model.plant
    fixed = {int(body.index()) for body in plant.GetBodiesWeldedTo(plant.world_body())}
    names = [model.body_names[BodyIndex(body)] for body in _bodies_with_shapes(model) & fixed]
    for name in (name for name in names if "::" in name):
        reason = _weld_reason(is_welded=True, is_fixed=True)
        found += [
            UncheckedPair((min(name, other), max(name, other)), *reason)
            for other in static_objects.rows
            if frozenset((name, other)) not in model.unchecked_reasons
        ]
    return found


def _bodies_with_shapes(model: DrakeModel) -> set[int]:
    """Return the bodies of the plant that have collision shapes."""
    candidates = collision_pairs_of(model)
    return {int(body) for body in candidates.bodies[: candidates.num_drake_shapes]}


def _weld_reason(*, is_welded: bool, is_fixed: bool) -> tuple[UncheckedReason, str]:
    if is_fixed:
        return "welded_to_world", "both stand in the world"
    if is_welded:
        return "welded", "fixed joints join them, so neither moves relative to the other"
    return "allowed", "the robot's description filters them"


def _weld_clusters(plant: Any, shaped_bodies: list[int]) -> dict[int, int]:
    """Return a cluster index for every body, equal for bodies that are welded together."""
    clusters: dict[int, int] = {}
    for index in [int(plant.world_body().index()), *shaped_bodies]:
        if index not in clusters:
            for body in plant.GetBodiesWeldedTo(plant.get_body(BodyIndex(index))):
                clusters[int(body.index())] = index
    return clusters
