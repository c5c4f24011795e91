"""Robustness: obstacle displacement and joint error that a clearance proof tolerates."""

from dataclasses import dataclass

from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class Robustness(Value):
    """Guaranteed tolerances of a clearance proof; each number holds on its own.

    With every obstacle displaced by less than `obstacle_displacement`, or every joint off by less
    than `joint_error`, all pairs keep their margins at every instant. An obstacle is a body that
    the group does not move and that is no part of the same robot.

    Not promised: anything about limits, or about both errors at once (the share that one error
    uses of its tolerance is missing from the other's).

    Attributes:
        obstacle_displacement: Largest displacement of any point of any obstacle from the scene's
            position [m]; at most `MAX_DISPLACEMENT`.
        obstacle_pair: The two bodies that limit it, or ("", "").
        obstacle_time: Time at which they do [s].
        joint_error: Largest simultaneous error of all joints, of each in rotation and in
            translation [rad or m]; at most `MAX_JOINT_ERROR`.
        joint_pair: The two bodies that limit it, or ("", "").
        joint_time: Time at which they do [s].
    """

    obstacle_displacement: float
    obstacle_pair: tuple[str, str]
    obstacle_time: float
    joint_error: float
    joint_pair: tuple[str, str]
    joint_time: float


# Largest values that are reported [m], [rad or m].
MAX_DISPLACEMENT = 1.0
MAX_JOINT_ERROR = 0.5
