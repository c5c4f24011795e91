"""Which pairs of bodies are not held against each other, with the reason for each."""

from collections.abc import Mapping
from itertools import combinations
from typing import Any

from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex

from planning.domain.unchecked_pair import UncheckedPair, UncheckedReason

type Reasons = Mapping[frozenset[str], tuple[UncheckedReason, str]]


def unchecked_pairs(
    plant: MultibodyPlant, scene_graph: Any, names: Mapping[BodyIndex, str], reasons: Reasons
) -> tuple[UncheckedPair, ...]:
    """Return every pair of bodies with collision shapes that is filtered out, sorted.

    Objects that stand in the world are not held against each other either; of these pairs, which
    grow with the square of the objects, only those with a body of a robot are listed.

    Args:
        plant: Finalized.
        scene_graph: With all filters applied.
        names: Full names of all bodies.
        reasons: Why pairs were filtered, by both names, where that is known already.
    """
    inspector = scene_graph.model_inspector()
    candidates = {
        frozenset(int(plant.GetBodyFromFrameId(inspector.GetFrameId(i)).index()) for i in pair)
        for pair in inspector.GetCollisionCandidates()
    }
    shaped = sorted(
        int(index) for index in names if plant.GetCollisionGeometriesForBody(plant.get_body(index))
    )
    clusters = _clusters(plant, shaped)
    world = clusters[int(plant.world_body().index())]
    found: list[UncheckedPair] = []
    for a, b in combinations(shaped, 2):
        if frozenset((a, b)) in candidates:
            continue
        both = sorted((names[BodyIndex(a)], names[BodyIndex(b)]))
        known = reasons.get(frozenset(both))
        if known is None:
            is_fixed = clusters[a] == world and clusters[b] == world
            if is_fixed and not any("::" in name for name in both):
                continue
            known = _of_welds(clusters[a] == clusters[b], is_fixed)
        found.append(UncheckedPair((both[0], both[1]), *known))
    return tuple(sorted(found, key=lambda pair: pair.bodies))


def _of_welds(is_welded: bool, is_fixed: bool) -> tuple[UncheckedReason, str]:  # noqa: FBT001
    if is_fixed:
        return "welded_to_world", "both stand in the world"
    if is_welded:
        return "welded", "fixed joints join them, so neither moves relative to the other"
    return "allowed", "the robot's description filters them"


def _clusters(plant: MultibodyPlant, shaped: list[int]) -> dict[int, int]:
    """Return a number for every body, equal for bodies that are welded together."""
    found: dict[int, int] = {}
    for index in [int(plant.world_body().index()), *shaped]:
        if index not in found:
            for body in plant.GetBodiesWeldedTo(plant.get_body(BodyIndex(index))):
                found[int(body.index())] = index
    return found
