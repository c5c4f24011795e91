"""SegmentTimes: durations of arc segments, each from rest to rest, as estimates of the retimer's.

All along a segment the limits are constant, so its squared path velocity x = (ds/dt)^2 over s from
0 to 1 has a constant bound, and its path acceleration dx/ds / 2 is at most

    min(A, sqrt(B^2 - (theta x)^2)):

A is the bound of the slowest joint, B that of the car, whose acceleration on an arc has a
centripetal part too, and theta is the turning angle. From rest that is

    x(s) = 2 A s                                as long as A is less than the root,
    x(s) = B / theta sin(2 theta (s - s_0))     after that, until the sine is 1,

and the same before the end. The duration is the integral of x^(-1/2); toppra's are 0 to 1 % longer.
With bounded jerk it is at least that of a straight line (Biagiotti and Melchiorri, "Trajectory
Planning for Automatic Machines and Robots", 2008, section 3.4), on an arc with a lower top speed:
4 % from ruckig's on average.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.robot.joints import JointLimits

# Gauss-Legendre rule on u, u^2 = s, where the integrand is smooth except where the bounds switch.
_QUADRATURE_NODES, _QUADRATURE_WEIGHTS = np.polynomial.legendre.leggauss(24)
# Share of an arc's speed bounds that is used with bounded jerk. Found by measurement.
_CIRCLE_SHARE = 0.5
_TINY, _UNBOUNDED = 1e-12, 1e6


@dataclass(frozen=True)
class SegmentTimes:
    """Durations of arc segments under velocity, acceleration and jerk limits.

    Attributes:
        car_bounds: Bounds of the car on speed, acceleration and jerk, in metres, shape (3,).
        other_bounds: The same for all other bounded blocks, shape (3, b).
        other_blocks: Coordinates (of yaw and the other joints) to which each of these applies.
        limits_jerk: Whether jerk is bounded.
    """

    car_bounds: Array
    other_bounds: Array
    other_blocks: tuple[list[int], ...]
    limits_jerk: bool

    @classmethod
    def of(cls, limits: JointLimits, car_index: int, *, limits_jerk: bool) -> "SegmentTimes":
        """Return the durations for a group whose car's coordinates begin at `car_index` in v."""
        rates = np.minimum([limits.velocity, limits.acceleration, limits.jerk], _UNBOUNDED)
        rates = np.maximum(rates, 1 / _UNBOUNDED)
        count = sum(len(block) for block in limits.blocks)
        columns = [car_index + 2, *(v for v in range(count) if not car_index <= v < car_index + 3)]
        car_block = limits.blocks.index((car_index, car_index + 1))
        remaining_blocks = limits.blocks[:car_block] + limits.blocks[car_block + 1 :]
        blocks = tuple([columns.index(v) for v in block] for block in remaining_blocks)
        return cls(rates[:, car_block], np.delete(rates, car_block, axis=1), blocks, limits_jerk)

    def durations(
        self,
        signed_lengths: Float64[np.ndarray, " n"],
        turning_angles: Float64[np.ndarray, " n"],
        displacements: Float64[np.ndarray, "n k"],
    ) -> Float64[np.ndarray, " n"]:
        """Return the duration of every segment [s].

        Args:
            signed_lengths: Signed lengths [m].
            turning_angles: Turning angles [rad].
            displacements: Displacements of the other joints.
        """
        columns = np.column_stack([turning_angles, displacements])
        sizes = [np.linalg.norm(columns[:, block], axis=1) for block in self.other_blocks]
        turning_angles = np.abs(turning_angles) + _TINY
        car_bounds = self.car_bounds[:, None] / (np.abs(signed_lengths) + _TINY)
        other_bounds = (self.other_bounds[:, None] / (np.stack(sizes, axis=1) + _TINY)).min(axis=2)
        squared_top_speed = np.minimum(
            np.minimum(car_bounds[0], other_bounds[0]) ** 2, car_bounds[1] / turning_angles
        )
        times = _arc_durations(squared_top_speed, other_bounds[1], car_bounds[1], turning_angles)
        if not self.limits_jerk:
            return times
        squared_arc_speed = np.minimum(
            car_bounds[1] / turning_angles,
            (car_bounds[2] / turning_angles**2 / _CIRCLE_SHARE**0.5) ** (2 / 3),
        )
        speed = np.sqrt(np.minimum(squared_top_speed, _CIRCLE_SHARE * squared_arc_speed))
        acceleration, jerk = np.minimum(car_bounds[1:], other_bounds[1:])
        return np.maximum(times, _line_durations(speed, acceleration, jerk))


def _arc_durations(
    squared_top_speed: Array, acceleration: Array, car_acceleration: Array, turning_angles: Array
) -> Array:
    """Return durations on arcs without jerk bounds: the integral over both equal halves."""
    u = (_QUADRATURE_NODES[:, None] + 1) * np.sqrt(0.125)
    s = u * u
    acceleration = np.minimum(acceleration, car_acceleration / _TINY**0.5)
    centripetal_reserve = np.sqrt(np.maximum(car_acceleration**2 - acceleration**2, 0.0))
    s_0 = centripetal_reserve / (2 * acceleration * turning_angles)
    phase = 2 * turning_angles * (s - s_0) + np.arcsin(
        np.minimum(centripetal_reserve / car_acceleration, 1.0)
    )
    sine_profile = car_acceleration / turning_angles * np.sin(np.minimum(phase, np.pi / 2))
    squared_speed = np.minimum(
        np.where(s < s_0, 2 * acceleration * s, sine_profile), squared_top_speed
    )
    return (_QUADRATURE_WEIGHTS[:, None] * np.sqrt(0.5) * 2 * u / np.sqrt(squared_speed)).sum(
        axis=0
    )


def _line_durations(speed: Array, acceleration: Array, jerk: Array) -> Array:
    """Return durations from s = 0 to 1, rest to rest, with bounded speed, acceleration, jerk."""
    acceleration = np.minimum(acceleration, np.sqrt(speed * jerk))
    ramp = acceleration / jerk
    with_cruise = 1 / speed + speed / acceleration + ramp
    without_cruise = np.sqrt(ramp**2 + 4 / acceleration) + ramp
    jerk_limited = (32 / jerk) ** (1 / 3)
    short_durations = np.where(2 * acceleration * ramp**2 <= 1, without_cruise, jerk_limited)
    return np.where(speed * (speed / acceleration + ramp) <= 1, with_cruise, short_durations)
