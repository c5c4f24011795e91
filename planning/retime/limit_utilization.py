"""LimitUtilization: peak over limit of a curve's rates, bounded from above by branch and bound.

Velocity is bounded by |delta'|, which an angular velocity J_r(delta) delta' never exceeds.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from typing import Any

import numpy as np

from planning.domain.arrays import Array
from planning.domain.curves.curve import Curve, derivative
from planning.domain.robot.joints import JointLimits
from planning.kernel.native import native
from planning.retime.block_peaks import block_norms, floating_rotation_blocks
from planning.retime.limits.angular_rate_bounds import (
    has_moving_axis,
    rate_bounds,
    with_derivatives,
)
from planning.retime.polynomials import halved, norms, to_bernstein

# Largest relative excess of the bound over the true peak, unless the search is cut off.
_RELATIVE_GAP = 1e-9
# The same for moving rotation axes, where bounds converge more slowly.
_ROTATION_GAP = 1e-6
_MAX_DEPTH = 40
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


def max_utilization(curve: Curve, limits: JointLimits, order: int) -> LimitUtilization:
    """Return the largest peak over limit of the order-th derivative, over all blocks."""
    module, bounds = native(), getattr(limits, RATES[order - 1])
    if module is None or not _has_scalar_limits(limits, bounds):
        return max_block_utilization(curve, limits, order)
    return LimitUtilization(*module.utilization(curve.coefficients, curve.widths, bounds, order))


def max_block_utilization(curve: Curve, limits: JointLimits, order: int) -> LimitUtilization:
    """Return the same for blocks of any size; of single coordinates the kernel has it at once."""
    bounds = getattr(limits, RATES[order - 1])
    widths = np.diff(curve.breaks)
    moving_axes = {
        i: has_moving_axis(curve.coefficients[:, :, list(limits.blocks[i])])
        for i in (floating_rotation_blocks(curve, limits) if order > 1 else [])
    }
    polynomials = to_bernstein(derivative(curve.coefficients, order), widths)
    sizes = block_norms(polynomials, limits) / bounds
    for i, moving in moving_axes.items():
        sizes[moving, :, i] = 0.0
    best = _max_polynomial_utilization(polynomials, sizes, limits, bounds)
    for i, moving in moving_axes.items():
        if moving.any():
            indices = list(limits.blocks[i])
            deltas = with_derivatives(
                curve.coefficients[moving][:, :, indices], widths[moving], order
            )
            best = _max_rotation_utilization(
                deltas, widths[moving], (order, float(bounds[i]), i), best
            )
    return best


def _has_scalar_limits(limits: JointLimits, bounds: Array) -> bool:
    """Return whether every coordinate has a positive, finite limit of its own, in their order."""
    is_scalar = limits.blocks == tuple((i,) for i in range(len(bounds)))
    return is_scalar and all(0 < bound < inf for bound in bounds.tolist())


def max_polynomial_value(polynomials: Array) -> LimitUtilization:
    """Return the largest value of polynomials, at least zero, and the index of its column.

    Args:
        polynomials: Bernstein coefficients, shape (n, k, columns).
    """
    count = polynomials.shape[2]
    nodes = polynomials.transpose(0, 2, 1).reshape(-1, polynomials.shape[1], 1)
    columns = np.tile(np.arange(count), len(polynomials))
    return _branch_and_bound(nodes, columns, _value_bounds, _RELATIVE_GAP, LimitUtilization(0.0, 0))


def _value_bounds(nodes: Array, _: int) -> tuple[Array, Array]:
    return _norm_bounds_from_coefficients(nodes[:, :, 0])


def _max_polynomial_utilization(
    polynomials: Array, sizes: Array, limits: JointLimits, bounds: Array
) -> LimitUtilization:
    """Return the largest norm over limit, from norms of Bernstein coefficients over limits.

    Args:
        polynomials: Bernstein coefficients, shape (n, k, nv).
        sizes: Their norms by block, over the limits; zero for excluded ones.
        limits: Joint limits, for their blocks.
        bounds: Limits of the blocks.
    """
    upper, attained = _norm_bounds_from_coefficients(sizes)
    largest = int(np.argmax(attained))
    lower_bound = float(attained.flat[largest])
    is_open = upper > lower_bound * (1 + _RELATIVE_GAP)
    best = LimitUtilization(lower_bound, largest % upper.shape[1])
    if is_open.any():
        nodes, blocks = _nodes(polynomials, is_open, limits, bounds)
        module = native() if nodes.shape[2] == 1 else None
        if module is None:
            best = _branch_and_bound(nodes, blocks, _norm_bounds, _RELATIVE_GAP, best)
        else:
            best = _max_magnitude_by_kernel(module, nodes[:, :, 0], blocks, best)
    # Pieces that are not refined may exceed the attained value by the gap.
    return LimitUtilization(max(best.fraction, float(upper[~is_open].max(initial=0.0))), best.block)


def _max_magnitude_by_kernel(
    module: Any, rows: Array, blocks: Any, best: LimitUtilization
) -> LimitUtilization:
    """Return the larger of `best` and the largest magnitude of scalar polynomials, in rows."""
    tolerance = best.fraction * _RELATIVE_GAP
    bound, row, _ = module.peak(np.concatenate([rows, -rows]), tolerance)
    return max(best, LimitUtilization(bound, int(blocks[row % len(rows)])), key=_fraction)


def _fraction(utilization: LimitUtilization) -> float:
    return utilization.fraction


def _nodes(
    polynomials: Array, is_open: Any, limits: JointLimits, bounds: Array
) -> tuple[Array, Any]:
    """Return the chosen pieces of blocks over their limits, padded to one width, and the blocks."""
    pieces, blocks = np.nonzero(is_open)
    width = max(len(block) for block in limits.blocks)
    columns = np.array([[*block, *[-1] * (width - len(block))] for block in limits.blocks])[blocks]
    nodes = polynomials[pieces[:, None], :, columns] / bounds[blocks][:, None, None]
    nodes[columns < 0] = 0.0
    return nodes.transpose(0, 2, 1), blocks


def _norm_bounds_from_coefficients(sizes: Array) -> tuple[Array, Array]:
    """Return upper bounds and attained values of norms, from those of Bernstein coefficients.

    The second axis runs along the coefficients.
    """
    return sizes.max(axis=1), np.maximum(sizes[:, 0], sizes[:, -1])


def _norm_bounds(nodes: Array, _: int) -> tuple[Array, Array]:
    return _norm_bounds_from_coefficients(norms(nodes))


def _max_rotation_utilization(
    deltas: Array, widths: Array, block_limit: tuple[int, float, int], best: LimitUtilization
) -> LimitUtilization:
    """Return the larger of `best` and the utilization of a rotation block with a moving axis."""
    order, bound, block = block_limit
    # Widths halve along with the nodes: they are appended as one more row of equal coefficients.
    width_rows = np.broadcast_to(widths[:, None, None], (*deltas.shape[:2], 1))

    def bounds_of(nodes: Array, depth: int) -> tuple[Array, Array]:
        upper, attained = rate_bounds(nodes[:, :, :-1], nodes[:, 0, -1] / 2.0**depth, order)
        return upper / bound, attained / bound

    nodes = np.concatenate([deltas, width_rows], axis=2)
    return _branch_and_bound(nodes, np.full(len(nodes), block), bounds_of, _ROTATION_GAP, best)


def _branch_and_bound(
    nodes: Array,
    blocks: Any,
    bounds_of: Callable[[Array, int], tuple[Array, Array]],
    gap: float,
    best: LimitUtilization,
) -> LimitUtilization:
    """Branch and bound: halve the intervals that may exceed the largest attained value."""
    lower_bound, block, discarded_bound = best.fraction, best.block, 0.0
    for depth in range(_MAX_DEPTH):
        upper, attained = bounds_of(nodes, depth)
        largest = int(np.argmax(attained)) if len(attained) else 0
        if len(attained) and attained[largest] > lower_bound:
            lower_bound, block = float(attained[largest]), int(blocks[largest])
        is_open = upper > lower_bound * (1 + gap)
        discarded_bound = max(discarded_bound, float(upper[~is_open].max(initial=0.0)))
        if not is_open.any():
            break
        if is_open.sum() > _MAX_NODES or depth == _MAX_DEPTH - 1:
            worst = int(np.argmax(upper))
            return LimitUtilization(float(upper[worst]), int(blocks[worst]))
        nodes, blocks = halved(nodes[is_open]), np.repeat(blocks[is_open], 2)
    return LimitUtilization(max(lower_bound, discarded_bound), block)
