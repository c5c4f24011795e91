r"""Time scaling: slowing a trajectory down or speeding it up along its path within its limits.

A trajectory q(t) that is followed at t = s(clock) has, in tangent coordinates,

    v    = q'(s) s',        vdot = q''(s) s'^2 + q'(s) s''

(Siciliano et al., Robotics: Modelling, Planning and Control, section 4.2.2): s' is the path
velocity and s'' the path acceleration. A block of joints keeps its bound a if
|q'' s'^2 + q' s''| <= a, a quadratic inequality in s''. For 0 <= s' <= 1, s'' = 0 always satisfies
it where the trajectory itself keeps the bound, so step-by-step choices always leave a feasible next
step.
"""

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.robot.joints import JointLimits

# A block that moves slower than this [rad/s or m/s] does not bound s''.
_MIN_SPEED = 1e-9


def path_acceleration_bounds(
    trajectory: TimedTrajectory,
    limits: JointLimits,
    times: Float64[np.ndarray, " m"],
    path_velocities: Float64[np.ndarray, " m"],
) -> tuple[float, float]:
    """Return the least and the largest s'' [1/s] that keep the acceleration limits at all `times`.

    Where the trajectory's own acceleration exceeds a limit, that acceleration is the bound.
    The feasible set is convex in s'' and s'^2: an s'' that is feasible at two path velocities is
    feasible between them. Not guaranteed: the limits between the `times`, and jerk limits.

    Args:
        trajectory: Trajectory that is followed.
        limits: Joint limits; only `acceleration` is used, per block.
        times: Instants along the trajectory [s], shape (m,).
        path_velocities: s' at each of them, in [0, 1], shape (m,).
    """
    velocities, accelerations = trajectory.velocities(times), trajectory.accelerations(times)
    lower, upper = -np.inf, np.inf
    for bound, block in zip(limits.acceleration, limits.blocks, strict=True):
        b, c = velocities[:, list(block)], accelerations[:, list(block)]
        squared_acceleration = np.sum(c * c, axis=1)
        low, high = _quadratic_interval(
            b, c * path_velocities[:, None] ** 2, np.maximum(bound**2, squared_acceleration)
        )
        lower, upper = max(lower, low), min(upper, high)
    return lower, upper


def _quadratic_interval(b: Array, c: Array, squared_bound: Array) -> tuple[float, float]:
    """Return the interval of all x with |b x + c|^2 <= squared_bound in every row."""
    bb, bc = np.sum(b * b, axis=1), np.sum(b * c, axis=1)
    moving = bb > _MIN_SPEED**2
    if not moving.any():
        return -np.inf, np.inf
    bb, bc = bb[moving], bc[moving]
    slack = (squared_bound - np.sum(c * c, axis=1))[moving]
    root = np.sqrt(np.maximum(bc * bc + bb * slack, 0.0))
    return float(np.max((-bc - root) / bb)), float(np.min((-bc + root) / bb))


def choose_path_acceleration(
    bounds: tuple[float, float], path_velocity: float, target: float, period: float
) -> float:
    """Return the s'' [1/s] within `bounds` that brings s' as near to `target` as one period can."""
    desired = (target - path_velocity) / period
    lower, upper = min(bounds[0], 0.0), max(bounds[1], 0.0)
    return float(np.clip(desired, lower, upper))
