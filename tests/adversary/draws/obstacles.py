"""Random obstacles that a motion passes by a chosen distance, or cuts by a chosen depth."""

import numpy as np

from planning.domain.arrays import Array
from tests.adversary.cases import Document
from tests.adversary.draws.motions import around, positions
from tests.adversary.draws.shapes import radius_of, random_shape
from tests.adversary.judge.kinematics import pose_matrix
from tests.adversary.judge.surroundings import Look, Seen, Stage

GAPS = (-1e-3, -1e-5, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1)


def random_obstacle(
    rng: np.random.Generator,
    stage: Stage,
    motion: Document,
    name: str,
    gaps: tuple[float, ...] = GAPS,
) -> Document:
    """Return an obstacle that is nearly a gap, a share of the size, from what moves."""
    is_ground = rng.random() < 0.15
    extent = stage.size * 10 ** rng.uniform(-0.7, 0.5)
    shape = {"half_space": {}} if is_ground else random_shape(rng, extent)
    rpy = rng.uniform(-3, 3, size=3).tolist() if rng.random() < 0.6 else [0.0, 0.0, 0.0]
    middle, reach = _somewhere(rng, stage, motion)
    outward = rng.normal(size=3)
    away = reach + (0.0 if is_ground else radius_of(shape))
    start = middle + outward / np.linalg.norm(outward) * away
    thing: Document = {"name": name, "shape": shape, "rpy": rpy, "xyz": start.tolist()}
    thing["as_mesh"] = bool(rng.random() < 0.3)
    push(stage, motion, thing, stage.size * float(rng.choice(gaps)))
    if is_ground and rng.random() < 0.5:
        # A half space has no middle: from here it is the same one.
        angle, far = rng.uniform(0, 2 * np.pi), stage.size * 10 ** rng.uniform(1, 3)
        level = pose_matrix([0, 0, 0], rpy)[:3, :3] @ [np.cos(angle), np.sin(angle), 0.0]
        thing["xyz"] = (np.array(thing["xyz"]) + far * level).tolist()
    return thing


def _somewhere(rng: np.random.Generator, stage: Stage, motion: Document) -> tuple[Array, float]:
    """Return where a solid that moves is at some instant, and how large it is."""
    pieces, local, _ = around(motion, rng.random() * motion["breaks"][-1], 0.0, 1)
    solids = stage.solids(positions(motion, pieces, local), 1)
    moved = [s for s in solids if not s.is_half_space and stage.is_moved(s.body)]
    if not moved:
        return np.zeros(3), stage.size
    solid = moved[int(rng.integers(len(moved)))]
    return solid.middles[0], solid.radius


def push(stage: Stage, motion: Document, thing: Document, gap: float) -> None:
    """Move an obstacle along the normal until what moves passes it by `gap` [m]."""
    for _ in range(6):
        seen = approach(stage, motion, thing)
        if (
            seen is None
            or not np.isfinite(seen.near.normal).all()
            or abs(seen.distance - gap) < 0.05 * abs(gap)
        ):
            return
        # The normal leads from the second of the pair to the first.
        towards = seen.near.normal * (1.0 if seen.near.pair[1] == thing["name"] else -1.0)
        thing["xyz"] = (np.array(thing["xyz"]) + towards * (seen.distance - gap)).tolist()


def approach(stage: Stage, motion: Document, thing: Document) -> Seen | None:
    """Return how near what moves comes to a thing that is not there yet."""
    stage.add(thing)
    seen = stage.worst(motion, Look(None, only=frozenset([thing["name"]]), count=60, rounds=2))
    stage.remove(thing)
    return seen
