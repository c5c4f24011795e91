"""RateBounds: bounds on velocity, acceleration and jerk of coordinates, and on loads."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.robot.joints import JointLimits
from planning.refine.constraints.load import Load

# Finite substitutes of infinite bounds, which would lead to NaN.
_UNBOUNDED_RATE, UNBOUNDED_JERK = 1e3, 1e6
# Share of the jerk limit for the curve's third derivative: changes of path velocity need the rest.
# Found by measurement.
_JERK_SHARE = 0.1


@dataclass(frozen=True)
class RateBounds:
    """Bounds on the rates of every coordinate, positive and finite, shape (nq,), and on loads.

    Attributes:
        velocity: [rad/s or m/s].
        acceleration: The larger of the bounds of either sign [rad/s^2 or m/s^2].
        jerk: [rad/s^3 or m/s^3]; None if it is not bounded.
        acceleration_range: Lowest and highest acceleration over `acceleration`, shape (2, nq): -1
            and 1 where both signs have the same bound.
        loads: Other quantities that bound the path velocity.
    """

    velocity: Array
    acceleration: Array
    jerk: Array | None
    acceleration_range: Array
    loads: tuple[Load, ...] = ()

    @classmethod
    def of(
        cls,
        limits: JointLimits,
        *,
        limits_jerk: bool,
        acceleration_bounds: Float64[np.ndarray, "2 nv"] | None = None,
        loads: tuple[Load, ...] = (),
    ) -> "RateBounds":
        """Return the bounds per coordinate that imply a group's limits.

        Args:
            limits: Joint limits of the group.
            limits_jerk: Whether jerk is limited.
            acceleration_bounds: Lowest and highest accelerations in addition [rad/s^2 or m/s^2],
                infinite where there are none.
            loads: Other quantities that bound the path velocity.
        """
        velocity, acceleration, jerks = (
            np.minimum(limits.per_coordinate(rates), max_rate)
            for rates, max_rate in (
                (limits.velocity, _UNBOUNDED_RATE),
                (limits.acceleration, _UNBOUNDED_RATE),
                (limits.jerk, UNBOUNDED_JERK),
            )
        )
        by_sign = np.stack([acceleration, acceleration])
        if acceleration_bounds is not None:
            by_sign = np.minimum(by_sign, np.abs(acceleration_bounds))
        if limits_jerk:
            # With jerk bounds a coordinate reaches its velocity in v / a + a / j, or 2 sqrt(v / j).
            ramp = np.where(
                by_sign**2 < velocity * jerks,
                velocity / by_sign + by_sign / jerks,
                2 * np.sqrt(velocity / jerks),
            )
            by_sign = velocity / ramp
        larger = by_sign.max(axis=0)
        acceleration_range = np.array([[-1.0], [1.0]]) * (by_sign / larger)
        return cls(
            velocity,
            larger,
            _JERK_SHARE * jerks if limits_jerk else None,
            acceleration_range,
            loads,
        )
