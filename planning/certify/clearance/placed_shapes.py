"""PlacedShapes: collision shapes at their current poses, and the slabs that separate them."""

from typing import Any

import numpy as np
from pydrake.multibody.tree import BodyIndex

from planning.certify.clearance.collision_shapes import CollisionShapes
from planning.certify.clearance.motion_bounds import MotionBounds
from planning.domain.arrays import Array, Indices
from planning.kernel.gjk import GAP_TOLERANCE, GjkResult, separation
from planning.world.drake_model import DrakeModel


class PlacedShapes:
    """Collision shapes at one configuration.

    Attributes:
        rotations: R_WB of all bodies of interest, shape (num_bodies, 3, 3).
        positions: p_WB of all bodies of interest [m], shape (num_bodies, 3).
    """

    def __init__(self, model: DrakeModel, shapes: CollisionShapes, bounds: MotionBounds) -> None:
        """Select the bodies with shapes, moving and static; `update_poses` must be called first."""
        self._plant, self._shapes = model.plant, shapes
        indices = sorted({*map(int, shapes.bodies), *map(int, bounds.joint_bodies)})
        bodies = [model.plant.get_body(BodyIndex(i)) for i in indices]
        self._moving = [body for body in bodies if bounds.chains[int(body.index())]]
        self._static_pending = [body for body in bodies if not bounds.chains[int(body.index())]]
        count = model.plant.num_bodies()
        self.rotations = np.tile(np.eye(3), (count, 1, 1))
        self.positions = np.zeros((count, 3))

    def update_poses(self, plant_context: Any) -> None:
        """Update the poses of all shapes; those of static bodies are computed only once."""
        for body in [*self._moving, *self._static_pending]:
            pose = self._plant.EvalBodyPoseInWorld(plant_context, body).GetAsMatrix34()
            index = int(body.index())
            self.rotations[index], self.positions[index] = pose[:, :3], pose[:, 3]
        self._static_pending = []
        shapes = self._shapes
        R_WB, p_wb = self.rotations[shapes.bodies], self.positions[shapes.bodies]
        self._R_WG = R_WB @ shapes.R_BG
        self._p_wg = (R_WB @ shapes.p_bg[:, :, None])[:, :, 0] + p_wb
        self._centers = (R_WB @ shapes.centers[:, :, None])[:, :, 0] + p_wb

    def sphere_distances(self, a: Indices, b: Indices) -> Array:
        """Return the distances of bounding spheres [m]; -inf for half spaces."""
        between = self._centers[a] - self._centers[b]
        return np.sqrt((between**2).sum(axis=1)) - self._shapes.radii[a] - self._shapes.radii[b]

    def slab_widths(self, a: Indices, b: Indices, n: Array) -> Array:
        """Return the widths of the separating slabs along unit vectors n, from shapes b to a [m].

        The width is -inf where n is NaN.
        """
        widths = -self._support(a, -n) - self._support(b, n)
        return np.where(np.isfinite(widths), widths, -np.inf)

    def best_axes(self, a: Indices, b: Indices) -> Array:
        """Return the best slab normal, from b to a, of both shapes' axes and the centre line."""
        between = self._centers[a] - self._centers[b]
        axes = [*np.moveaxis(self._R_WG[a], 2, 0), *np.moveaxis(self._R_WG[b], 2, 0)]
        with np.errstate(invalid="ignore"):
            normals = [between / np.linalg.norm(between, axis=1)[:, None]]
        normals += [
            np.where((axis * between).sum(axis=1)[:, None] < 0, -axis, axis) for axis in axes
        ]
        count = len(normals)
        widths = self.slab_widths(np.tile(a, count), np.tile(b, count), np.concatenate(normals))
        best = widths.reshape(count, len(a)).argmax(axis=0)
        return np.stack(normals)[best, np.arange(len(a))]

    def bound_distance(
        self, a: int, b: int, sufficient_distance: float, *, gap_tolerance: float = GAP_TOLERANCE
    ) -> GjkResult:
        """Bound the distance of two shapes from both sides [m] by GJK; see `gjk`."""
        rotations, positions, shapes = self._R_WG, self._p_wg, self._shapes

        def support(n: Array) -> Array:
            farthest = shapes.support_point(a, rotations[a], positions[a], n)
            return farthest - shapes.support_point(b, rotations[b], positions[b], -n)

        return separation(
            support, self._centers[a] - self._centers[b], sufficient_distance, gap_tolerance
        )

    def height(self, a: int, b: int) -> float:
        """Return the height of the lowest point of one shape above another, a half space [m]."""
        half_space, other = (a, b) if self._shapes.is_half_space[a] else (b, a)
        normal = self._R_WG[half_space][:, 2]
        level = normal @ self._p_wg[half_space]
        return float(-self._support(np.array([other]), -normal[None])[0] - level)

    def _support(self, rows: Indices, n: Array) -> Array:
        return self._shapes.support(rows, self._R_WG[rows], self._p_wg[rows], n)
