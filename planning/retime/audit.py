"""How much of its limits a curve uses, bounded from above by branch and bound.

Velocity is bounded by |delta'|, which an angular velocity J_r(delta) delta' never exceeds.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from planning.domain.curve import Curve, derivative
from planning.domain.joints import JointLimits
from planning.retime.bounds import turning_blocks
from planning.retime.polynomials import halved, norms, to_bernstein
from planning.retime.turning import has_moving_axis, rate_bounds, with_derivatives

type Array = np.ndarray[Any, np.dtype[np.float64]]

# The bound exceeds the true peak by at most this, relatively, unless the search is cut off.
_GAP = 1e-9
# Where rotation axes move, bounds converge more slowly.
_TURNING_GAP = 1e-6
_MAX_HALVINGS = 40
_MAX_NODES = 30_000
RATES = ("velocity", "acceleration", "jerk")


@dataclass(frozen=True)
class Use:
    """Peak over limit.

    Attributes:
        fraction: An upper bound on the largest, over all blocks and pieces.
        block: The index of the block that has it.
    """

    fraction: float
    block: int


def largest_use(curve: Curve, limits: JointLimits, order: int) -> Use:
    """Return the largest peak over limit of the order-th derivative."""
    bounds = getattr(limits, RATES[order - 1])
    widths = np.diff(curve.breaks)
    turning = {
        i: has_moving_axis(curve.coefficients[:, :, list(limits.blocks[i])])
        for i in (turning_blocks(curve, limits) if order > 1 else [])
    }
    polynomials = to_bernstein(derivative(curve.coefficients, order), widths)
    rows, owners = _rows(polynomials, limits, bounds, turning)
    best = _search(rows, owners, _norm_bounds, _GAP, Use(0.0, 0))
    for i, moving in turning.items():
        if moving.any():
            indices = list(limits.blocks[i])
            deltas = with_derivatives(
                curve.coefficients[moving][:, :, indices], widths[moving], order
            )
            best = _turning_use(deltas, widths[moving], (order, float(bounds[i]), i), best)
    return best


def _rows(
    polynomials: Array, limits: JointLimits, bounds: Array, turning: dict[int, Any]
) -> tuple[Array, Any]:
    """Return every piece of every block over its limit, padded to one width, and whose it is."""
    width = max(len(block) for block in limits.blocks)
    stacked: list[Array] = []
    for i, block in enumerate(limits.blocks):
        part = polynomials[:, :, list(block)] / bounds[i]
        if i in turning:
            part = part[~turning[i]]
        padded = np.zeros((*part.shape[:2], width))
        padded[:, :, : len(block)] = part
        stacked.append(padded)
    owners = np.repeat(np.arange(len(stacked)), [len(part) for part in stacked])
    return np.concatenate(stacked), owners


def _norm_bounds(nodes: Array, _: int) -> tuple[Array, Array]:
    sizes = norms(nodes)
    return sizes.max(axis=1), np.maximum(sizes[:, 0], sizes[:, -1])


def _turning_use(deltas: Array, widths: Array, what: tuple[int, float, int], best: Use) -> Use:
    """Return the larger of `best` and the use of a turning block."""
    order, bound, block = what
    # Widths halve along with the nodes; they ride as one more row of equal coefficients.
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
    best: Use,
) -> Use:
    """Halve the intervals that may hold more than the largest value seen, until none is left."""
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
            return Use(float(upper[worst]), int(owners[worst]))
        nodes, owners = halved(nodes[keep]), np.repeat(owners[keep], 2)
    return Use(max(floor, dropped), owner)
