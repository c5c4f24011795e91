"""path_duration_bound(): a lower bound of what retiming a curve gives, without retiming it.

Every coordinate by itself: from rest it needs its time to have moved as far as a sample of the
curve, and between two samples that of their distance at its velocity limit. What is in between, and
how coordinates share one path, is left out, so that it is a lower bound.
"""

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.curves.curve import JointSpline
from planning.domain.request.options import RetimeOptions
from planning.domain.robot.joints import JointLimits
from planning.domain.robot.manifold import Manifold
from planning.kernel.native import native
from planning.retime.retimer import RETIMERS
from planning.retime.smooth_pieces import smooth_pieces

# Number of steps between samples of each smooth piece.
_NUM_STEPS = 64
# Limit that stands for none [1/s and powers], and for one of zero: what has it cannot be timed.
_MAX_RATE = 1e6
# Share of the bound that rounding, and a limit that is exceeded by a tolerance, may cost.
_TOLERANCE = 1e-6


def path_duration_bound(spline: JointSpline, limits: JointLimits, options: RetimeOptions) -> float:
    """Return a lower bound of the duration that `retime` finds for a curve [s].

    Args:
        spline: The curve; at corners the motion rests.
        limits: Joint limits, unscaled, as for `retime`.
        options: Method and factors.
    """
    scaled = limits.scaled(options.velocity_scale, options.acceleration_scale)
    smoothness = RETIMERS[options.method].smoothness
    rates = _positive_rates(scaled, limits_jerk=options.limits_jerk)
    module, terms = native(), spline.coefficients.shape[1]
    is_scalar = len(scaled.blocks) == spline.coefficients.shape[2]
    if module is not None and spline.manifold.is_vector_space and is_scalar and terms > 1:
        path = spline.breaks, spline.coefficients
        bound = float(module.duration_bound(path, spline.bases, np.stack(rates), smoothness))
    else:
        pieces = smooth_pieces(spline, smoothness)
        bound = float(piece_bounds(spline, pieces, scaled, rates).sum())
    return bound * (1 - _TOLERANCE)


def _positive_rates(limits: JointLimits, *, limits_jerk: bool) -> tuple[Array, Array, Array]:
    """Return limits of velocity, acceleration and jerk, none of them zero."""
    velocity, acceleration, jerk = (
        np.where(rates > 0, np.minimum(rates, _MAX_RATE), _MAX_RATE)
        for rates in (limits.velocity, limits.acceleration, limits.jerk)
    )
    return velocity, acceleration, jerk if limits_jerk else np.full_like(jerk, np.inf)


def piece_bounds(
    spline: JointSpline,
    pieces: list[JointSpline],
    limits: JointLimits,
    rates: tuple[Array, Array, Array],
) -> Float64[np.ndarray, " pieces"]:
    """Return lower bounds of the durations of smooth pieces, each from rest to rest [s].

    Args:
        spline: The curve.
        pieces: Its smooth pieces.
        limits: Joint limits, for their blocks.
        rates: Largest velocity, acceleration and jerk of every block, positive.
    """
    edges = np.array([(piece.breaks[0], piece.breaks[-1]) for piece in pieces])
    s = np.linspace(edges[:, 0], edges[:, 1], _NUM_STEPS + 1)
    q = spline.positions(s.ravel()).reshape(*s.shape, -1)
    steps = (_block_distances(spline, limits, q[1:], q[:-1]) / rates[0]).max(axis=2)
    times = np.concatenate([np.zeros((1, len(pieces))), np.cumsum(steps, axis=0)])
    ends = np.stack([q[:1], q[-1:]])
    moved = _block_distances(spline, limits, np.stack([q, q]), ends)
    from_rest, to_rest = durations_from_rest(moved, *rates).max(axis=3)
    # The bound to a sample is its own, or that of one before it and the steps from there.
    before = times + np.maximum.accumulate(from_rest - times)
    after = np.maximum.accumulate((to_rest + times)[::-1])[::-1] - times
    return (before + after).max(axis=0)


def _block_distances(
    curve: JointSpline, limits: JointLimits, to: Array, origin: Array
) -> Float64[np.ndarray, "*n blocks"]:
    """Return how far each block of coordinates is from other configurations [rad or m]."""
    moved = Manifold.of(curve.joints).minus(to, origin)
    if len(limits.blocks) == moved.shape[-1]:
        return np.abs(moved)
    return np.stack([np.linalg.norm(moved[..., list(b)], axis=-1) for b in limits.blocks], axis=-1)


def durations_from_rest(
    distances: Float64[np.ndarray, "*n k"],
    velocity: Float64[np.ndarray, " k"],
    acceleration: Float64[np.ndarray, " k"],
    jerk: Float64[np.ndarray, " k"],
) -> Float64[np.ndarray, "*n k"]:
    """Return the least times from rest without acceleration to a distance, at any speed there [s].

    Full jerk, then full acceleration, then full speed, which is taken to follow at once.

    Args:
        distances: [rad or m], not negative.
        velocity: Limits [rad/s or m/s], finite.
        acceleration: Limits [rad/s^2 or m/s^2], finite.
        jerk: Limits [rad/s^3 or m/s^3]; infinite for none.
    """
    jerk_time = np.minimum(acceleration / jerk, np.sqrt(2 * velocity / jerk))
    speed = np.where(jerk_time > 0, velocity.clip(max=acceleration * jerk_time / 2), 0.0)
    jerk_distance = speed * jerk_time / 3
    ramp_time = (velocity - speed) / acceleration
    ramp_distance = ramp_time * (speed + velocity) / 2
    in_ramp = (distances - jerk_distance).clip(min=0.0, max=ramp_distance)
    at_speed = (distances - jerk_distance - ramp_distance).clip(min=0.0)
    in_jerk = np.cbrt(6 * np.minimum(distances, jerk_distance) / jerk)
    # The root that does not cancel where the distance is small against the speed.
    root = np.sqrt(speed**2 + 2 * acceleration * in_ramp)
    ramp_share = 2 * in_ramp / np.maximum(root + speed, 1e-300)
    return in_jerk + ramp_share + at_speed / velocity
