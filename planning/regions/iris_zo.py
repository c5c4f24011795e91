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
_BATCH_SIZE = 1000
# Share of the samples that may collide in the iterations before the last.
_ROUGH_COLLISION_FRACTION = 0.01
# Hit-and-run steps of each walker between two batches, and before the first.
_WALK_STEPS = 8
_FIRST_WALK_STEPS = 40
# Bisection steps from the center to a colliding sample.
_BISECTION_STEPS = 8
# Distance of a face from the colliding point that it excludes [rad or m]; it doubles after every
# _ROUNDS_PER_DOUBLING rounds, so that growth ends where an obstacle is too round for few faces.
_CONFIGURATION_SPACE_MARGIN = 0.02
_ROUNDS_PER_DOUBLING = 15
_MAX_ROUNDS = 150
# In a polytope with more than _MANY_FACES_PER_DIMENSION faces, an existing face is moved instead of
# adding a new one if it moves by at most the share _MAX_FACE_SHIFT of its distance to the center.
_MANY_FACES_PER_DIMENSION = 8
_MAX_FACE_SHIFT = 0.2
# Largest number of new faces per round.
_MAX_NEW_FACES = 40
# Growth factor of the ellipsoid's volume below which the iteration ends.
_MIN_VOLUME_GROWTH = 1.1


@dataclass(frozen=True)
class IrisZo:
    """IRIS-ZO with its parameters; `inflate` grows one region.

    Attributes:
        checker: Collision checker.
        lower: Lower bounds of the domain, shape (n,).
        upper: Upper bounds of the domain, shape (n,).
        num_free: Number of consecutive free samples that ends the growth of a region.
        iterations: Largest number of updates of the ellipsoid.
        generator: Random number generator.
        deadline: Time limit, checked in every round.
    """

    checker: FreeSpace
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
        ellipsoid, rough_faces = GrowthEllipsoid.ball(seed), None
        for _ in range(self.iterations):
            result = self._exclude_collisions(
                self._domain, ellipsoid, self.num_free // 20, _ROUGH_COLLISION_FRACTION
            )
            if result is None or (
                rough_faces is not None and not _contains(result[0], seed[None])[0]
            ):
                break
            rough_faces = result[0]
            largest = GrowthEllipsoid.inscribed(*rough_faces)
            is_grown = largest.log_volume > ellipsoid.log_volume + np.log(_MIN_VOLUME_GROWTH)
            if not (is_grown and self.checker.are_free(largest.center[None])[0]):
                break
            ellipsoid = largest
        if rough_faces is None:
            return None
        result = self._exclude_collisions(rough_faces, ellipsoid, self.num_free, 0.0)
        return None if result is None else Region(*result[0], ellipsoid.center, result[1])

    @property
    def _domain(self) -> Faces:
        identity = np.eye(len(self.lower))
        return np.concatenate([identity, -identity]), np.concatenate([self.upper, -self.lower])

    def _exclude_collisions(
        self,
        faces: Faces,
        ellipsoid: GrowthEllipsoid,
        required_free: int,
        max_collision_fraction: float,
    ) -> tuple[Faces, int] | None:
        """Return a polytope with faces that exclude colliding samples, and its count of free ones.

        Args:
            faces: Normals and offsets of the polytope to begin with.
            ellipsoid: Metric in which colliding samples are ordered and faces are tangent.
            required_free: Number of consecutive free samples that ends the cutting.
            max_collision_fraction: Share of a batch that may collide.

        Returns:
            Normals and offsets, and the number of consecutive free samples; None if that number
            is not reached within `_MAX_ROUNDS`.
        """
        origin = np.repeat(ellipsoid.center[None], _BATCH_SIZE, axis=0)
        qs = hit_and_run(origin, faces, ellipsoid.shape, _FIRST_WALK_STEPS, self.generator)
        num_free = 0
        for round_ in range(_MAX_ROUNDS):
            self.deadline.check("regions")
            is_free = self.checker.are_free(qs)
            if (~is_free).sum() <= max_collision_fraction * len(qs):
                num_free += int(is_free.sum())
                if num_free >= required_free:
                    return faces, num_free
            else:
                num_free = 0
                margin = _CONFIGURATION_SPACE_MARGIN * 2 ** (round_ // _ROUNDS_PER_DOUBLING)
                faces = self._separating_faces(faces, ellipsoid, qs[~is_free], margin)
                qs = self._walkers_inside(qs, faces, ellipsoid)
            qs = hit_and_run(qs, faces, ellipsoid.shape, _WALK_STEPS, self.generator)
        return None

    def _separating_faces(
        self, faces: Faces, ellipsoid: GrowthEllipsoid, colliding: Array, margin: float
    ) -> Faces:
        """Return faces that exclude colliding samples: old ones moved a little, and new ones."""
        boundary_points = self._boundary_points(ellipsoid.center, colliding)
        if len(faces[0]) > _MANY_FACES_PER_DIMENSION * len(self.lower):
            faces, boundary_points = _move_faces(faces, ellipsoid.center, boundary_points, margin)
        order = np.argsort(ellipsoid.distances(boundary_points), kind="stable")
        boundary_points = boundary_points[order]
        normals = ellipsoid.normals(boundary_points)
        center_distances = ((boundary_points - ellipsoid.center) * normals).sum(axis=1)
        offsets = (boundary_points * normals).sum(axis=1) - np.minimum(
            margin, 0.5 * center_distances
        )
        chosen: list[int] = []
        is_remaining = np.ones(len(boundary_points), dtype=bool)
        while is_remaining.any() and len(chosen) < _MAX_NEW_FACES:
            nearest = int(np.argmax(is_remaining))
            chosen.append(nearest)
            is_remaining &= boundary_points @ normals[nearest] <= offsets[nearest]
            is_remaining[nearest] = False
        return (
            np.concatenate([faces[0], normals[chosen]]),
            np.concatenate([faces[1], offsets[chosen]]),
        )

    def _boundary_points(self, center: Array, colliding: Array) -> Array:
        """Return colliding points near the obstacle's boundary, by bisection, shape (k, n)."""
        near, far = np.zeros(len(colliding)), np.ones(len(colliding))
        for _ in range(_BISECTION_STEPS):
            middle = 0.5 * (near + far)
            is_free = self.checker.are_free(center + middle[:, None] * (colliding - center))
            near, far = np.where(is_free, middle, near), np.where(is_free, far, middle)
        return center + far[:, None] * (colliding - center)

    def _walkers_inside(self, qs: Array, faces: Faces, ellipsoid: GrowthEllipsoid) -> Array:
        """Return as many walkers, all inside: copies of those that are inside, or of the center."""
        inside = qs[_contains(faces, qs)]
        inside = inside if len(inside) else ellipsoid.center[None]
        return inside[np.arange(len(qs)) % len(inside)]


def _move_faces(
    faces: Faces, center: Array, boundary_points: Array, margin: float
) -> tuple[Faces, Array]:
    """Return the faces, some moved inward to exclude points, and the points left for new faces.

    A face moves only if it needs no more than the share `_MAX_FACE_SHIFT` of its distance to the
    center. In many dimensions a round obstacle would need many faces; the lost volume costs less.
    """
    normals, offsets = faces
    heights = boundary_points @ normals.T
    nearest = np.argmin(offsets - heights, axis=1)
    new_offsets = heights[np.arange(len(boundary_points)), nearest] - margin
    old_offsets = offsets[nearest]
    center_distances = old_offsets - normals[nearest] @ center
    is_near = old_offsets - new_offsets <= _MAX_FACE_SHIFT * center_distances
    offsets = offsets.copy()
    np.minimum.at(offsets, nearest[is_near], new_offsets[is_near])
    return (normals, offsets), boundary_points[~is_near]


def _contains(faces: Faces, qs: Array) -> np.ndarray[Any, np.dtype[np.bool_]]:
    return (qs @ faces[0].T <= faces[1]).all(axis=1)
