"""Validation of a start configuration: joint limits, collisions and margins, with evidence."""

from typing import Any

import numpy as np
from jaxtyping import Bool, Float64

from planning.domain.arrays import Array
from planning.domain.geometry.body_pair import BodyPair
from planning.domain.robot.joints import JointGroup, JointLimits
from planning.domain.robot.manifold import Manifold
from planning.errors import StartInCollision, StartOutOfLimits, StartTooNear
from planning.goals.diagnosis.distance_text import millimetres
from planning.world.collision.margins import PairMargins
from planning.world.loading.positions import validate_positions
from planning.world.world import World

# Limit violations up to this are rounding errors: they are clipped and reported [rad or m].
ROUNDING = 1e-6
# Distances below this are 0 up to rounding [m].
_CONTACT_TOLERANCE = 1e-9


def resolve_start(world: World, group: JointGroup, start: Any) -> Array:
    """Return the requested start, or without one the scene's positions, shape (nq,), read-only.

    Raises:
        ProblemInvalid: The count is wrong, a number is not finite, or a quaternion is zero.
    """
    return validate_positions(group, world.positions(group) if start is None else start, "start")


def validate_start(
    world: World, group: JointGroup, q: Float64[np.ndarray, " nq"], margins: PairMargins
) -> tuple[Array, Array]:
    """Return the start clipped to its limits, and the correction, both shape (nq,).

    Raises:
        StartOutOfLimits: A joint is outside its limits by more than `ROUNDING`.
        StartInCollision: A pair of bodies overlaps.
        StartTooNear: No pair overlaps, but a pair is nearer than its margin.
    """
    limits = world.limits(group)
    start = clip_rounding(limits, Manifold.of(group.joints), q)
    outside = limit_violations(limits, group, start)
    if outside:
        worst = max(outside, key=lambda entry: entry["violation"])
        message = (
            f"the start is outside its limits: {worst['joint']} = {worst['position']:.6g} "
            f"is not in [{worst['lower']:.6g}, {worst['upper']:.6g}]"
        )
        raise StartOutOfLimits(message, {"joints": outside})
    if not world.collision_oracle(group, margins).is_free(start):
        pairs = world.violations(group, start, margins)
        if pairs:
            pair_text = describe_pairs(pairs, margins)
            evidence = {"pairs": pair_evidence(pairs, margins)}
            if has_overlap(pairs):
                raise StartInCollision(f"the start collides: {pair_text}", evidence)
            message = f"no bodies overlap at the start, but it violates margins: {pair_text}"
            raise StartTooNear(message, evidence)
    return start, start - q


def clip_rounding(
    limits: JointLimits, manifold: Manifold, q: Float64[np.ndarray, "*n nq"]
) -> Array:
    """Return q with unit quaternions, and clipped to limits violated by at most `ROUNDING`."""
    unit = manifold.normalized(q)
    clipped = np.minimum(np.maximum(unit, limits.lower), limits.upper)
    return np.where(np.abs(clipped - unit) <= ROUNDING, clipped, unit)


def within_limits(limits: JointLimits, q: Float64[np.ndarray, "n nq"]) -> Bool[np.ndarray, " n"]:
    """Return whether each row is within the position limits."""
    return ((q >= limits.lower) & (q <= limits.upper)).all(axis=1)


def limit_violations(
    limits: JointLimits, group: JointGroup, q: Float64[np.ndarray, " nq"]
) -> list[dict[str, Any]]:
    """Return every position outside its limits, as evidence."""
    excess = np.maximum(limits.lower - q, q - limits.upper)
    if not (excess > 0).any():
        return []
    return [
        {
            "joint": group.position_names[i],
            "position": float(q[i]),
            "lower": float(limits.lower[i]),
            "upper": float(limits.upper[i]),
            "violation": float(excess[i]),
        }
        for i in np.flatnonzero(excess > 0)
    ]


def pair_evidence(pairs: tuple[BodyPair, ...], margins: PairMargins) -> list[dict[str, Any]]:
    """Return violating pairs as evidence; `depth` [m] is the margin minus the distance."""
    return [
        {
            "bodies": list(pair.bodies),
            "distance": pair.distance,
            "margin": margins.of(*pair.bodies),
            "depth": margins.of(*pair.bodies) - pair.distance,
            "points": np.asarray(pair.points).tolist(),
        }
        for pair in pairs
    ]


def describe_pairs(pairs: tuple[BodyPair, ...], margins: PairMargins) -> str:
    """Return the first three pairs as text: by how much they overlap, or how near they are."""
    texts = [_describe_pair(pair, margins.of(*pair.bodies)) for pair in pairs[:3]]
    more = f" and {len(pairs) - 3} more" if len(pairs) > 3 else ""
    return ", ".join(texts) + more


def _describe_pair(pair: BodyPair, margin: float) -> str:
    bodies = "-".join(pair.bodies)
    is_touching = abs(pair.distance) < _CONTACT_TOLERANCE
    if pair.distance < 0:
        return f"{bodies} touching" if is_touching else f"{bodies} by {millimetres(-pair.distance)}"
    apart = "touching" if is_touching else f"{millimetres(pair.distance)} apart"
    return f"{bodies} {apart} with a margin of {millimetres(margin)}"


def has_overlap(pairs: tuple[BodyPair, ...]) -> bool:
    """Return whether any of the pairs overlaps, rather than only violating its margin."""
    return any(pair.distance < 0 for pair in pairs)
