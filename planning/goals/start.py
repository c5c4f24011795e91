"""Admit a start, or say what is wrong with it."""

from typing import Any

import numpy as np
from jaxtyping import Bool, Float64

from planning.domain.body_pair import BodyPair
from planning.domain.joints import JointGroup, JointLimits
from planning.domain.manifold import Manifold
from planning.errors import StartInCollision, StartOutOfLimits
from planning.world.margins import PairMargins
from planning.world.world import World

type Array = np.ndarray[Any, np.dtype[np.float64]]

# A violation of limits up to this much is numeric dust: it is clipped and reported [rad or m].
DUST = 1e-6


def admit_start(
    world: World, group: JointGroup, q: Float64[np.ndarray, " nq"], margins: PairMargins
) -> tuple[Array, Array]:
    """Return the start inside its limits, and by how much it was moved, both shape (nq,).

    Raises:
        StartOutOfLimits: A joint is outside by more than dust.
        StartInCollision: A pair of bodies is nearer than its margin.
    """
    limits = world.limits(group)
    start = clip_dust(limits, Manifold.of(group.joints), q)
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
            message = f"the start collides: {describe_pairs(pairs, margins)}"
            raise StartInCollision(message, {"pairs": pair_evidence(pairs, margins)})
    return start, start - q


def clip_dust(limits: JointLimits, manifold: Manifold, q: Float64[np.ndarray, "*n nq"]) -> Array:
    """Return q with unit quaternions, and with limits that it misses by dust kept."""
    unit = manifold.normalized(q)
    clipped = np.clip(unit, limits.lower, limits.upper)
    return np.where(np.abs(clipped - unit) <= DUST, clipped, unit)


def within_limits(limits: JointLimits, q: Float64[np.ndarray, "n nq"]) -> Bool[np.ndarray, " n"]:
    """Return whether each row keeps the position limits."""
    return ((q >= limits.lower) & (q <= limits.upper)).all(axis=1)


def limit_violations(
    limits: JointLimits, group: JointGroup, q: Float64[np.ndarray, " nq"]
) -> list[dict[str, Any]]:
    """Return every position outside its limits, as evidence."""
    excess = np.maximum(limits.lower - q, q - limits.upper)
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
    """Return violating pairs as evidence, `depth` [m] being what is missing to the margin."""
    return [
        {
            "bodies": list(pair.bodies),
            "distance": pair.distance,
            "depth": margins.of(*pair.bodies) - pair.distance,
            "points": np.asarray(pair.points).tolist(),
        }
        for pair in pairs
    ]


def describe_pairs(pairs: tuple[BodyPair, ...], margins: PairMargins) -> str:
    """Return the worst pairs as words."""
    words = [
        f"{a}-{b} by {1000 * (margins.of(a, b) - pair.distance):.1f} mm"
        for pair in pairs[:3]
        for a, b in [pair.bodies]
    ]
    more = f" and {len(pairs) - 3} more" if len(pairs) > 3 else ""
    return ", ".join(words) + more
