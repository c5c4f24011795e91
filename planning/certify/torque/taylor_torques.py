"""Taylor torques: joint torques along short segments of a motion, as polynomials with error bounds.

Coefficients about a segment's middle come from those about the piece's break by Horner's rule: a
sum of k + 1 terms has an error below 2 (k + 1) 2^-53 of the sum of their sizes (Higham 2002,
section 5.1). `torque_remainder` propagates that error to the torques.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.certify.intervals.rounding import UNIT_ROUNDOFF
from planning.certify.intervals.taylor import expand_at
from planning.certify.torque.kernel_torques import KernelTorques
from planning.certify.torque.links import Link
from planning.certify.torque.newton_euler import TERMS, TorqueRecursion
from planning.certify.torque.torque_remainder import torque_errors
from planning.domain.curves.curve import TimedTrajectory


@dataclass(frozen=True)
class TorquePolynomials:
    """Torque polynomials of n segments.

    Attributes:
        taylor: Coefficients about the middle [N m or N per second to the power], shape (n, k, nv);
            for a rotation in space along the world's axes, else per coordinate.
        errors: Bound on the error of each coordinate's polynomial, rounding included [N m or N],
            shape (n, nv); for a rotation in space on the norm of all three, at the first.
    """

    taylor: Float64[np.ndarray, "n k nv"]
    errors: Float64[np.ndarray, "n nv"]


def torque_series(
    links: tuple[Link, ...],
    gravity: Float64[np.ndarray, "3"],
    trajectory: TimedTrajectory,
    segments: tuple[Any, Float64[np.ndarray, " n"], Float64[np.ndarray, " n"]],
    order: int = 2,
    *,
    use_kernel: bool = True,
) -> TorquePolynomials:
    """Return the torque polynomials along segments of a trajectory.

    Args:
        links: The links, parents before children.
        gravity: Gravity vector g [m/s^2].
        trajectory: The motion.
        segments: The piece of each, its middle relative to the piece's break, and half its width.
        order: Order of the derivative in the inertial terms: 2 for torques, else shares of them;
            see `newton_euler`.
        use_kernel: Whether the native kernel may be used, if it is available.
    """
    pieces, middles, halves = segments
    kernel = KernelTorques.of(links, gravity, trajectory) if use_kernel else None
    if kernel is not None:
        return TorquePolynomials(*kernel.polynomials(pieces, middles, halves, order))
    coefficients = trajectory.coefficients[pieces]
    length = max(TERMS + 3, coefficients.shape[1])
    tangents = expand_at(coefficients, middles, length)
    coefficient_errors = (
        4 * (length + 1) * UNIT_ROUNDOFF * expand_at(np.abs(coefficients), middles, length)
    )
    bases = trajectory.bases[pieces]
    taylor = TorqueRecursion(links, gravity, (tangents[:, : TERMS + 2], bases), order).run()
    errors = torque_errors(links, gravity, (tangents, bases, halves), coefficient_errors, order)
    return TorquePolynomials(taylor, errors)
