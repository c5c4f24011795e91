"""IrisZo: grows a collision-free convex region around a configuration, by the IRIS-ZO algorithm.

Werner et al. (2024), "Faster algorithms for growing collision-free convex polytopes in robot
configuration space": random samples of the polytope that collide are moved toward the center of an
ellipsoid by bisection to the boundary of the obstacle; there the polytope gets a face tangent to
the scaled ellipsoid. The smaller polytope is sampled again. Then the ellipsoid becomes the largest
one inscribed. The method is zero-order: it needs only batched collision checks, no derivatives.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.planner.regions import Region
from planning.domain.request.deadline import Deadline
from planning.regions.ellipsoid import GrowthEllipsoid
from planning.regions.free_space import FreeSpace
from planning.regions.hit_and_run import hit_and_run

type Faces = tuple[Array, Array]

# Samples per batch of collision checks.
_BATCH = 1000
# Share of the samples that may collide in the iterations before the last.
_ROUGHLY = 0.01
# Hit-and-run steps of each walker between two batches, and before the first.
_STEPS = 8
_FIRST_STEPS = 40
# Bisection steps from the center to a colliding sample.
_HALVINGS = 8
# Distance of a face from the colliding point that it excludes [rad or m]; doubled every _PATIENCE
# rounds, so that growth ends where an obstacle is too round for few faces.
_RETREAT = 0.02
_PATIENCE = 15
_MOST_ROUNDS = 150
# In a polytope with more faces per dimension than _PLENTY, an existing face is moved instead of
# adding a new one if it moves by no more than the share _SHIFT of its distance to the center.
_PLENTY = 8
_SHIFT = 0.2
# Largest number of new faces per round.
_MOST_FACES = 40
# Growth factor of the ellipsoid's volume below which the iteration ends.
_GROWTH = 1.1


@dataclass(frozen=True)
class IrisZo:
    """IRIS-ZO with its parameters; `inflate` grows one region.

    Attributes:
        judge: Collision checker.
        lower: Lower bounds of the domain, shape (n,).
        upper: Upper bounds of the domain, shape (n,).
        num_free: Number of consecutive free samples that ends the growth of a region.
        iterations: Largest number of updates of the ellipsoid.
        generator: Random number generator.
        deadline: Time limit, checked in every round.
    """

    judge: FreeSpace
    lower: Array
    upper: Array
    num_free: int
    iterations: int
    generator: np.random.Generator
    deadline: Deadline

    def inflate(self, seed: Float64[np.ndarray, " n"]) -> Region | None:
        """Return a region around a free configuration, shape (n,); None if growth does not end.

        The region contains the configuration, except where the last faces pass close to it.

        Raises:
            Canceled: Cancellation was requested.
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
        """Return a polytope with faces that exclude colliding samples, and its count of free ones.

        Args:
            faces: Normals and offsets of the polytope to begin with.
            ellipsoid: Metric in which colliding samples are ordered and faces are tangent.
            needed: Number of consecutive free samples that ends the cutting.
            tolerated: Share of a batch that may collide.

        Returns:
            Normals and offsets, and the number of consecutive free samples; None if that number
            is not reached within `_MOST_ROUNDS`.
        """
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
        """Return faces that exclude colliding samples: old ones moved a little, and new ones."""
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
        """Return colliding points near the obstacle's boundary, by bisection, shape (k, n)."""
        near, far = np.zeros(len(blocked)), np.ones(len(blocked))
        for _ in range(_HALVINGS):
            middle = 0.5 * (near + far)
            free = self.judge.are_free(center + middle[:, None] * (blocked - center))
            near, far = np.where(free, middle, near), np.where(free, far, middle)
        return center + far[:, None] * (blocked - center)

    def _inside(self, qs: Array, faces: Faces, ellipsoid: GrowthEllipsoid) -> Array:
        """Return as many walkers, all inside: repeats of those inside, or of the center."""
        kept = qs[_contains(faces, qs)]
        kept = kept if len(kept) else ellipsoid.center[None]
        return kept[np.arange(len(qs)) % len(kept)]


def _moved(faces: Faces, center: Array, walls: Array, retreat: float) -> tuple[Faces, Array]:
    """Return the faces, some moved inward to exclude points, and the points left for new faces.

    A face moves only if it needs no more than the share `_SHIFT` of its distance to the center. In
    many dimensions a round obstacle would need many faces; the lost volume costs less.
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
