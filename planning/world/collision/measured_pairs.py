"""Measured pairs: box and half-space pairs, whose distances are computed here and not by Drake.

Of separate boxes Drake 1.58 overstates distances now and then (docs/decisions/0006), and it
measures none of half spaces (docs/decisions/0032).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Float64
from pydrake.geometry import GeometryId

from planning.world.collision.box_pairs import BoxPairs, box_pairs_of
from planning.world.collision.half_spaces import HalfSpacePairs, half_space_pairs_of
from planning.world.collision.margins import PairMargins
from planning.world.drake_model import DrakeModel


@dataclass(frozen=True)
class GeometryDistance:
    """Signed distance of one pair of geometries, with nearest points.

    Attributes:
        ids: Drake's ids of both geometries.
        bodies: Full names of their bodies.
        distance: The signed distance [m].
        points: p_WA and p_WB of the nearest points [m], shape (2, 3).
    """

    ids: tuple[GeometryId, GeometryId]
    bodies: tuple[str, str]
    distance: float
    points: Float64[np.ndarray, "2 3"]


@dataclass(frozen=True)
class MeasuredPairs:
    """Pairs of a model that are measured here; holds no reference to the model."""

    boxes: BoxPairs
    half_spaces: HalfSpacePairs

    def uses_drake_distance(self, ids: tuple[GeometryId, GeometryId], distance: float) -> bool:
        """Return whether Drake's distance [m] is used: the penetration depth of boxes."""
        return distance <= 0 or ids not in self.boxes.row_by_ids

    def within(self, query: Any, distance: float) -> Iterator[GeometryDistance]:
        """Yield the pairs at most `distance` apart [m], at the state of `query`."""
        boxes, half_spaces = self.boxes, self.half_spaces
        for row, (length, points) in boxes.within(query, distance).items():
            yield GeometryDistance(boxes.ids[row], boxes.bodies[row], length, points)
        for row, length, points in half_spaces.within(query, distance):
            yield GeometryDistance(half_spaces.ids[row], half_spaces.bodies[row], length, points)


def measured_pairs_of(model: DrakeModel) -> MeasuredPairs:
    """Return the model's pairs that are measured here.

    Raises:
        ModelInvalid: A shape near a half space is of a kind that cannot be measured.
    """
    return MeasuredPairs(box_pairs_of(model), half_space_pairs_of(model))


class MeasuredMargins:
    """Margin check of the measured pairs; one context, made when it is first needed.

    Boxes without a margin are not checked here: Drake decides whether two boxes overlap. Half
    spaces are always checked here.
    """

    def __init__(self, model: DrakeModel, margins: PairMargins) -> None:
        """Read the margin of every pair."""
        self._model, self._pairs = model, measured_pairs_of(model)
        self._box_margins, self._half_space_margins = (
            np.array([margins.of(*pair) for pair in pairs.bodies], dtype=np.float64)
            for pairs in (self._pairs.boxes, self._pairs.half_spaces)
        )
        self._has_box_margins = bool((self._box_margins > 0).any())
        self.is_needed = self._has_box_margins or len(self._half_space_margins) > 0

    def are_satisfied(self, full: Float64[np.ndarray, " num_positions"]) -> bool:
        """Return whether all pairs keep their margins; contact with a half space is a violation."""
        if not self.is_needed:
            return True
        self._model.plant.SetPositions(self._plant_context, full)
        query = self._model.scene_graph.get_query_output_port().Eval(self._query_context)
        half_space_margins = self._half_space_margins
        for row, length, _ in self._pairs.half_spaces.within(query, half_space_margins):
            if length < half_space_margins[row] or length <= 0:
                return False
        if not self._has_box_margins:
            return True
        box_distances = self._pairs.boxes.within(query, self._box_margins)
        return all(length >= self._box_margins[row] for row, (length, _) in box_distances.items())

    @cached_property
    def _context(self) -> Any:
        return self._model.diagram.CreateDefaultContext()

    @cached_property
    def _plant_context(self) -> Any:
        return self._model.plant.GetMyMutableContextFromRoot(self._context)

    @cached_property
    def _query_context(self) -> Any:
        return self._model.scene_graph.GetMyContextFromRoot(self._context)
