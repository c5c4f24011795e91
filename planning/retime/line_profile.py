"""The quickest profile along a straight line: full acceleration, full speed, full braking."""

import numpy as np

from planning.retime.profile import SpeedProfile


def line_profile(s0: float, s1: float, speed: float, acceleration: float) -> SpeedProfile:
    """Return the time-optimal rest-to-rest profile from s0 to s1.

    Bang-bang if the top speed is not reached, else with a cruise between (Lynch and Park, "Modern
    Robotics", 2017, section 9.2.2.2).

    Args:
        s0: Where it begins.
        s1: Where it ends, s1 > s0.
        speed: Largest ds/dt [1/s].
        acceleration: Largest d2s/dt2 [1/s^2].
    """
    length = s1 - s0
    if speed**2 / acceleration >= length:
        ramp = np.sqrt(length / acceleration)
        top = acceleration * ramp
        return SpeedProfile(
            np.array([s0, s0 + length / 2, s1]),
            np.array([0.0, top]),
            np.array([acceleration, -acceleration]),
            np.zeros(2),
            np.array([ramp, ramp]),
        )
    ramp = speed / acceleration
    climb = speed * ramp / 2
    return SpeedProfile(
        np.array([s0, s0 + climb, s1 - climb, s1]),
        np.array([0.0, speed, speed]),
        np.array([acceleration, 0.0, -acceleration]),
        np.zeros(3),
        np.array([ramp, (length - 2 * climb) / speed, ramp]),
    )
