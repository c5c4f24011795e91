"""Why a motion takes as long as it does."""

from dataclasses import dataclass

from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class BindingInterval(Value):
    """What keeps a motion from being quicker for a while: the limit that is used the most.

    Attributes:
        begin: [s].
        end: [s].
        limit: velocity, acceleration, jerk or the name of a path limit (torque, tool_speed,
            tool_acceleration, speed_zone, acceleration_bounds); "duration" where the motion takes
            longer than it must because that was asked for; "" only while nothing moves.
        where: The joint, block, frame or zone whose limit it is, or "".
        share: How much of it is used at most, in [0, 1]; 1 where it is met.
    """

    begin: float
    end: float
    limit: str
    where: str
    share: float


@dataclass(frozen=True, eq=False)
class Saving(Value):
    """How much shorter a motion would be with one limit relaxed.

    Attributes:
        limit: Its kind, as of `BindingInterval`.
        where: The joint, block, frame or zone whose limit it is.
        seconds: How much shorter [s].
    """

    limit: str
    where: str
    seconds: float


@dataclass(frozen=True, eq=False)
class DurationExplanation(Value):
    """Why a motion takes as long as it does.

    Attributes:
        intervals: What binds when; together they cover the motion.
        relaxed: The factor by which limits were relaxed, one at a time.
        savings: What that saved, the most first; measured for limits that are met somewhere, and
            no others.
    """

    intervals: tuple[BindingInterval, ...]
    relaxed: float
    savings: tuple[Saving, ...]
