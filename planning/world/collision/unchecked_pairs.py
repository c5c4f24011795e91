"""Unchecked pairs of bodies, with the reason for each."""

from itertools import combinations
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from pydrake.multibody.tree import BodyIndex

from planning.domain.geometry.unchecked_pair import UncheckedPair, UncheckedReason
from planning.world.collision.shape_pairs import candidates_of
from planning.world.collision.static_objects import StaticObjects
from planning.world.drake_model import DrakeModel

_found: WeakKeyDictionary[StaticObjects, tuple[UncheckedPair, ...]] = WeakKeyDictionary()


def unchecked_pairs(model: DrakeModel) -> tuple[UncheckedPair, ...]:
    """Return every pair of bodies with collision shapes that is filtered out, sorted.

    Objects that stand in the world are not checked against each other either; of these pairs, which
    grow with the square of the objects, only those with a body of a robot are listed.
    """
    found = _found.get(model.standing)
    if found is None:
        pairs = [*_of_plant(model), *_of_standing(model)]
        found = _found[model.standing] = tuple(sorted(pairs, key=lambda pair: pair.bodies))
    return found


def share_unchecked(before: DrakeModel, after: DrakeModel) -> None:
    """Copy the cached pairs of one model, if known, to another with objects moved."""
    if before.standing in _found:
        _found[after.standing] = _found[before.standing]


def _of_plant(model: DrakeModel) -> list[UncheckedPair]:
    candidates = candidates_of(model)
    bodies = np.array([int(body) for body in candidates.bodies], dtype=np.int64)
    a, b = bodies[candidates.rows].T
    count = model.plant.num_bodies()
    looked_at = {frozenset(divmod(pair, count)) for pair in np.unique(a * count + b).tolist()}
    shaped = sorted({body for body in _shaped(model) if BodyIndex(body) in model.body_names})
    clusters = _clusters(model.plant, shaped)
    world = clusters[int(model.plant.world_body().index())]
    found: list[UncheckedPair] = []
    for a, b in combinations(shaped, 2):
        if frozenset((a, b)) in looked_at:
            continue
        both = sorted((model.body_names[BodyIndex(a)], model.body_names[BodyIndex(b)]))
        known = model.reasons.get(frozenset(both))
        if known is None:
            is_fixed = clusters[a] == world and clusters[b] == world
            if is_fixed and not any("::" in name for name in both):
                continue
            known = _of_welds(is_welded=clusters[a] == clusters[b], is_fixed=is_fixed)
        found.append(UncheckedPair((both[0], both[1]), *known))
    return found


def _of_standing(model: DrakeModel) -> list[UncheckedPair]:
    """Return the pairs of a robot's body and an object outside of the plant."""
    standing = model.standing
    if not len(standing):
        return []
    found = [
        UncheckedPair((min(pair), max(pair)), *model.reasons[pair])
        for pair in standing.allowed
        if pair in model.reasons and len(pair) == 2
    ]
    plant = model.plant
    fixed = {int(body.index()) for body in plant.GetBodiesWeldedTo(plant.world_body())}
    names = [model.body_names[BodyIndex(body)] for body in _shaped(model) & fixed]
    for name in (name for name in names if "::" in name):
        known = _of_welds(is_welded=True, is_fixed=True)
        found += [
            UncheckedPair((min(name, other), max(name, other)), *known)
            for other in standing.rows
            if frozenset((name, other)) not in model.reasons
        ]
    return found


def _shaped(model: DrakeModel) -> set[int]:
    """Return the bodies of the plant that have collision shapes."""
    candidates = candidates_of(model)
    return {int(body) for body in candidates.bodies[: candidates.num_of_drake]}


def _of_welds(*, is_welded: bool, is_fixed: bool) -> tuple[UncheckedReason, str]:
    if is_fixed:
        return "welded_to_world", "both stand in the world"
    if is_welded:
        return "welded", "fixed joints join them, so neither moves relative to the other"
    return "allowed", "the robot's description filters them"


def _clusters(plant: Any, shaped: list[int]) -> dict[int, int]:
    """Return a cluster index for every body, equal for bodies that are welded together."""
    found: dict[int, int] = {}
    for index in [int(plant.world_body().index()), *shaped]:
        if index not in found:
            for body in plant.GetBodiesWeldedTo(plant.get_body(BodyIndex(index))):
                found[int(body.index())] = index
    return found
