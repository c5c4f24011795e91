"""Tolerances: bounds on the tracking error, on torques, and on the time to settle."""

from dataclasses import dataclass

from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class Tolerances(Value):
    """Bounds on what an execution may measure, in tangent coordinates [rad or m].

    Attributes:
        tracking: Largest allowed coordinate of `measured [-] desired` [rad or m]; beyond it the
            execution is aborted.
        goal: Largest such coordinate that counts as arrived [rad or m].
        rest: Largest coordinate of v that counts as at rest [rad/s or m/s].
        settle_time: Longest time after the last moving setpoint until the robot has arrived or is
            at rest [s].
        ramp_time: Shortest time from full speed to rest and back [s]; joint accelerations may need
            longer.
        saturation_time: Longest time at a torque limit [s]; beyond it the execution is aborted.
    """

    tracking: float = 0.1
    goal: float = 0.005
    rest: float = 0.01
    settle_time: float = 2.0
    ramp_time: float = 0.1
    saturation_time: float = 0.25


# Of grippers: fingers that travel 25 mm have not arrived 5 mm before the end, and what they shall
# hold is 0.2 mm away from them.
FINGER_TOLERANCES = Tolerances(tracking=0.005, goal=1.5e-4)
