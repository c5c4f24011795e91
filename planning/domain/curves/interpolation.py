"""Interpolation: trajectories through samples, as cubic, quintic or linear polynomial pieces.

Between two samples a polynomial meets the given values at both: of degree 5 if accelerations are
given, of degree 3 if velocities are. Of positions alone it is the cubic spline with continuous
acceleration that rests at both ends (de Boor, "A Practical Guide to Splines", 2001, chapter IV),
or, on request, the straight line.
"""

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.robot.joints import Joint, JointType
from planning.domain.robot.manifold import Manifold
from planning.errors import ProblemInvalid


def trajectory_through(
    joints: tuple[Joint, ...],
    times: Float64[np.ndarray, " n"],
    positions: Float64[np.ndarray, "n nq"],
    velocities: Float64[np.ndarray, "n nv"] | None = None,
    accelerations: Float64[np.ndarray, "n nv"] | None = None,
) -> TimedTrajectory:
    """Return the trajectory through samples; positions are real numbers, not angles on a circle.

    From 3 rad to -3 rad is a displacement of -6 rad, also for continuous joints: otherwise samples
    more than half a turn apart would give the motion around the other side. Angles that jump by
    whole turns must be unwrapped before (`numpy.unwrap`).

    Args:
        joints: Joints of the samples; none may float.
        times: From 0, increasing [s], n >= 2.
        positions: [rad or m].
        velocities: [rad/s or m/s].
        accelerations: [rad/s^2 or m/s^2]; ignored without velocities.

    Raises:
        ProblemInvalid: There are fewer than two samples, the numbers of samples differ, a number is
            not finite, or times do not increase.
    """
    _validate_samples(times, positions, velocities, accelerations)
    if velocities is None:
        return TimedTrajectory(joints, times, positions[:-1], _clamped_spline(times, positions))
    steps = positions[1:] - positions[:-1]
    h = np.diff(times)[:, None]
    v0, v1 = velocities[:-1], velocities[1:]
    if accelerations is None:
        a0 = (6 * steps / h - 4 * v0 - 2 * v1) / h
        c3 = (v0 + v1 - 2 * steps / h) / h**2
        columns = [np.zeros_like(steps), v0, a0 / 2, c3]
    else:
        a0, a1 = accelerations[:-1], accelerations[1:]
        # Residuals at the end of each piece of the polynomial that meets the start's values alone.
        p = steps - v0 * h - a0 * h**2 / 2
        v = (v1 - v0 - a0 * h) * h
        a = (a1 - a0) * h**2
        columns = [
            np.zeros_like(steps),
            v0,
            a0 / 2,
            (10 * p - 4 * v + a / 2) / h**3,
            (-15 * p + 7 * v - a) / h**4,
            (6 * p - 3 * v + a / 2) / h**5,
        ]
    return TimedTrajectory(joints, times, positions[:-1], np.stack(columns, axis=1))


def _validate_samples(times: Array, *columns: Array | None) -> None:
    names = ("times", "positions", "velocities", "accelerations")
    for name, rows in zip(names, (times, *columns), strict=False):
        if rows is None:
            continue
        if len(rows) != len(times):
            message = f"{name} has {len(rows)} samples, not {len(times)} as times"
            raise ProblemInvalid(message, {"field": name})
        if not np.isfinite(rows).all():
            message = f"{name} has numbers that are not finite"
            raise ProblemInvalid(message, {"field": name})
    if len(times) < 2 or not (np.diff(times) > 0).all():
        message = "times must be at least two, and increase"
        raise ProblemInvalid(message, {"field": "times"})


def polyline_through(
    joints: tuple[Joint, ...],
    times: Float64[np.ndarray, " n"],
    positions: Float64[np.ndarray, "n nq"],
) -> TimedTrajectory:
    """Return the trajectory that is linear between samples; positions are real numbers here too.

    Args:
        joints: Joints of the samples; those that float turn about one axis at a time.
        times: From 0, increasing [s], n >= 2.
        positions: [rad or m].

    Raises:
        ProblemInvalid: As of `trajectory_through`.
    """
    _validate_samples(times, positions)
    steps = _displacements(joints, positions)
    rates = steps / np.diff(times)[:, None]
    coefficients = np.stack([np.zeros_like(rates), rates], axis=1)
    return TimedTrajectory(joints, times, positions[:-1], coefficients)


def _displacements(joints: tuple[Joint, ...], positions: Array) -> Array:
    """Return the displacement from each sample to the next, whole turns kept, shape (n - 1, nv)."""
    steps = Manifold.of(joints).minus(positions[1:], positions[:-1])
    plain = np.diff(positions, axis=0)
    at_q = at_v = 0
    for joint in joints:
        if joint.type is not JointType.FLOATING:
            steps[:, at_v : at_v + joint.num_velocities] = plain[
                :, at_q : at_q + joint.num_positions
            ]
        at_q, at_v = at_q + joint.num_positions, at_v + joint.num_velocities
    return steps


def _clamped_spline(
    times: Float64[np.ndarray, " n"], positions: Float64[np.ndarray, "n nv"]
) -> Float64[np.ndarray, "n_minus_1 4 nv"]:
    """Return the pieces' displacements in powers of time: acceleration is continuous, ends rest."""
    # The import takes 0.4 s, and most importers of this module do not need it.
    from scipy.interpolate import CubicSpline  # noqa: PLC0415

    coefficients = CubicSpline(times, positions, bc_type="clamped").c[::-1].transpose(1, 0, 2)
    coefficients[:, 0] = 0.0
    return np.ascontiguousarray(coefficients)
