"""Minimum-distance constraints to half spaces for Drake's inverse kinematics, which has none."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from pydrake.autodiffutils import ExtractGradient, ExtractValue, InitializeAutoDiff

from planning.domain.arrays import Array
from planning.goals.ik.group_program import GroupProgram
from planning.world.collision.half_space_heights import HalfSpaceHeights
from planning.world.drake_model import DrakeModel


def keep_above(program: GroupProgram, model: DrakeModel, least: Mapping[int, float]) -> None:
    """Add a constraint that keeps geometries above half spaces by at least given heights.

    Args:
        program: Program to add the constraint to.
        model: Drake model of the scene.
        least: Least heights [m], by rows of `HalfSpacePairs`.
    """
    heights, rows = HalfSpaceHeights(model), sorted(least)

    def measured(full: Array) -> tuple[Array, Array]:
        found, values, slopes = heights.at(full, np.inf)
        order = {int(row): i for i, row in enumerate(found)}
        chosen = [order[row] for row in rows if row in order]
        return values[chosen], slopes[chosen]

    def evaluate(q: Any) -> Any:
        values, slopes = measured(ExtractValue(q).ravel() if q.dtype == object else q)
        if q.dtype != object:
            return values
        return InitializeAutoDiff(values, slopes @ ExtractGradient(q)).ravel()

    bounds = np.array([least[row] for row in rows])
    program.ik.get_mutable_prog().AddConstraint(
        evaluate, lb=bounds, ub=np.full(len(rows), np.inf), vars=program.ik.q()
    )
