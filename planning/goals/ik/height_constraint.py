"""Constraints on heights over half spaces, of which Drake's inverse kinematics knows none."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from pydrake.autodiffutils import ExtractGradient, ExtractValue, InitializeAutoDiff

from planning.goals.ik.group_program import GroupProgram
from planning.world.collision.half_space_heights import HalfSpaceHeights
from planning.world.drake_model import DrakeModel

type Array = np.ndarray[Any, np.dtype[np.float64]]


def keep_above(program: GroupProgram, model: DrakeModel, least: Mapping[int, float]) -> None:
    """Keep pairs with half spaces apart.

    Args:
        program: What to add the constraint to.
        model: The scene.
        least: Heights to keep [m], by rows of `HalfSpacePairs`.
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
