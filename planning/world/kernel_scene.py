"""KernelScene: a loaded world in the native kernel."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from jaxtyping import Bool, Float64
from pydrake.geometry import GeometryId, Role
from pydrake.math import RigidTransform
from pydrake.multibody.tree import BodyIndex
from pydrake.planning import RobotDiagram

from planning.kernel.covering import Covering, cached_covering
from planning.kernel.native import native
from planning.kernel.shape import ConvexShape, ShapeKind
from planning.world.convex_shapes import convex_shape
from planning.world.drake_model import DrakeModel
from planning.world.kernel_tree import add_tree, flat_transform
from planning.world.link_tree import WORLD, link_tree
from planning.world.margins import PairMargins
from planning.world.mesh_files import cache_folder

# The kernel's numbers for kinds of shapes (shape.hpp).
_KINDS = tuple(ShapeKind)
_NONE = Covering(np.zeros((0, 4)), np.zeros((0, 4)), np.zeros(4), 0.0)


@dataclass(frozen=True)
class KernelScene:
    """Never leaves the process, as a DrakeModel.

    Attributes:
        native: The kernel's Scene.
        pairs: Both geometries of every pair that may collide, in the kernel's order.
        bodies: Full names of their bodies.
        is_of_one_robot: Whether both belong to one robot, shape (num_pairs,).
        links: For every body's index, its link and X_LB.
    """

    native: Any
    pairs: tuple[tuple[GeometryId, GeometryId], ...]
    bodies: tuple[tuple[str, str], ...]
    is_of_one_robot: Bool[np.ndarray, " num_pairs"]
    links: dict[int, tuple[int, RigidTransform]]

    def demands(self, margins: PairMargins) -> Float64[np.ndarray, " num_pairs"]:
        """Return the margin of every pair [m]; as `PairMargins.of`, but of all pairs at once."""
        demanded = np.where(self.is_of_one_robot, 0.0, margins.default)
        for names, margin in margins.by_pair.items():
            demanded[self._rows.get(names, [])] = margin
        return demanded

    @cached_property
    def _rows(self) -> dict[tuple[str, str], list[int]]:
        rows: dict[tuple[str, str], list[int]] = {}
        for row, (a, b) in enumerate(self.bodies):
            rows.setdefault((min(a, b), max(a, b)), []).append(row)
        return rows


_made: WeakKeyDictionary[RobotDiagram, KernelScene | None] = WeakKeyDictionary()


def kernel_scene_of(model: DrakeModel) -> KernelScene | None:
    """Return the model in the kernel, making it the first time only.

    None if the model shall do without, or as `kernel_scene` says.
    """
    if not model.uses_kernel:
        return None
    if model.diagram not in _made:
        _made[model.diagram] = kernel_scene(model)
    return _made[model.diagram]


def kernel_scene(model: DrakeModel) -> KernelScene | None:
    """Return the model in the kernel.

    None if there is no kernel, or if the model has a joint or a shape that it does not know: Drake
    alone answers then.
    """
    module, tree = native(), link_tree(model)
    if module is None or tree is None:
        return None
    inspector = model.scene_graph.model_inspector()
    ids: list[GeometryId] = sorted(inspector.GetAllGeometryIds(Role.kProximity))
    shapes = [convex_shape(inspector.GetShape(i)) for i in ids]
    if None in shapes:
        return None
    scene = module.Scene(model.plant.num_positions(), model.plant.num_velocities())
    add_tree(scene, model, tree)
    owners: dict[GeometryId, Any] = {
        i: model.plant.GetBodyFromFrameId(inspector.GetFrameId(i)).index() for i in ids
    }
    for i, shape in zip(ids, shapes, strict=True):
        assert shape is not None  # noqa: S101  (looked at above)
        link, x_lb = tree.bodies[int(owners[i])]
        _add_geometry(scene, link, x_lb.multiply(inspector.GetPoseInFrame(i)), shape)
    row = {i: k for k, i in enumerate(ids)}
    pairs: list[tuple[GeometryId, GeometryId]] = sorted(inspector.GetCollisionCandidates())
    for a, b in pairs:
        scene.add_pair(row[a], row[b])
    bodies = tuple((_name(model, owners[a]), _name(model, owners[b])) for a, b in pairs)
    bare = PairMargins(1.0, owners=model.owners)
    return KernelScene(
        native=scene,
        pairs=tuple(pairs),
        bodies=bodies,
        is_of_one_robot=np.array([bare.are_of_one_robot(*pair) for pair in bodies], dtype=bool),
        links=tree.bodies,
    )


def _add_geometry(scene: Any, link: int, x_lg: RigidTransform, shape: ConvexShape) -> None:
    # Of what never moves the kernel takes the exact shape.
    if link == WORLD or shape.kind is ShapeKind.HALF_SPACE:
        covering = _NONE
    else:
        covering = cached_covering(shape, cache_folder() / "coverings")
    scene.add_geometry(
        link,
        flat_transform(x_lg),
        _KINDS.index(shape.kind),
        shape.size,
        shape.vertices,
        shape.planes,
        covering.outer,
        covering.inner,
        covering.bound,
    )


def _name(model: DrakeModel, body: BodyIndex) -> str:
    return model.body_names.get(body, model.plant.get_body(body).name())
