"""Angular velocity bounds, and those of its derivatives, from norms of tangent derivatives.

The bounds hold for any angle. Along R(t) = R_0 exp(delta(t)) the angular velocity in the body is
omega = J(delta) delta', and the right Jacobian of SO(3) is the mean of rotations (Sola et al. 2018,
eq. 143, summed)

    J(delta) = int_0^1 exp(-s ad(delta)) ds.

A rotation has norm 1, and exp(-s ad(delta)) is a rotation whose angular velocity is no larger than
s |delta'|. Differentiating under the integral, with a, b, c, d bounds on |delta'|, |delta''|,
|delta'''|, |delta''''|:

    |J'|   <= a / 2,   |J''| <= b / 2 + a^2 / 2,   |J'''| <= c / 2 + 3 a b / 2 + 3 a^3 / 4,
    |omega|    <= a,
    |omega'|   <= b + a^2 / 2,
    |omega''|  <= c + 3 a b / 2 + a^3 / 2,
    |omega'''| <= d + 2 a c + 3 b^2 / 2 + 3 a^2 b + 3 a^4 / 4.
"""

import numpy as np
from jaxtyping import Float64


def angular_velocity_bounds(sizes: Float64[np.ndarray, "k *n"]) -> Float64[np.ndarray, "k *n"]:
    """Return bounds on |omega| and its first derivatives, one for each of the sizes.

    Args:
        sizes: Bounds on |delta'|, |delta''|, ..., up to four of them [rad/s, rad/s^2, ...].
    """
    a, b, c, d = (sizes[i] if i < len(sizes) else np.zeros_like(sizes[0]) for i in range(4))
    bounds = [
        a,
        b + a**2 / 2,
        c + 1.5 * a * b + a**3 / 2,
        d + 2 * a * c + 1.5 * b**2 + 3 * a**2 * b + 0.75 * a**4,
    ]
    return np.stack(bounds[: len(sizes)])
