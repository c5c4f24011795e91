"""Minimum-distance constraints to half spaces for Drake's inverse kinematics, which has none."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from pydrake.autodiffutils import ExtractGradient, ExtractValue, InitializeAutoDiff

from planning.domain.arrays import Array
from planning.goals.ik.group_program import GroupProgram
from planning.world.collision.half_space_heights import HalfSpaceHeights
from planning.world.drake_model import DrakeModel


def add_height_constraints(
    program: GroupProgram, model: DrakeModel, min_heights: Mapping[int, float]
) -> None:
    """Add a constraint that keeps geometries above half spaces by at least given heights.

    Args:
        program: Program to add the constraint to.
        model: Drake model of the scene.
        min_heights: Least heights [m], by rows of `HalfSpacePairs`.
    """
    heights, row_order = HalfSpaceHeights(model), sorted(min_heights)

    def evaluate_heights(full: Array) -> tuple[Array, Array]:
        measured_rows, values, gradients = heights.heights_within(full, np.inf)
        order = {int(row): i for i, row in enumerate(measured_rows)}
        chosen = [order[row] for row in row_order if row in order]
        return values[chosen], gradients[chosen]

    def evaluate(q: Any) -> Any:
        values, gradients = evaluate_heights(ExtractValue(q).ravel() if q.dtype == object else q)
        if q.dtype != object:
            return values
        return InitializeAutoDiff(values, gradients @ ExtractGradient(q)).ravel()

    bounds = np.array([min_heights[row] for row in row_order])
    program.ik.get_mutable_prog().AddConstraint(
        evaluate, lb=bounds, ub=np.full(len(row_order), np.inf), vars=program.ik.q()
    )
