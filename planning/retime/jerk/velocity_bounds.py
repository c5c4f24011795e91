"""Velocity bounds: largest path speeds at both ends of cells that keep velocity limits inside.

Where |r'| is at most m times the chord rho between its ends (m from Bernstein coefficients) and
x = sdot^2 is linear in s, r'^2 x is largest where

    f(tau) = ((1 - tau) rho_0 + tau rho_1)^2 ((1 - tau) / rho_0^2 + tau / rho_1^2)

is, if x is bounded by a multiple of 1 / rho^2 at both ends. With M = max f, the bounds
x <= v^2 / (m^2 M rho^2) keep |r'|^2 x <= v^2 all the way. Where |r'| nearly vanishes at one end, M
is large, and x <= v^2 / max |r'|^2 at both ends allows more.
"""

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array


def cell_velocity_bounds(
    sizes: Float64[np.ndarray, "n k blocks"], velocity: Float64[np.ndarray, " blocks"]
) -> Float64[np.ndarray, "n 2"]:
    """Return bounds on (ds/dt)^2 at the beginning and the end of every cell.

    Args:
        sizes: Norms of the Bernstein coefficients of every block's r' on each cell.
        velocity: Velocity limits of the blocks.
    """
    first, last = sizes[:, 0], sizes[:, -1]
    level = sizes.max(axis=1) ** 2
    with np.errstate(divide="ignore", invalid="ignore"):
        excess = _chord_ratio(sizes) ** 2 * _max_chord_product(first, last)
        is_sloped = excess * first * last < level
        return np.stack(
            [
                (velocity**2 / np.where(is_sloped, excess * end**2, level)).min(axis=1)
                for end in (first, last)
            ],
            axis=1,
        )


def _chord_ratio(sizes: Array) -> Array:
    """Return m, shape (n, blocks); infinite or NaN where an end is zero."""
    if sizes.shape[1] <= 2:
        return np.ones_like(sizes[:, 0])
    fractions = np.linspace(0.0, 1.0, sizes.shape[1])[None, :, None]
    chords = sizes[:, :1] * (1 - fractions) + sizes[:, -1:] * fractions
    return (sizes / chords).max(axis=1)


def _max_chord_product(first: Array, last: Array) -> Array:
    """Return M; infinite or NaN where an end is zero."""
    ratio = last / first
    gain, loss = ratio - 1, 1 / ratio**2 - 1
    # The only stationary point of f between the ends; for equal ends it is in the middle.
    tau = (2 * gain + loss) / (-3 * gain * loss)
    tau = np.where((tau > 0) & (tau < 1), tau, 0.5)
    return np.maximum((1 + gain * tau) ** 2 * (1 + loss * tau), 1.0)
