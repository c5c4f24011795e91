"""A region around a configuration, by IRIS-ZO.

Werner et al. (2024), "Faster algorithms for growing collision-free convex polytopes in robot
configuration space": random configurations of the polytope that collide are moved toward the
center of an ellipsoid until they are about to be free; there the polytope gets a face that is
tangent to the ellipsoid, scaled. What is left is tested again. Then the ellipsoid becomes the
largest one inside. It asks for nothing but verdicts on configurations, many at a time.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.planner.regions import Region
from planning.domain.request.deadline import Deadline
from planning.regions.ellipsoid import GrowthEllipsoid
from planning.regions.free_space import FreeSpace
from planning.regions.hit_and_run import hit_and_run

type Array = np.ndarray[Any, np.dtype[np.float64]]
type Faces = tuple[Array, Array]

# How many configurations are looked at together.
_BATCH = 1000
# While a region takes shape, this share of them may collide.
_ROUGHLY = 0.01
# Steps of each walker between two looks, and before the first.
_STEPS = 8
_FIRST_STEPS = 40
# Halvings of the way from the center to what collides.
_HALVINGS = 8
# How far faces stand back from what collides [rad or m]; every so many rounds twice as far, so
# that growth ends where an obstacle is too round for few faces.
_RETREAT = 0.02
_PATIENCE = 15
_MOST_ROUNDS = 150
# Of a polytope with more faces than this for each dimension, a face is moved, instead of a new one
# made, if that takes no more than a share of its way to the center.
_PLENTY = 8
_SHIFT = 0.2
# Faces at most, by round.
_MOST_FACES = 40
# An ellipsoid that grew by less than this factor has grown enough.
_GROWTH = 1.1


@dataclass(frozen=True)
class IrisZo:
    """Grows one region at a time.

    Attributes:
        judge: Says what is free.
        lower: Lowest configuration of the domain, shape (n,).
        upper: And highest.
        num_free: How many random configurations must be free, one after another.
        iterations: How often the ellipsoid is made anew.
        generator: Of all randomness.
        deadline: Asked in every round.
    """

    judge: FreeSpace
    lower: Array
    upper: Array
    num_free: int
    iterations: int
    generator: np.random.Generator
    deadline: Deadline

    def inflate(self, seed: Float64[np.ndarray, " n"]) -> Region | None:
        """Return a region around a free configuration, shape (n,); None if it comes to nothing.

        It contains the configuration unless that lies near the last faces.

        Raises:
            Canceled: The end was asked for.
            DeadlineExceeded: The time ran out.
        """
        ellipsoid, rough = GrowthEllipsoid.ball(seed), None
        for _ in range(self.iterations):
            found = self._cut(self._domain, ellipsoid, self.num_free // 20, _ROUGHLY)
            if found is None or (rough is not None and not _contains(found[0], seed[None])[0]):
                break
            rough = found[0]
            largest = GrowthEllipsoid.inscribed(*rough)
            is_grown = largest.log_volume > ellipsoid.log_volume + np.log(_GROWTH)
            if not (is_grown and self.judge.are_free(largest.center[None])[0]):
                break
            ellipsoid = largest
        if rough is None:
            return None
        found = self._cut(rough, ellipsoid, self.num_free, 0.0)
        return None if found is None else Region(*found[0], ellipsoid.center, found[1])

    @property
    def _domain(self) -> Faces:
        identity = np.eye(len(self.lower))
        return np.concatenate([identity, -identity]), np.concatenate([self.upper, -self.lower])

    def _cut(
        self, faces: Faces, ellipsoid: GrowthEllipsoid, needed: int, tolerated: float
    ) -> tuple[Faces, int] | None:
        """Return fewer configurations, and how many in a row were free; None if it never ends."""
        origin = np.repeat(ellipsoid.center[None], _BATCH, axis=0)
        qs = hit_and_run(origin, faces, ellipsoid.shape, _FIRST_STEPS, self.generator)
        num_free = 0
        for round_ in range(_MOST_ROUNDS):
            self.deadline.check("regions")
            free = self.judge.are_free(qs)
            if (~free).sum() <= tolerated * len(qs):
                num_free += int(free.sum())
                if num_free >= needed:
                    return faces, num_free
            else:
                num_free = 0
                retreat = _RETREAT * 2 ** (round_ // _PATIENCE)
                faces = self._separated(faces, ellipsoid, qs[~free], retreat)
                qs = self._inside(qs, faces, ellipsoid)
            qs = hit_and_run(qs, faces, ellipsoid.shape, _STEPS, self.generator)
        return None

    def _separated(
        self, faces: Faces, ellipsoid: GrowthEllipsoid, blocked: Array, retreat: float
    ) -> Faces:
        """Return faces that keep out what is blocked: old ones moved a little, and new ones."""
        walls = self._walls(ellipsoid.center, blocked)
        if len(faces[0]) > _PLENTY * len(self.lower):
            faces, walls = _moved(faces, ellipsoid.center, walls, retreat)
        walls = walls[np.argsort(ellipsoid.distances(walls), kind="stable")]
        normals = ellipsoid.normals(walls)
        room = ((walls - ellipsoid.center) * normals).sum(axis=1)
        offsets = (walls * normals).sum(axis=1) - np.minimum(retreat, 0.5 * room)
        chosen: list[int] = []
        is_left = np.ones(len(walls), dtype=bool)
        while is_left.any() and len(chosen) < _MOST_FACES:
            nearest = int(np.argmax(is_left))
            chosen.append(nearest)
            is_left &= walls @ normals[nearest] <= offsets[nearest]
            is_left[nearest] = False
        return (
            np.concatenate([faces[0], normals[chosen]]),
            np.concatenate([faces[1], offsets[chosen]]),
        )

    def _walls(self, center: Array, blocked: Array) -> Array:
        """Return what is blocked nearest to the center, on the way there, shape (k, n)."""
        near, far = np.zeros(len(blocked)), np.ones(len(blocked))
        for _ in range(_HALVINGS):
            middle = 0.5 * (near + far)
            free = self.judge.are_free(center + middle[:, None] * (blocked - center))
            near, far = np.where(free, middle, near), np.where(free, far, middle)
        return center + far[:, None] * (blocked - center)

    def _inside(self, qs: Array, faces: Faces, ellipsoid: GrowthEllipsoid) -> Array:
        """Return as many walkers, all inside: those that are, again and again, or the center."""
        kept = qs[_contains(faces, qs)]
        kept = kept if len(kept) else ellipsoid.center[None]
        return kept[np.arange(len(qs)) % len(kept)]


def _moved(faces: Faces, center: Array, walls: Array, retreat: float) -> tuple[Faces, Array]:
    """Return the faces, those moved that need not go far to keep a wall out, and the other walls.

    In many dimensions a round obstacle would need a great many faces; a little volume is cheaper.
    """
    normals, offsets = faces
    heights = walls @ normals.T
    nearest = np.argmin(offsets - heights, axis=1)
    reached = heights[np.arange(len(walls)), nearest] - retreat
    before = offsets[nearest]
    room = before - normals[nearest] @ center
    is_near = before - reached <= _SHIFT * room
    offsets = offsets.copy()
    np.minimum.at(offsets, nearest[is_near], reached[is_near])
    return (normals, offsets), walls[~is_near]


def _contains(faces: Faces, qs: Array) -> np.ndarray[Any, np.dtype[np.bool_]]:
    return (qs @ faces[0].T <= faces[1]).all(axis=1)
