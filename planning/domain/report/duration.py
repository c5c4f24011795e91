"""DurationExplanation: active limits along a motion, and the time saved by relaxing each."""

from dataclasses import dataclass

from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class BindingInterval(Value):
    """Time interval with one active limit, the one with the largest utilization.

    Attributes:
        begin: [s].
        end: [s].
        limit: velocity, acceleration, jerk or the name of a path limit (torque, tool_speed,
            tool_acceleration, speed_zone, acceleration_bounds); "duration" where the motion takes
            longer than its minimum on request; "" only while nothing moves.
        where: The joint, block, frame or zone whose limit it is, or "".
        share: Largest utilization of the limit, in [0, 1]; 1 where it is met.
    """

    begin: float
    end: float
    limit: str
    where: str
    share: float


@dataclass(frozen=True, eq=False)
class Saving(Value):
    """Time saved by relaxing one limit.

    Attributes:
        limit: Its kind, as of `BindingInterval`.
        where: The joint, block, frame or zone whose limit it is.
        seconds: Reduction of the duration [s].
    """

    limit: str
    where: str
    seconds: float


@dataclass(frozen=True, eq=False)
class DurationExplanation(Value):
    """Explanation of a motion's duration by its active limits.

    Attributes:
        intervals: Active limit on each interval; together they cover the motion.
        relaxed: The factor by which limits were relaxed, one at a time.
        savings: Time saved by each, the most first; measured for limits that are met somewhere, and
            no others.
    """

    intervals: tuple[BindingInterval, ...]
    relaxed: float
    savings: tuple[Saving, ...]
