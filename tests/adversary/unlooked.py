"""Pairs of bodies that a proof does not look at: links that a joint joins, and what is declared.

A proof that passes over two links that touch is one only if they cannot do otherwise: of two that
are apart somewhere in the joint's range, the judge asks that they be held against each other.
"""

from collections.abc import Set as AbstractSet

import numpy as np

from tests.adversary.cases import Claim, Document, Setting
from tests.adversary.distances import Near, nearest
from tests.adversary.kinematics import FileJoint
from tests.adversary.surroundings import Look, Pair, Stage

_SWEEP = 60


def adjacent(stage: Stage) -> set[Pair]:
    """Return the pairs of links that a joint joins and that can move against each other."""
    pairs = {frozenset((f"r::{j.parent}", f"r::{j.child}")) for j in stage.robot.joints}
    return {pair for pair in pairs if not stage.is_rigid(pair)}


def declared(setting: Setting) -> set[Pair]:
    """Return the pairs that the scene's summary says are not looked at."""
    told = getattr(setting.world.summary, "unchecked_pairs", ())
    return {frozenset(entry.bodies) for entry in told}


def overlooked(stage: Stage, motion: Document, pairs: AbstractSet[Pair]) -> list[Claim]:
    """Return a claim for every pair that collides on a motion and need not overlap."""
    found: list[Claim] = []
    for pair in sorted(pairs, key=sorted):
        others = {frozenset((a, b)) for a in stage.bodies for b in stage.bodies} - {pair}
        seen = stage.worst(motion, Look(skip=others, only=pair, count=60, rounds=1))
        if seen is None or seen.distance > -1e-3 * stage.size:
            continue
        gap = _largest_gap(stage, pair)
        if gap > 1e-3 * stage.size:
            said = f"{sorted(pair)} overlap by {-seen.distance:.4g} m at {seen.time:.4g} s, and are "
            found.append(Claim("neighbours", f"{said}{gap:.4g} m apart elsewhere", 6))
    return found


def _largest_gap(stage: Stage, pair: Pair) -> float:
    """Return how far apart two links that a joint joins are somewhere in its range [m]."""
    joint = next(j for j in stage.robot.joints if {f"r::{j.parent}", f"r::{j.child}"} == pair)
    q = {leader.name: _middle(leader) for leader in stage.robot.leaders}
    leader, factor = stage.robot.factor(joint.name)
    if joint.kind in {"planar", "floating"}:
        return np.inf
    low, high = (joint.lower, joint.upper) if np.isfinite(joint.lower) else (-np.pi, np.pi)
    offset = stage.robot.value(joint.name, {leader: np.zeros(1), **{}})[0] if joint.leader else 0.0
    values = np.linspace(low, high, _SWEEP)[:, None]
    q[leader] = (values - offset) / factor if joint.leader else values
    solids = [s for s in stage.solids(q, _SWEEP) if s.body in pair]
    gaps = []
    for i in range(_SWEEP):
        chosen = [s.at(i) for s in solids]
        last: Near | None = None
        for last in nearest(stage.pairs(chosen, Look()), stage.size):  # noqa: B007
            pass
        gaps.append(np.inf if last is None else last.distance)
    return max(gaps)


def _middle(joint: FileJoint) -> np.ndarray:
    """Return some value of a joint, for all of the sweep."""
    match joint.kind:
        case "planar":
            return np.zeros((_SWEEP, 3))
        case "floating":
            return np.tile(np.array([1.0, 0, 0, 0, 0, 0, 0]), (_SWEEP, 1))
        case _:
            return np.zeros((_SWEEP, 1))
