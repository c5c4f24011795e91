"""Robustness: how wrong world and robot may be before a proof of clearance is worth nothing."""

from dataclasses import dataclass

from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class Robustness(Value):
    """What a proof of clearance survives; each number is guaranteed, by itself.

    With every obstacle displaced by less than the first, or every joint off by less than the
    second, all pairs keep their margins at every instant. An obstacle is a body that the group does
    not move and that is no part of the same robot.

    Not promised: anything about limits, or about both errors at once (what one uses up of its
    number, as a share, the other lacks).

    Attributes:
        obstacle_displacement: How far the points of all obstacles may be from where the scene has
            them [m]; at most `MOST_DISPLACEMENT`.
        obstacle_pair: The two bodies that allow no more, or ("", "").
        obstacle_time: When they do [s].
        joint_error: By how much every joint may be off at once, each in turn and in shift
            [rad or m]; at most `MOST_ERROR`.
        joint_pair: The two bodies that allow no more, or ("", "").
        joint_time: When they do [s].
    """

    obstacle_displacement: float
    obstacle_pair: tuple[str, str]
    obstacle_time: float
    joint_error: float
    joint_pair: tuple[str, str]
    joint_time: float


# Nobody needs to know of more [m], [rad or m].
MOST_DISPLACEMENT = 1.0
MOST_ERROR = 0.5
