"""Pairs of bodies that a proof does not look at: what is declared, and links that a joint joins.

A proof that passes over two bodies which touch is one only if they cannot do otherwise: of two that
are apart by default and in most of their joint's range, the judge asks that they be held against
each other.
"""

from collections.abc import Set as AbstractSet

import numpy as np

import planning
from tests.adversary.cases import Claim, Document, Setting
from tests.adversary.draws.motions import positions, sample_places
from tests.adversary.judge.distances import Near, nearest
from tests.adversary.judge.kinematics import FileJoint
from tests.adversary.judge.surroundings import Look, Pair, Stage

_SWEEP = 60
# Overlaps and gaps that count, as a share of the size.
_CLEAR = 1e-3
# Shapes this near touch [m], and in so much of a joint's range they touch about it.
_FLUSH, _OFTEN = 2e-4, 0.4


def adjacent(stage: Stage) -> set[Pair]:
    """Return the pairs of links that a joint joins and that can move against each other."""
    pairs = {frozenset((f"r::{j.parent}", f"r::{j.child}")) for j in stage.robot.joints}
    return {pair for pair in pairs if not stage.is_rigid(pair)}


def declared(setting: Setting, stage: Stage) -> set[Pair]:
    """Return the pairs that move and that the product says it does not look at."""
    unchecked = planning.scene_summary(setting.world).unchecked
    pairs = {frozenset(entry.bodies) for entry in unchecked}
    return {pair for pair in pairs if pair <= set(stage.bodies) and not stage.is_rigid(pair)}


def overlooked(stage: Stage, motion: Document, pairs: AbstractSet[Pair]) -> list[Claim]:
    """Return a claim for every pair that collides on a motion and is left out without evidence."""
    found: list[Claim] = []
    for pair in sorted(pairs, key=sorted):
        others = {frozenset((a, b)) for a in stage.bodies for b in stage.bodies} - {pair}
        seen = stage.worst(motion, Look(skip=others, only=pair, count=60, rounds=1))
        if seen is None or seen.distance > -_CLEAR * stage.size:
            continue
        said = f"{sorted(pair)} overlap by {-seen.distance:.4g} m at {seen.time:.4g} s, and "
        joints = [j for j in stage.robot.joints if {f"r::{j.parent}", f"r::{j.child}"} == pair]
        if joints:
            why = _without_evidence(stage, joints[0], pair)
            found += [Claim("neighbours", said + why, 6)] if why else []
        elif (gap := max(_distances(stage, _along(motion), pair))) > _CLEAR * stage.size:
            found.append(Claim("what it holds", f"{said}are {gap:.4g} m apart elsewhere"))
    return found


def _without_evidence(stage: Stage, joint: FileJoint, pair: Pair) -> str:
    """Return why two neighbours must be looked at; "" if their shapes touch about their joint.

    They do if they touch where the joint is by default, or at half of its range (here two fifths,
    for the range is sampled): decision 31.
    """
    rest = {leader.name: _middle(leader)[:1] for leader in stage.robot.leaders}
    places = [rest]
    if joint.kind not in {"planar", "floating"}:
        at = 0.0 if not np.isfinite(joint.lower) else float(np.clip(0.0, joint.lower, joint.upper))
        places += [rest | _led(stage, joint, np.array([x])) for x in {0.0, at}]
    apart = min(min(_distances(stage, q, pair)) for q in places)
    if apart <= _FLUSH:
        return ""
    if joint.kind in {"planar", "floating"}:
        return f"are {apart:.4g} m apart by default"
    gaps = np.array(_distances(stage, _sweep(stage, joint), pair))
    share = float((gaps <= _FLUSH).mean())
    if share >= _OFTEN:
        return ""
    return f"are {apart:.4g} m apart by default; they touch in {share:.0%} of their joint's range"


def _along(motion: Document) -> dict[str, np.ndarray]:
    pieces, local, _ = sample_places(motion, _SWEEP)
    return positions(motion, pieces[:_SWEEP], local[:_SWEEP])


def _distances(stage: Stage, q: dict[str, np.ndarray], pair: Pair) -> list[float]:
    """Return the distance of two bodies at some configurations [m]."""
    count = len(next(iter(q.values())))
    solids = [solid for solid in stage.solids(q, count) if solid.body in pair]
    found: list[float] = []
    for i in range(count):
        last: Near | None = None
        for last in nearest(stage.pairs([s.at(i) for s in solids], Look(None)), stage.size):  # noqa: B007
            pass
        found.append(np.inf if last is None else last.distance)
    return found


def _sweep(stage: Stage, joint: FileJoint) -> dict[str, np.ndarray]:
    """Return configurations that take a joint through all of its range."""
    low, high = (joint.lower, joint.upper) if np.isfinite(joint.lower) else (-np.pi, np.pi)
    q = {leader.name: _middle(leader) for leader in stage.robot.leaders}
    return q | _led(stage, joint, np.linspace(low, high, _SWEEP))


def _led(stage: Stage, joint: FileJoint, values: np.ndarray) -> dict[str, np.ndarray]:
    """Return what the joint that leads a joint has to be at for it to be at some values."""
    leader, factor = stage.robot.factor(joint.name)
    zero = stage.robot.value(joint.name, {leader: np.zeros(1)})[0]
    return {leader: (values[:, None] - zero) / factor}


def _middle(joint: FileJoint) -> np.ndarray:
    match joint.kind:
        case "planar":
            return np.zeros((_SWEEP, 3))
        case "floating":
            return np.tile(np.array([1.0, 0, 0, 0, 0, 0, 0]), (_SWEEP, 1))
        case _:
            return np.zeros((_SWEEP, 1))
