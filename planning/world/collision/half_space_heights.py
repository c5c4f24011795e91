"""Gradients of heights over half spaces by the plant's positions.

The height of a shape's lowest point x over a half space with normal n is n . (x - p), and so is its
rate with n fixed in the half space: n . (v - v'), v being the velocity of the shape's point at x
and v' that of the half space's at the same place. The lowest point moves on the shape too,
which changes the height to second order only.
"""

from typing import Any

import numpy as np
from jaxtyping import Float64, Int
from pydrake.geometry import GeometryId, HalfSpace
from pydrake.multibody.tree import JacobianWrtVariable

from planning.domain.arrays import Array
from planning.world.collision.half_spaces import half_space_pairs_of
from planning.world.drake_model import DrakeModel


class HalfSpaceHeights:
    """Heights over half spaces and their gradients, in a context of its own."""

    def __init__(self, model: DrakeModel) -> None:
        """Prepare for all pairs with a half space that may collide."""
        self._model, self._pairs = model, half_space_pairs_of(model)
        self._inspector: Any = model.scene_graph.model_inspector()
        self._context: Any = model.diagram.CreateDefaultContext()
        self._plant_context = model.plant.GetMyMutableContextFromRoot(self._context)
        self._query_context = model.scene_graph.GetMyContextFromRoot(self._context)

    def heights_within(
        self, full: Float64[np.ndarray, " num_positions"], max_height: float | Array
    ) -> tuple[
        Int[np.ndarray, " m"], Float64[np.ndarray, " m"], Float64[np.ndarray, "m num_positions"]
    ]:
        """Return rows of pairs at most `max_height` high [m], their heights, and gradients by q.

        Two half spaces have no gradient, and are left out.
        """
        model = self._model
        model.plant.SetPositions(self._plant_context, full)
        query: Any = model.scene_graph.get_query_output_port().Eval(self._query_context)
        rows: list[int] = []
        heights: list[float] = []
        gradients = [np.zeros((0, model.plant.num_positions()))]
        for row, height, points in self._pairs.within(query, max_height):
            if np.isfinite(height):
                rows.append(row)
                heights.append(height)
                gradients.append(self._gradient(query, self._pairs.ids[row], points)[None])
        return np.array(rows, dtype=np.intp), np.array(heights), np.concatenate(gradients)

    def _gradient(self, query: Any, ids: tuple[GeometryId, GeometryId], points: Array) -> Array:
        a, b = ids
        is_a_flat = isinstance(self._inspector.GetShape(a), HalfSpace)
        half_space, other = (a, b) if is_a_flat else (b, a)
        lowest = points[1 if is_a_flat else 0]
        normal = query.GetPoseInWorld(half_space).rotation().matrix()[:, 2]
        return normal @ (
            self._point_jacobian(other, lowest) - self._point_jacobian(half_space, lowest)
        )

    def _point_jacobian(self, geometry: GeometryId, point: Array) -> Array:
        """Return the Jacobian of a body's point that is at p_WP now, shape (3, num_positions)."""
        plant: Any = self._model.plant
        frame = plant.GetBodyFromFrameId(self._inspector.GetFrameId(geometry)).body_frame()
        p_BP = frame.CalcPoseInWorld(self._plant_context).inverse().multiply(point)
        world = plant.world_frame()
        return plant.CalcJacobianTranslationalVelocity(
            self._plant_context, JacobianWrtVariable.kQDot, frame, p_BP, world, world
        )
