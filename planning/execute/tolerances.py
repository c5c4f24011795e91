"""Tolerances: how far a robot may be from what it should do, before and after the end."""

from dataclasses import dataclass

from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class Tolerances(Value):
    """How far a robot may be from what it should do; coordinates of tangents [rad or m].

    Attributes:
        tracking: Largest coordinate of `measured [-] desired` while it moves; beyond it the
            execution is aborted.
        goal: The same, to have arrived.
        rest: Largest coordinate of v to count as standing still [rad/s or m/s].
        settle_time: How long after its last setpoint the robot may take to arrive or stand [s].
        ramp_time: The least time from full speed to rest and back [s]; joint accelerations may
            need longer.
    """

    tracking: float = 0.1
    goal: float = 0.005
    rest: float = 0.01
    settle_time: float = 2.0
    ramp_time: float = 0.1
