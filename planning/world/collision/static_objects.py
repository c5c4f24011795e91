"""StaticObjects: objects fixed to the world, in our own tables instead of Drake's model.

A Drake model grows with the square of its bodies and of its collision shapes: SceneGraph keeps a
table of all pairs of shapes, even of those that can never move, in the model and in every context.
Static objects need none of that: the kernel has all of them, Drake gets the near ones per query
(`NearStatic`), and moving an object changes one row (docs/decisions/0034, 0072).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Float64
from pydrake.geometry import (
    Convex,
    GeometryId,
    GeometryInstance,
    Mesh,
    ProximityProperties,
)
from pydrake.math import RigidTransform

from planning.domain.arrays import Array
from planning.domain.scene.scene import SceneObject
from planning.kernel.shape import ConvexShape


@dataclass(frozen=True, eq=False)
class StaticObjects:
    """Table of the objects outside of Drake's model.

    Attributes:
        objects: The scene's objects, meshes as the copies of their files.
        ids: An id each for pairs of shapes; larger than all ids of Drake's shapes.
        drake_shapes: Their geometry as Drake's shapes.
        shapes: Their geometry as the kernel's shapes.
        poses: X_WO.
        frames: X_WF of their frames, and of the scene's frames below them.
        allowed: Pairs of bodies, one of them here, that may touch.
    """

    objects: tuple[SceneObject, ...] = ()
    ids: tuple[GeometryId, ...] = ()
    drake_shapes: tuple[Any, ...] = ()
    shapes: tuple[ConvexShape, ...] = ()
    poses: tuple[RigidTransform, ...] = ()
    frames: Mapping[str, RigidTransform] = field(default_factory=dict)
    allowed: frozenset[frozenset[str]] = frozenset()

    def __len__(self) -> int:
        """Return the number of objects."""
        return len(self.objects)

    @cached_property
    def rows(self) -> dict[str, int]:
        """Row of each object by its name."""
        return {thing.name: row for row, thing in enumerate(self.objects)}

    @cached_property
    def row_of(self) -> dict[GeometryId, int]:
        """Row of each object by its id."""
        return {identifier: row for row, identifier in enumerate(self.ids)}

    @cached_property
    def meshes(self) -> tuple[int, ...]:
        """Rows of the objects whose shape may be a file."""
        return tuple(
            i for i, shape in enumerate(self.drake_shapes) if isinstance(shape, Mesh | Convex)
        )

    @cached_property
    def balls(self) -> tuple[Float64[np.ndarray, "n 3"], Float64[np.ndarray, " n"]]:
        """Bounding balls: centres in world, and radii [m]."""
        local = [shape.ball for shape in self.shapes]
        centers = [_in_world(x, p) for x, (p, _) in zip(self.poses, local, strict=True)]
        return np.array(centers).reshape(-1, 3), np.array([radius for _, radius in local])

    def precompute(self) -> None:
        """Compute the cached properties in advance, before the first edit or query needs them."""
        _ = self.balls, self.rows, self.row_of, self.meshes

    def moved_poses(self, poses: Mapping[int, RigidTransform]) -> tuple[RigidTransform, ...]:
        """Return X_WO of all objects, with the poses of some replaced, by row."""
        moved_poses = list(self.poses)
        for row, x in poses.items():
            moved_poses[row] = x
        return tuple(moved_poses)

    def with_moved_objects(
        self,
        objects: Sequence[SceneObject],
        poses: Mapping[int, RigidTransform],
        frames: Mapping[str, RigidTransform],
    ) -> "StaticObjects":
        """Return the same objects with some of them moved.

        Args:
            objects: All of them, in the same order, from the present scene.
            poses: X_WO of the moved ones, by row.
            frames: As the attribute `frames`.
        """
        moved_poses = self.moved_poses(poses)
        after = replace(self, objects=tuple(objects), poses=moved_poses, frames=frames)
        # Reuse the cached properties that the move does not change.
        after.__dict__.update(row_of=self.row_of, rows=self.rows, meshes=self.meshes)
        centers, radii = self.balls
        centers = centers.copy()
        for row, x in poses.items():
            centers[row] = _in_world(x, self.shapes[row].ball[0])
        after.__dict__["balls"] = centers, radii
        return after

    def geometry_instance(self, row: int) -> GeometryInstance:
        """Return an object as Drake's geometry instance, with the same id each time."""
        instance = self._instances.get(row)
        if instance is None:
            instance = GeometryInstance(self.poses[row], self.drake_shapes[row], f"standing_{row}")
            instance.set_proximity_properties(ProximityProperties())
            self._instances[row] = instance
            self.drake_rows[instance.id()] = row
        return instance

    @cached_property
    def drake_rows(self) -> dict[GeometryId, int]:
        """Row by Drake's id, of the objects that were registered with Drake."""
        return {}

    @cached_property
    def _instances(self) -> dict[int, GeometryInstance]:
        return {}


def _in_world(x: RigidTransform, p: Array) -> Array:
    """Return a point in world; most are their frame's origin, which needs no product."""
    p_W: Array = x.multiply(p) if p.any() else x.translation()
    return p_W
