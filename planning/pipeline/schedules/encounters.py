"""Encounters in words: which bodies meet, when, and which motion is in the way of another."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from planning.domain.geometry.body_pair import BodyPair
from planning.errors import ScheduleNotFound
from planning.pipeline.schedules.blocked_delays import BlockedDelays, Encounter
from planning.pipeline.schedules.coordination_diagram import PairOfMotions
from planning.pipeline.schedules.shared_bodies import SharedPairs
from planning.world.collision.margins import PairMargins
from planning.world.world import World

# Groups and bodies of all motions, and required distances.
type Terms = tuple[Sequence[str], SharedPairs, PairMargins]

# Distances within which the nearest pair of an encounter is searched [m].
_HORIZONS = (0.05, 0.5, 1e3)


def nearest_pair(
    world: World,
    pair: PairOfMotions,
    terms: tuple[SharedPairs, PairMargins],
    encounter: Encounter,
) -> BodyPair:
    """Return the pair of bodies of both motions that misses its margin most at an encounter.

    Args:
        world: Loaded scene.
        pair: The motions.
        terms: Bodies of all motions, and required distances.
        encounter: Configurations of both groups.
    """
    shared, margins = terms
    full = world.embed(pair.group, np.concatenate([encounter.first, encounter.second]))
    probe = world.distance_probe(margins)
    both = frozenset((pair.first, pair.second))
    for horizon in _HORIZONS:
        near = [
            found
            for found in probe.pairs_within(full, max(margins.largest, 0.0) + horizon)
            if shared.motions_of(found.bodies) == both
        ]
        if near:
            return min(near, key=lambda found: found.distance - margins.of(*found.bodies))
    return BodyPair(("", ""), np.inf, np.zeros((0, 3)))


def always_meet(
    world: World,
    pair: PairOfMotions,
    terms: Terms,
    blocked: BlockedDelays,
) -> ScheduleNotFound:
    """Return the failure of two motions that meet at every relative delay.

    Args:
        world: Loaded scene.
        pair: The two motions.
        terms: Groups and bodies of all motions, and required distances.
        blocked: The relative delays at which they meet: all.
    """
    names = terms[0]
    found: list[dict[str, Any]] = []
    for waiting, second_waits in ((pair.second, True), (pair.first, False)):
        encounter = blocked.encounter_after_any(second_waits=second_waits)
        if encounter is not None:
            evidence = _as_evidence(world, pair, terms, encounter)
            found.append({"waiting": names[waiting], **evidence})
    groups = [names[pair.first], names[pair.second]]
    text = "; ".join(
        f"if {entry['waiting']} waits, {'-'.join(entry['pair'])} come as near as "
        f"{entry['distance']:.4g} m"
        for entry in found
    )
    message = f"no delay keeps the motions of {groups[0]} and {groups[1]} apart: {text}"
    return ScheduleNotFound(message, _evidence(groups, found))


def circular(
    world: World,
    pairs: Mapping[tuple[int, int], PairOfMotions],
    terms: Terms,
    blocked: Mapping[tuple[int, int], BlockedDelays],
) -> ScheduleNotFound:
    """Return the failure of motions of which each two have delays, but not all at once.

    Args:
        world: Loaded scene.
        pairs: Each two of the motions.
        terms: Groups and bodies of all motions, and required distances.
        blocked: The relative delays at which they meet.
    """
    found = [
        _as_evidence(world, pairs[key], terms, delays.encounter_at(0.0))
        for key, delays in blocked.items()
        if delays.has_any
    ]
    circle = [list(entry["times"]) for entry in found]
    message = (
        "each two of the motions have delays at which they keep apart, but no delays are right "
        f"for all of them at once: {circle} wait for each other in a circle"
    )
    return ScheduleNotFound(message, _evidence(list(terms[0]), found))


def _as_evidence(
    world: World, pair: PairOfMotions, terms: Terms, encounter: Encounter
) -> dict[str, Any]:
    """Return an encounter as evidence."""
    names, shared, margins = terms
    near = nearest_pair(world, pair, (shared, margins), encounter)
    groups = names[pair.first], names[pair.second]
    return {
        "pair": list(near.bodies),
        "distance": near.distance,
        "times": dict(zip(groups, encounter.times, strict=True)),
    }


def _evidence(groups: list[str], found: list[dict[str, Any]]) -> dict[str, Any]:
    """Return evidence; its `time` is that of the motion under way at the first encounter."""
    first = found[0]
    time = max(first["times"].values())
    return {"groups": groups, "pair": first["pair"], "time": time, "encounters": found}
