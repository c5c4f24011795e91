"""zone_linearizations(): a speed zone along one curve, linearized for a convex step.

Points in the box have their velocities in a ball, as those of tools are. Points at its faces and
before them have linear rows, which keep them outside as far as their speed needs: without them a
step moves fast parts of a curve into the box, where its duration is another than predicted.
"""

import numpy as np

from planning.domain.arrays import Array
from planning.refine.constraints.load import difference_quotients
from planning.refine.constraints.tool_load import tile_rows
from planning.refine.constraints.zone_load import EDGE_UNIT, ZoneLoad, ZonePathLoad
from planning.refine.curves.curve_samples import CurveSamples
from planning.refine.model.load_linearization import (
    MIN_LOAD_RATIO,
    MIN_ROW_RATIO,
    LoadLinearization,
)

# Points in the box are taken at multiples of this fraction of an interval: speeds change little
# between them.
_INSIDE_FRACTION = 0.5


def zone_linearizations(
    load: ZoneLoad, along: ZonePathLoad, samples: CurveSamples
) -> tuple[LoadLinearization, ...]:
    """Return the linearization of points in the box, and that of points at its faces.

    Args:
        load: The zone.
        along: Its load along the curve.
        samples: Both ends of all parts of the intervals.
    """
    inner, outer = load.edge_range
    reach = outer + (1 - MIN_ROW_RATIO) * EDGE_UNIT
    # Speeds are equal on both sides of a grid point.
    is_near = (along.margins[samples.grid_indices] < reach) & (samples.fractions < 1)
    near = samples.selected(np.flatnonzero(is_near))
    q, v, _ = near.motion
    kinematics = load.box.kinematics
    jacobians = kinematics.velocity_jacobians(q)[:, 3:] / load.speed
    velocities = (jacobians @ v[:, :, None])[:, :, 0]
    ratios = np.sqrt(np.sum(velocities**2, axis=1))
    margins = along.margins[near.grid_indices]
    sums, by_margin, by_ratio = load.edge_rows(margins, ratios)
    is_inside = margins <= inner
    is_fast = ratios > MIN_LOAD_RATIO
    inside = np.flatnonzero(is_inside & is_fast & (near.fractions % _INSIDE_FRACTION == 0))
    edge = np.flatnonzero(~is_inside & is_fast & (sums > MIN_ROW_RATIO))
    gradients = _velocity_gradients(load, q, v)
    none = np.zeros_like(jacobians)
    derivatives = np.stack([gradients, jacobians, none])[:, :, None]
    directions = by_ratio[edge, None] * velocities[edge] / ratios[edge, None]
    normals = by_margin[edge, None] * load.box.gradients_at(along.local[near.grid_indices[edge]])
    by_q = (directions[:, None] @ gradients[edge])[:, 0]
    by_q += load.speed * (normals[:, None] @ jacobians[edge])[:, 0]
    by_v = (directions[:, None] @ jacobians[edge])[:, 0]
    of_sums = np.stack([by_q, by_v, np.zeros_like(by_v)])[:, :, None, None]
    return (
        LoadLinearization(
            near.selected(inside), velocities[inside][:, None], derivatives[:, inside]
        ),
        LoadLinearization(
            near.selected(edge), sums[edge][:, None, None], of_sums, is_one_sided=True
        ),
    )


def _velocity_gradients(load: ZoneLoad, q: Array, v: Array) -> Array:
    """Return the derivatives of velocities over the limit by q, shape (m, 3, nq)."""
    kinematics = load.box.kinematics
    gradients = kinematics.velocity_gradients(q, v)
    if gradients is None:
        (gradients,) = difference_quotients(
            lambda at: kinematics.velocities(at, tile_rows(v, len(at))), q
        )
    return gradients / load.speed
