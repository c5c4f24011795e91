"""start_warnings(): collisions and limit violations at the scene's positions, with remedies."""

import json
from collections.abc import Collection
from dataclasses import dataclass, replace
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
from planning.world.world import World

# Slack beyond the margin at which every distance query agrees [m].
_SLACK = 1e-3


@dataclass(frozen=True)
class _CachedWarnings:
    """Cached warnings of a model, for one `state_digest`.

    Attributes:
        state_digest: Digest of the robots' positions and of the margins.
        is_free: Whether all pairs kept their margins.
        configuration_warnings: Warnings that do not depend on surrounding objects.
        moved_rows: Rows of `static_objects` that have moved since.
    """

    state_digest: str
    is_free: bool
    configuration_warnings: tuple[str, ...]
    moved_rows: frozenset[int] = frozenset()


_cache: WeakKeyDictionary[StaticObjects, _CachedWarnings] = WeakKeyDictionary()


# Number of random configurations at which touching pairs are checked again.
_NUM_SAMPLES = 20
# With more groups, making a checker takes longer than measuring all distances.
_MAX_GROUPS = 4
# Number of pairs with a warning each.
_MAX_WARNINGS = 10
# Tolerance of position limits [rad or m].
_LIMIT_TOLERANCE = 1e-6
# Rounding error of a zero distance [m].
_TOUCH_DISTANCE = 1e-9
# Range of an unlimited joint: a whole turn, or a metre either way.
_UNLIMITED_RANGE = {
    JointType.CONTINUOUS: np.pi,
    JointType.REVOLUTE: np.pi,
    JointType.PRISMATIC: 1.0,
}


def start_warnings(world: World) -> tuple[str, ...]:
    """Return the faults that make every plan from the scene's positions fail.

    Pairs of links of one robot that touch in all sampled configurations come with an edit that
    allows their contact. Where nothing touches, this takes one collision check.
    """
    margins, scene = world.margins(), world.scene
    state_digest = digest((world.state, scene.margin, scene.margins, scene.configurations))
    cached = _cache.get(world.drake.static_objects)
    cached = cached if cached is not None and cached.state_digest == state_digest else None
    touching: tuple[BodyPair, ...] = ()
    is_free = _is_still_free(world, cached, margins) or _is_free(world, margins)
    if not is_free:
        touching = world.distance_probe(margins).violations(world.state)
    warnings = [_pair_warning(world, pair) for pair in touching[:_MAX_WARNINGS]]
    if len(touching) > _MAX_WARNINGS:
        warnings.append(f"{len(touching) - _MAX_WARNINGS} more pairs violate their margins there")
    always_touching = _always_touching(world, touching)
    if always_touching:
        operations = [{"op": "allow", "pair": list(pair)} for pair in always_touching]
        warnings.append(
            f"{len(always_touching)} of these pairs overlap in all {_NUM_SAMPLES + 1} sampled "
            "configurations, so their shapes probably overlap by design; to allow these contacts, "
            f"edit the scene with {json.dumps({'operations': operations})}"
        )
    configuration_warnings = (
        _configuration_warnings(world) if cached is None else cached.configuration_warnings
    )
    _cache[world.drake.static_objects] = _CachedWarnings(
        state_digest, is_free, configuration_warnings
    )
    return (*warnings, *configuration_warnings)


def _is_still_free(world: World, cached: _CachedWarnings | None, margins: PairMargins) -> bool:
    """Return whether all pairs certainly keep their margins, by the cache and what moved."""
    if cached is None or not cached.is_free:
        return False
    near_static = NearStatic(world.drake, shared_context(world.drake))
    near_static.set_positions(world.state)
    return near_static.are_farther_than(cached.moved_rows, margins.largest + _SLACK)


def _is_free(world: World, margins: PairMargins) -> bool:
    """Return whether all pairs keep their margins; False where only the probe can decide."""
    if len(world.groups) > _MAX_GROUPS:
        return False
    # With its group at the scene's positions, one checker's verdict covers all pairs.
    return all(
        world.collision_oracle(group, margins).is_free(world.positions(group))
        for group in world.groups[:1]
    )


def _pair_warning(world: World, pair: BodyPair) -> str:
    a, b = pair.bodies
    if abs(pair.distance) < _TOUCH_DISTANCE:
        relation = f"{a} and {b} touch"
    elif pair.distance < 0:
        relation = f"{a} and {b} overlap by {-pair.distance:.2g} m"
    else:
        margin = world.margins().of(a, b)
        relation = (
            f"{a} and {b} are {pair.distance:.2g} m apart, less than their margin of {margin:g} m"
        )
    return f"at the scene's positions {relation}: no motion can start from there"


def _always_touching(world: World, touching: tuple[BodyPair, ...]) -> list[tuple[str, str]]:
    """Return the pairs of links of one robot that overlap at all sampled joint positions."""
    pairs = {
        pair.bodies for pair in touching if pair.distance <= 0 and _are_of_one_robot(*pair.bodies)
    }
    if not pairs:
        return []
    robots = {a.partition("::")[0] for a, _ in pairs}
    groups = [g for g in world.groups if g.name.partition("::")[0] in robots]
    probe = DistanceProbe(world.drake, world.margins(0.0))
    rng = np.random.default_rng(0)
    for _ in range(_NUM_SAMPLES):
        full = np.array(world.state)
        for group in groups:
            full[world.drake.position_indices(group)] = _random_configuration(world, group, rng)
        pairs &= {
            pair.bodies for pair in probe.pairs_within(world.drake.apply_couplings(full), 0.0)
        }
        if not pairs:
            break
    return sorted(pairs)


def _random_configuration(world: World, group: JointGroup, rng: np.random.Generator) -> Array:
    """Return a random configuration; planar and floating joints keep their positions."""
    limits, q = world.limits(group), np.array(world.positions(group))
    at = 0
    for joint in group.joints:
        count = len(joint.position_names)
        half_range = _UNLIMITED_RANGE.get(joint.type)
        if half_range is not None:
            low, high = limits.lower[at], limits.upper[at]
            is_open = not (np.isfinite(low) and np.isfinite(high))
            q[at] = rng.uniform(-half_range, half_range) if is_open else rng.uniform(low, high)
        at += count
    return q


def _are_of_one_robot(a: str, b: str) -> bool:
    (robot_a, scoped_a, _), (robot_b, scoped_b, _) = a.partition("::"), b.partition("::")
    return bool(scoped_a and scoped_b) and robot_a == robot_b


def copy_start_warnings(before: DrakeModel, after: DrakeModel, rows: Collection[int]) -> None:
    """Copy the cached warnings of a model to another, with some rows of `static_objects` moved."""
    if before.static_objects in _cache:
        cached = _cache[before.static_objects]
        _cache[after.static_objects] = replace(cached, moved_rows=cached.moved_rows.union(rows))


def _configuration_warnings(world: World) -> tuple[str, ...]:
    """Return a warning for each named configuration that is invalid in any surroundings.

    Of several robots of one model, equal configurations are checked once.
    """
    found: list[str] = []
    seen: set[tuple[str, str, bytes]] = set()
    for own, loaded in zip(world.robot_groups, world.loaded_robots, strict=True):
        for local, group in own.groups.items():
            for name, q in world.configurations(group).items():
                key = loaded.scene_robot.model, local, q.tobytes()
                fault = "" if key in seen else _configuration_fault(world, group, q)
                seen.add(key)
                found += [f"configuration {name!r} of {group.name} {fault}"] if fault else []
    return tuple(found)


def _configuration_fault(world: World, group: JointGroup, q: Array) -> str:
    return _limit_fault(world, group, q) or _self_collision_fault(world, group, q)


def _limit_fault(world: World, group: JointGroup, q: Array) -> str:
    limits = world.limits(group)
    excess = np.maximum(limits.lower - q, q - limits.upper)
    worst = int(np.argmax(excess))
    if excess[worst] <= _LIMIT_TOLERANCE:
        return ""
    return (
        f"lies outside its limits: {group.position_names[worst]} at {q[worst]:g}, limits "
        f"[{limits.lower[worst]:g}, {limits.upper[worst]:g}]"
    )


def _self_collision_fault(world: World, group: JointGroup, q: Array) -> str:
    margins = world.margins()
    if world.collision_oracle(group, margins).is_free(q):
        return ""
    at_start = {pair.bodies for pair in world.violations(group, world.positions(group), margins)}
    for pair in world.violations(group, q, margins):
        if pair.distance < 0 and _are_of_one_robot(*pair.bodies) and pair.bodies not in at_start:
            a, b = pair.bodies
            return f"is in collision with itself: {a} and {b} overlap by {-pair.distance:.2g} m"
    return ""
