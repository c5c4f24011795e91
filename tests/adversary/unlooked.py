"""Pairs of bodies that a proof does not look at: what is declared, and links that a joint joins.

A proof that passes over two bodies which touch is one only if they cannot do otherwise: of two that
are apart elsewhere, the judge asks that they be held against each other.
"""

from collections.abc import Set as AbstractSet

import numpy as np

from tests.adversary.cases import Claim, Document, Setting
from tests.adversary.distances import Near, nearest
from tests.adversary.kinematics import FileJoint
from tests.adversary.motions import positions, sample_places
from tests.adversary.surroundings import Look, Pair, Stage

_SWEEP = 60
# Overlaps and gaps that count, as a share of the size.
_CLEAR = 1e-3


def adjacent(stage: Stage) -> set[Pair]:
    """Return the pairs of links that a joint joins and that can move against each other."""
    pairs = {frozenset((f"r::{j.parent}", f"r::{j.child}")) for j in stage.robot.joints}
    return {pair for pair in pairs if not stage.is_rigid(pair)}


def declared(setting: Setting, stage: Stage) -> set[Pair]:
    """Return the pairs that move and that the product says it does not look at.

    Where it says nothing of such pairs they are those that a joint joins.
    """
    summary = setting.world.summary
    if not hasattr(summary, "unchecked"):
        return adjacent(stage)
    pairs = {frozenset(entry.bodies) for entry in summary.unchecked}
    return {pair for pair in pairs if pair <= set(stage.bodies) and not stage.is_rigid(pair)}


def overlooked(stage: Stage, motion: Document, pairs: AbstractSet[Pair]) -> list[Claim]:
    """Return a claim for every pair that collides on a motion and need not overlap."""
    found: list[Claim] = []
    for pair in sorted(pairs, key=sorted):
        others = {frozenset((a, b)) for a in stage.bodies for b in stage.bodies} - {pair}
        seen = stage.worst(motion, Look(skip=others, only=pair, count=60, rounds=1))
        if seen is None or seen.distance > -_CLEAR * stage.size:
            continue
        gap = _largest_gap(stage, motion, pair)
        if gap > _CLEAR * stage.size:
            said = (
                f"{sorted(pair)} overlap by {-seen.distance:.4g} m at {seen.time:.4g} s, and are "
            )
            what = "neighbours" if pair in adjacent(stage) else "what it holds"
            number = 6 if what == "neighbours" else 0
            found.append(Claim(what, f"{said}{gap:.4g} m apart elsewhere", number))
    return found


def _largest_gap(stage: Stage, motion: Document, pair: Pair) -> float:
    """Return how far apart two bodies are at most, on the motion or in their joint's range [m]."""
    pieces, local, _ = sample_places(motion, _SWEEP)
    pieces, local = pieces[:_SWEEP], local[:_SWEEP]
    places = [positions(motion, pieces, local)]
    joints = [j for j in stage.robot.joints if {f"r::{j.parent}", f"r::{j.child}"} == pair]
    places += [_sweep(stage, joint) for joint in joints if joint.kind not in {"planar", "floating"}]
    largest = -np.inf
    for q in places:
        count = len(next(iter(q.values())))
        solids = [solid for solid in stage.solids(q, count) if solid.body in pair]
        for i in range(count):
            last: Near | None = None
            for last in nearest(stage.pairs([s.at(i) for s in solids], Look()), stage.size):  # noqa: B007
                pass
            largest = max(largest, np.inf if last is None else last.distance)
    return largest


def _sweep(stage: Stage, joint: FileJoint) -> dict[str, np.ndarray]:
    """Return configurations that take a joint through all of its range."""
    q = {leader.name: _middle(leader) for leader in stage.robot.leaders}
    leader, factor = stage.robot.factor(joint.name)
    low, high = (joint.lower, joint.upper) if np.isfinite(joint.lower) else (-np.pi, np.pi)
    zero = stage.robot.value(joint.name, {leader: np.zeros(1)})[0]
    q[leader] = (np.linspace(low, high, _SWEEP)[:, None] - zero) / factor
    return q


def _middle(joint: FileJoint) -> np.ndarray:
    match joint.kind:
        case "planar":
            return np.zeros((_SWEEP, 3))
        case "floating":
            return np.tile(np.array([1.0, 0, 0, 0, 0, 0, 0]), (_SWEEP, 1))
        case _:
            return np.zeros((_SWEEP, 1))
