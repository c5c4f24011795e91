"""Tolerances: bounds on the tracking error and on the time to settle at the goal."""

from dataclasses import dataclass

from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class Tolerances(Value):
    """Bounds on the tracking error of an execution, in tangent coordinates [rad or m].

    Attributes:
        tracking: Largest allowed coordinate of `measured [-] desired` [rad or m]; beyond it the
            execution is aborted.
        goal: Largest such coordinate that counts as arrived [rad or m].
        rest: Largest coordinate of v that counts as at rest [rad/s or m/s].
        settle_time: Longest time after the last moving setpoint until the robot has arrived or is
            at rest [s].
        ramp_time: Shortest time from full speed to rest and back [s]; joint accelerations may need
            longer.
    """

    tracking: float = 0.1
    goal: float = 0.005
    rest: float = 0.01
    settle_time: float = 2.0
    ramp_time: float = 0.1
