"""GroupMotion: a timed motion of one group among others that move at the same time."""

from dataclasses import dataclass

from planning.domain.curves.curve import TimedTrajectory
from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class GroupMotion(Value):
    """Timed motion of a group, and when it begins.

    Attributes:
        group: `robot` or `robot::group`, or a group that spans several.
        trajectory: The motion, by its own time.
        begin: When it begins [s]; before that the group rests at its start.
    """

    group: str
    trajectory: TimedTrajectory
    begin: float = 0.0


@dataclass(frozen=True, eq=False)
class CombinedMotion(Value):
    """Several motions as one motion of the group that spans theirs.

    Attributes:
        group: Name of that group: its own in the scene, or the names of its members joined by `+`.
        trajectory: The motion, with the polynomials of the given ones.
    """

    group: str
    trajectory: TimedTrajectory
