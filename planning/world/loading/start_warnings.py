"""start_warnings(): collisions and limit violations at the scene's positions, with remedies."""

import json
from collections.abc import Collection
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

import numpy as np

from planning.domain.arrays import Array
from planning.domain.geometry.body_pair import BodyPair
from planning.domain.robot.joints import JointGroup, JointType
from planning.domain.value import digest
from planning.world.collision.collision_check import DistanceProbe
from planning.world.collision.margins import PairMargins
from planning.world.collision.near_static import NearStatic
from planning.world.collision.static_objects import StaticObjects
from planning.world.contexts import shared_context
from planning.world.drake_model import DrakeModel

if TYPE_CHECKING:
    from planning.world.world import World

# Slack beyond the margin at which every distance query agrees [m].
_SURELY = 1e-3


@dataclass(frozen=True)
class _Known:
    """Cached warnings of a model, or of one that it shares, for the state digest `place`.

    Attributes:
        place: Digest of the robots' positions and of the margins.
        is_free: Whether all pairs kept their margins.
        of_configurations: Warnings that do not depend on surrounding objects.
        unseen: Rows of `standing` that have moved since.
    """

    place: str
    is_free: bool
    of_configurations: tuple[str, ...]
    unseen: frozenset[int] = frozenset()


_known: WeakKeyDictionary[StaticObjects, _Known] = WeakKeyDictionary()


# Number of random configurations at which touching pairs are checked again.
_NUM_TRIED = 20
# With more groups, making a checker takes longer than measuring all distances.
_MOST_ASKED = 4
# Number of pairs with a warning each.
_MOST_TOLD = 10
# Tolerance of position limits [rad or m].
_DUST = 1e-6
# Rounding error of a zero distance [m].
_TOUCH = 1e-9
# Range of an unlimited joint: a whole turn, or a metre either way.
_UNLIMITED = {JointType.CONTINUOUS: np.pi, JointType.REVOLUTE: np.pi, JointType.PRISMATIC: 1.0}


def start_warnings(world: "World") -> tuple[str, ...]:
    """Return the faults that make every plan from the scene's positions fail.

    Pairs of links of one robot that touch in all sampled configurations come with
    an edit that allows their contact. Where nothing touches, this takes one collision check.
    """
    margins, scene = world.margins(), world.scene
    place = digest((world.state, scene.margin, scene.margins, scene.configurations))
    known = _known.get(world.drake.standing)
    known = known if known is not None and known.place == place else None
    touching: tuple[BodyPair, ...] = ()
    is_free = _is_still_free(world, known, margins) or _is_free(world, margins)
    if not is_free:
        touching = world.distance_probe(margins).violations(world.state)
    told = [_text(world, pair) for pair in touching[:_MOST_TOLD]]
    if len(touching) > _MOST_TOLD:
        told.append(f"{len(touching) - _MOST_TOLD} further pairs are too near where the scene is")
    always = _always_touching(world, touching)
    if always:
        operations = [{"op": "allow", "pair": list(pair)} for pair in always]
        told.append(
            f"{len(always)} pairs of these overlap in all of {_NUM_TRIED + 1} configurations that "
            "were tried, as shapes do that are drawn into each other; if they may touch, edit the "
            f"scene with {json.dumps({'operations': operations})}"
        )
    of_configurations = _configuration_warnings(world) if known is None else known.of_configurations
    _known[world.drake.standing] = _Known(place, is_free, of_configurations)
    return (*told, *of_configurations)


def _is_still_free(world: "World", known: _Known | None, margins: PairMargins) -> bool:
    """Return whether all pairs certainly keep their margins, by the cache and what moved."""
    if known is None or not known.is_free:
        return False
    near = NearStatic(world.drake, shared_context(world.drake))
    near.go_to(world.state)
    return near.are_beyond(known.unseen, margins.largest + _SURELY)


def _is_free(world: "World", margins: PairMargins) -> bool:
    """Return whether all pairs keep their margins; False where only the probe can decide."""
    if len(world.groups) > _MOST_ASKED:
        return False
    # With its group at the scene's positions, one checker's verdict covers all pairs.
    return all(
        world.collision_oracle(group, margins).is_free(world.positions(group))
        for group in world.groups[:1]
    )


def _text(world: "World", pair: BodyPair) -> str:
    a, b = pair.bodies
    if abs(pair.distance) < _TOUCH:
        how = f"{a} and {b} touch"
    elif pair.distance < 0:
        how = f"{a} and {b} overlap by {-pair.distance:.2g} m"
    else:
        margin = world.margins().of(a, b)
        how = f"{a} and {b} are {pair.distance:.2g} m apart, less than their margin of {margin:g} m"
    return f"where the scene puts its robots, {how}: no motion can begin there"


def _always_touching(world: "World", touching: tuple[BodyPair, ...]) -> list[tuple[str, str]]:
    """Return the pairs of links of one robot that overlap at all sampled joint positions."""
    own = {pair.bodies for pair in touching if pair.distance <= 0 and _are_of_one(*pair.bodies)}
    if not own:
        return []
    robots = {a.partition("::")[0] for a, _ in own}
    groups = [g for g in world.groups if g.name.partition("::")[0] in robots]
    probe = DistanceProbe(world.drake, world.margins(0.0))
    rng = np.random.default_rng(0)
    for _ in range(_NUM_TRIED):
        full = np.array(world.state)
        for group in groups:
            full[world.drake.position_indices(group)] = _anywhere(world, group, rng)
        own &= {pair.bodies for pair in probe.pairs_within(world.drake.follow(full), 0.0)}
        if not own:
            break
    return sorted(own)


def _anywhere(world: "World", group: JointGroup, rng: np.random.Generator) -> Array:
    """Return a random configuration; planar and floating joints keep their positions."""
    limits, q = world.limits(group), np.array(world.positions(group))
    at = 0
    for joint in group.joints:
        count = len(joint.position_names)
        reach = _UNLIMITED.get(joint.type)
        if reach is not None:
            low, high = limits.lower[at], limits.upper[at]
            is_open = not (np.isfinite(low) and np.isfinite(high))
            q[at] = rng.uniform(-reach, reach) if is_open else rng.uniform(low, high)
        at += count
    return q


def _are_of_one(a: str, b: str) -> bool:
    (robot_a, scoped_a, _), (robot_b, scoped_b, _) = a.partition("::"), b.partition("::")
    return bool(scoped_a and scoped_b) and robot_a == robot_b


def share_start_warnings(before: DrakeModel, after: DrakeModel, rows: Collection[int]) -> None:
    """Copy the cached warnings of one model to another, with some rows of `standing` moved."""
    if before.standing in _known:
        known = _known[before.standing]
        _known[after.standing] = replace(known, unseen=known.unseen.union(rows))


def _configuration_warnings(world: "World") -> tuple[str, ...]:
    """Return a warning for each named configuration that is invalid whatever surrounds the robot.

    Of several robots of one model, equal configurations are checked once.
    """
    found: list[str] = []
    seen: set[tuple[str, str, bytes]] = set()
    for own, loaded in zip(world.robot_groups, world.loaded_robots, strict=True):
        for local, group in own.groups.items():
            for name, q in world.configurations(group).items():
                alike = loaded.scene_robot.model, local, q.tobytes()
                wrong = "" if alike in seen else _wrong(world, group, q)
                seen.add(alike)
                found += [f"configuration {name!r} of {group.name} {wrong}"] if wrong else []
    return tuple(found)


def _wrong(world: "World", group: JointGroup, q: Array) -> str:
    return _beyond_limits(world, group, q) or _hits_itself(world, group, q)


def _beyond_limits(world: "World", group: JointGroup, q: Array) -> str:
    limits = world.limits(group)
    beyond = np.maximum(limits.lower - q, q - limits.upper)
    worst = int(np.argmax(beyond))
    if beyond[worst] <= _DUST:
        return ""
    return (
        f"lies outside its limits: {group.position_names[worst]} at {q[worst]:g}, limits "
        f"[{limits.lower[worst]:g}, {limits.upper[worst]:g}]"
    )


def _hits_itself(world: "World", group: JointGroup, q: Array) -> str:
    margins = world.margins()
    if world.collision_oracle(group, margins).is_free(q):
        return ""
    at_start = {pair.bodies for pair in world.violations(group, world.positions(group), margins)}
    for pair in world.violations(group, q, margins):
        if pair.distance < 0 and _are_of_one(*pair.bodies) and pair.bodies not in at_start:
            a, b = pair.bodies
            return f"is in collision with itself: {a} and {b} overlap by {-pair.distance:.2g} m"
    return ""
