"""Validity of configurations: joint limits, collisions and margins, with every violation."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.geometry.body_pair import BodyPair
from planning.domain.value import Value
from planning.errors import ProblemInvalid
from planning.world.loading.positions import validate_positions
from planning.world.world import World

# Largest distance at which the nearest pair of a configuration is measured [m].
_MAX_MEASURED_DISTANCE = 10.0


@dataclass(frozen=True, eq=False)
class LimitViolation(Value):
    """Position outside its limits [rad or m]."""

    joint: str
    position: float
    lower: float
    upper: float


@dataclass(frozen=True, eq=False)
class StateVerdict(Value):
    """Validity of one configuration, with its violations.

    Attributes:
        valid: Within limits, and every pair keeps its margin.
        violations: Every pair that is nearer than its margin, nearest first.
        limit_violations: Every position outside its limits.
        nearest: The pair that is nearest of all, or None if nothing can collide.
    """

    valid: bool
    violations: tuple[BodyPair, ...]
    limit_violations: tuple[LimitViolation, ...]
    nearest: BodyPair | None


def check_configurations(
    world: World,
    group: str,
    configurations: Float64[np.ndarray, "n nq"],
    margin: float | None = None,
) -> tuple[StateVerdict, ...]:
    """Return a verdict on each configuration of a group.

    Args:
        world: The scene, loaded.
        group: `robot` or `robot::group`.
        configurations: The group's q [rad or m], a row each.
        margin: Distance to keep [m]; None for the scene's.

    Raises:
        UnknownName: There is no such group.
        ProblemInvalid: A row has the wrong count or is not finite, or the margin is negative.
    """
    joints = world.group(group)
    if margin is not None and not margin >= 0:
        message = f"margin must not be negative, got {margin}"
        raise ProblemInvalid(message, {"field": "margin"})
    margins = world.margins(margin)
    probe = world.distance_probe(margins)
    limits = world.limits(joints)
    verdicts: list[StateVerdict] = []
    for i, row in enumerate(configurations):
        q = validate_positions(joints, row, f"configurations.{i}")
        full = world.embed(joints, q)
        pairs = probe.nearest_within(full, _MAX_MEASURED_DISTANCE, margins.largest)
        too_near = tuple(pair for pair in pairs if pair.distance < margins.of(*pair.bodies))
        limit_violations = _limit_violations(joints.position_names, q, limits.lower, limits.upper)
        nearest = pairs[0] if pairs else None
        verdicts.append(
            StateVerdict(not too_near and not limit_violations, too_near, limit_violations, nearest)
        )
    return tuple(verdicts)


def _limit_violations(names: Any, q: Any, lower: Any, upper: Any) -> tuple[LimitViolation, ...]:
    return tuple(
        LimitViolation(name, float(x), float(low), float(high))
        for name, x, low, high in zip(names, q, lower, upper, strict=True)
        if not low <= x <= high
    )
