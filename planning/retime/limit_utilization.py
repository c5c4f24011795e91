"""LimitUtilization: peak over limit of a curve's rates, bounded from above by branch and bound.

Velocity is bounded by |delta'|, which an angular velocity J_r(delta) delta' never exceeds.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from planning.domain.arrays import Array
from planning.domain.curves.curve import Curve, derivative
from planning.domain.robot.joints import JointLimits
from planning.retime.bounds import block_norms, turning_blocks
from planning.retime.limits.angular_rate_bounds import (
    has_moving_axis,
    rate_bounds,
    with_derivatives,
)
from planning.retime.polynomials import halved, norms, to_bernstein

# Largest relative excess of the bound over the true peak, unless the search is cut off.
_GAP = 1e-9
# The same for moving rotation axes, where bounds converge more slowly.
_TURNING_GAP = 1e-6
_MAX_HALVINGS = 40
_MAX_NODES = 30_000
RATES = ("velocity", "acceleration", "jerk")


@dataclass(frozen=True)
class LimitUtilization:
    """Largest peak over limit of a curve's rates.

    Attributes:
        fraction: Upper bound on the largest peak over limit of all blocks and pieces.
        block: Index of the block with the largest one.
    """

    fraction: float
    block: int


def largest_use(curve: Curve, limits: JointLimits, order: int) -> LimitUtilization:
    """Return the largest peak over limit of the order-th derivative, over all blocks."""
    bounds = getattr(limits, RATES[order - 1])
    widths = np.diff(curve.breaks)
    turning = {
        i: has_moving_axis(curve.coefficients[:, :, list(limits.blocks[i])])
        for i in (turning_blocks(curve, limits) if order > 1 else [])
    }
    polynomials = to_bernstein(derivative(curve.coefficients, order), widths)
    sizes = block_norms(polynomials, limits) / bounds
    for i, moving in turning.items():
        sizes[moving, :, i] = 0.0
    best = _polynomial_use(polynomials, sizes, limits, bounds)
    for i, moving in turning.items():
        if moving.any():
            indices = list(limits.blocks[i])
            deltas = with_derivatives(
                curve.coefficients[moving][:, :, indices], widths[moving], order
            )
            best = _turning_use(deltas, widths[moving], (order, float(bounds[i]), i), best)
    return best


def largest_value(polynomials: Array) -> LimitUtilization:
    """Return the largest value of polynomials, at least zero, and the index of its column.

    Args:
        polynomials: Bernstein coefficients, shape (n, k, columns).
    """
    count = polynomials.shape[2]
    nodes = polynomials.transpose(0, 2, 1).reshape(-1, polynomials.shape[1], 1)
    owners = np.tile(np.arange(count), len(polynomials))
    return _search(nodes, owners, _value_bounds, _GAP, LimitUtilization(0.0, 0))


def _value_bounds(nodes: Array, _: int) -> tuple[Array, Array]:
    return _extremes(nodes[:, :, 0])


def _polynomial_use(
    polynomials: Array, sizes: Array, limits: JointLimits, bounds: Array
) -> LimitUtilization:
    """Return the largest norm over limit, from norms of Bernstein coefficients over limits.

    Args:
        polynomials: Bernstein coefficients, shape (n, k, nv).
        sizes: Their norms by block, over the limits; zero for excluded ones.
        limits: Joint limits, for their blocks.
        bounds: Limits of the blocks.
    """
    upper, attained = _extremes(sizes)
    top = int(np.argmax(attained))
    floor = float(attained.flat[top])
    keep = upper > floor * (1 + _GAP)
    best = LimitUtilization(floor, top % upper.shape[1])
    if keep.any():
        nodes, owners = _nodes(polynomials, keep, limits, bounds)
        best = _search(nodes, owners, _norm_bounds, _GAP, best)
    # Pieces that are not refined may exceed the attained value by the gap.
    return LimitUtilization(max(best.fraction, float(upper[~keep].max(initial=0.0))), best.block)


def _nodes(polynomials: Array, keep: Any, limits: JointLimits, bounds: Array) -> tuple[Array, Any]:
    """Return the chosen pieces of blocks over their limits, padded to one width, and the blocks."""
    pieces, owners = np.nonzero(keep)
    width = max(len(block) for block in limits.blocks)
    columns = np.array([[*block, *[-1] * (width - len(block))] for block in limits.blocks])[owners]
    nodes = polynomials[pieces[:, None], :, columns] / bounds[owners][:, None, None]
    nodes[columns < 0] = 0.0
    return nodes.transpose(0, 2, 1), owners


def _extremes(sizes: Array) -> tuple[Array, Array]:
    """Return upper bounds and attained values of norms, from those of Bernstein coefficients.

    The second axis runs along the coefficients.
    """
    return sizes.max(axis=1), np.maximum(sizes[:, 0], sizes[:, -1])


def _norm_bounds(nodes: Array, _: int) -> tuple[Array, Array]:
    return _extremes(norms(nodes))


def _turning_use(
    deltas: Array, widths: Array, what: tuple[int, float, int], best: LimitUtilization
) -> LimitUtilization:
    """Return the larger of `best` and the utilization of a turning block."""
    order, bound, block = what
    # Widths halve along with the nodes: they are appended as one more row of equal coefficients.
    ride = np.broadcast_to(widths[:, None, None], (*deltas.shape[:2], 1))

    def bounded(nodes: Array, depth: int) -> tuple[Array, Array]:
        upper, attained = rate_bounds(nodes[:, :, :-1], nodes[:, 0, -1] / 2.0**depth, order)
        return upper / bound, attained / bound

    nodes = np.concatenate([deltas, ride], axis=2)
    return _search(nodes, np.full(len(nodes), block), bounded, _TURNING_GAP, best)


def _search(
    nodes: Array,
    owners: Any,
    bounded: Callable[[Array, int], tuple[Array, Array]],
    gap: float,
    best: LimitUtilization,
) -> LimitUtilization:
    """Branch and bound: halve the intervals that may exceed the largest attained value."""
    floor, owner, dropped = best.fraction, best.block, 0.0
    for depth in range(_MAX_HALVINGS):
        upper, attained = bounded(nodes, depth)
        top = int(np.argmax(attained)) if len(attained) else 0
        if len(attained) and attained[top] > floor:
            floor, owner = float(attained[top]), int(owners[top])
        keep = upper > floor * (1 + gap)
        dropped = max(dropped, float(upper[~keep].max(initial=0.0)))
        if not keep.any():
            break
        if keep.sum() > _MAX_NODES or depth == _MAX_HALVINGS - 1:
            worst = int(np.argmax(upper))
            return LimitUtilization(float(upper[worst]), int(owners[worst]))
        nodes, owners = halved(nodes[keep]), np.repeat(owners[keep], 2)
    return LimitUtilization(max(floor, dropped), owner)
