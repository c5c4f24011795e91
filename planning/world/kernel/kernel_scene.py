"""KernelScene: collision geometry and pairs of a loaded world in the native kernel."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from jaxtyping import Bool, Float64, Int64
from pydrake.geometry import GeometryId
from pydrake.math import RigidTransform

from planning.domain.arrays import Array
from planning.kernel.coverings.covering import Covering, cached_covering
from planning.kernel.native import native
from planning.kernel.shape import ConvexShape, ShapeKind
from planning.world.collision.collision_pairs import CollisionPairs, collision_pairs_of
from planning.world.collision.margins import PairMargins
from planning.world.collision.static_objects import StaticObjects
from planning.world.drake_model import DrakeModel
from planning.world.files.mesh_files import cache_folder
from planning.world.kernel.convex_shapes import convex_shape
from planning.world.kernel.kernel_tree import add_tree, flat_transform
from planning.world.kernel.link_tree import WORLD, link_tree

# Difference of kinematics in the kernel and in Drake, and more [m].
_ROUNDING = 1e-9
# Number of cached margins of all pairs.
_MAX_MARGINS = 16
_EMPTY_COVERING = Covering(np.zeros((0, 4)), np.zeros((0, 4)), np.zeros(4), 0.0)


@dataclass(frozen=True)
class KernelScene:
    """Loaded world in the kernel. Never leaves the process, as a DrakeModel.

    Attributes:
        native: The kernel's Scene.
        candidates: All pairs that may collide, in the kernel's order.
        is_of_one_robot: Whether both belong to one robot, shape (num_pairs,).
        links: For every body's index, its link and X_LB.
    """

    native: Any
    candidates: CollisionPairs
    is_of_one_robot: Bool[np.ndarray, " num_pairs"]
    links: dict[int, tuple[int, RigidTransform]]

    @property
    def pairs(self) -> tuple[tuple[GeometryId, GeometryId], ...]:
        """Both geometries of every pair, in the kernel's order."""
        return self.candidates.pairs

    @property
    def bodies(self) -> tuple[tuple[str, str], ...]:
        """Full names of both bodies of every pair."""
        return self.candidates.pair_names

    def pair(self, row: int | np.int64) -> tuple[GeometryId, GeometryId]:
        """Return both geometries of one pair."""
        a, b = self.candidates.rows[row]
        return self.candidates.ids[a], self.candidates.ids[b]

    def names(self, row: int | np.int64) -> tuple[str, str]:
        """Return the full names of their bodies."""
        a, b = self.candidates.rows[row]
        return self.candidates.names[a], self.candidates.names[b]

    def has_near_pair(self, full: Float64[np.ndarray, " num_positions"], distance: float) -> bool:
        """Return whether any pair may be nearer than a distance [m]; if not, none is."""
        return self.native.has_near_pair(full, distance)

    def near_objects(
        self, full: Float64[np.ndarray, " num_positions"], distance: float
    ) -> Int64[np.ndarray, " n"]:
        """Return the rows of objects outside of Drake's model that may be near a moving shape.

        None that is left out is within the distance [m].
        """
        first = self.candidates.num_drake_shapes
        return self.native.near_geometries(full, first, distance + _ROUNDING)

    def pair_margins(self, margins: PairMargins) -> Float64[np.ndarray, " num_pairs"]:
        """Return the margin of every pair [m]; as `PairMargins.of`, but of all pairs at once."""
        key = margins.default, tuple(margins.by_pair.items()), tuple(margins.owners.items())
        found = self._margins_of_pairs.get(key)
        if found is None:
            if len(self._margins_of_pairs) >= _MAX_MARGINS:
                self._margins_of_pairs.clear()
            # No margin within one robot; `of` for the exceptions alone.
            found = np.where(self.is_of_one_robot, 0.0, margins.default)
            for pair in margins.by_pair:
                found[self._rows_by_names.get(pair, [])] = margins.of(*pair)
            found.setflags(write=False)
            self._margins_of_pairs[key] = found
        return found

    @cached_property
    def _margins_of_pairs(self) -> dict[tuple[Any, ...], Array]:
        """Margins of all pairs by what they depend on: search and proof ask for the same."""
        return {}

    def by_pair(
        self, value: Callable[[str, str], float], exceptions: Collection[tuple[str, str]]
    ) -> Float64[np.ndarray, " num_pairs"]:
        """Return a number for every pair of bodies, by a function of their full names.

        Args:
            value: The number; the same for all pairs of one robot, and the same for all others.
            exceptions: Pairs, by names in sorted order, whose number may differ.
        """
        names = set(exceptions)
        numbers = np.full(len(self.is_of_one_robot), np.nan)
        for kind in (self.is_of_one_robot, ~self.is_of_one_robot):
            rows: Any = np.flatnonzero(kind)  # mostly the first pair is a typical one
            typical_pair = next(
                (pair for pair in map(self.names, rows) if (min(pair), max(pair)) not in names),
                None,
            )
            if typical_pair is not None:
                numbers[kind] = value(*typical_pair)
        for pair in names:
            numbers[self._rows_by_names.get(pair, [])] = value(*pair)
        return numbers

    @cached_property
    def _rows_by_names(self) -> dict[tuple[str, str], list[int]]:
        rows: dict[tuple[str, str], list[int]] = {}
        for row, (a, b) in enumerate(self.bodies):
            rows.setdefault((min(a, b), max(a, b)), []).append(row)
        return rows


_cache: WeakKeyDictionary[StaticObjects, KernelScene | None] = WeakKeyDictionary()


def kernel_scene_of(model: DrakeModel) -> KernelScene | None:
    """Return the model in the kernel, cached by model.

    None if the model does not use the kernel, or as of `kernel_scene`.
    """
    if not model.uses_kernel:
        return None
    if model.static_objects not in _cache:
        _cache[model.static_objects] = kernel_scene(model)
    return _cache[model.static_objects]


def copy_kernel_scene(before: DrakeModel, after: DrakeModel, rows: Sequence[int]) -> None:
    """Copy the kernel scene of one model to another, with some `static_objects` moved."""
    scene = kernel_scene_of(before)
    if scene is None:
        _cache[after.static_objects] = None
        return
    first = collision_pairs_of(before).num_drake_shapes
    geometries = np.array([first + row for row in rows], dtype=np.int64)
    flat = [flat_transform(after.static_objects.poses[row]) for row in rows]
    moved = scene.native.with_poses(geometries, np.array(flat, dtype=np.float64).reshape(-1, 12))
    _cache[after.static_objects] = replace(scene, native=moved)


def kernel_scene(model: DrakeModel) -> KernelScene | None:
    """Return the model in the kernel.

    None if there is no kernel, or if the model has a joint or a shape that it does not have: Drake
    alone decides then.
    """
    module, tree = native(), link_tree(model)
    if module is None or tree is None:
        return None
    inspector: Any = model.scene_graph.model_inspector()
    candidates, static_objects = collision_pairs_of(model), model.static_objects
    ids = candidates.ids[: candidates.num_drake_shapes]
    shapes = [convex_shape(inspector.GetShape(i)) for i in ids]
    if None in shapes:
        return None
    scene = module.Scene(model.plant.num_positions(), model.plant.num_velocities())
    folder = cache_folder() / "coverings"
    add_tree(scene, model, tree)
    for i, body, shape in zip(ids, candidates.bodies, shapes, strict=False):
        assert shape is not None  # noqa: S101  (checked above)
        link, x_lb = tree.bodies[int(body)]
        _add_geometry(scene, link, x_lb.multiply(inspector.GetPoseInFrame(i)), shape, folder)
    for x, shape in zip(static_objects.poses, static_objects.shapes, strict=True):
        _add_geometry(scene, WORLD, x, shape, folder)
    scene.add_pairs(candidates.rows.astype(np.int64).ravel())
    margins = PairMargins(1.0, owners=model.owners)
    robots = margins.robots_of(candidates.names)
    a, b = robots[candidates.rows].T
    return KernelScene(
        native=scene,
        candidates=candidates,
        is_of_one_robot=(a == b) & (a >= 0),
        links=tree.bodies,
    )


def _add_geometry(
    scene: Any, link: int, x_lg: RigidTransform, shape: ConvexShape, coverings: Path
) -> None:
    module: Any = native()
    # Static objects have their exact shape in the kernel.
    if link == WORLD or shape.kind is ShapeKind.HALF_SPACE:
        covering = _EMPTY_COVERING
    else:
        covering = cached_covering(shape, coverings)
    scene.add_geometry(
        link,
        flat_transform(x_lg),
        module.ShapeKind[shape.kind.name],
        shape.size,
        shape.vertices,
        shape.planes,
        covering.outer,
        covering.inner,
        covering.bound,
    )
