"""Region requests: conditions on a group for growing convex regions and planning in them."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from math import tau

from planning.domain.robot.joints import Joint, JointType
from planning.errors import ProblemInvalid

# Tolerance on the width of a turn for rounded bounds such as -3.1416 to 3.1416 [rad].
_TURN_TOLERANCE = 1e-3


def validate_convex(joints: Mapping[str, JointType], cars: Collection[str], field: str) -> None:
    """Raise unless straight lines between a group's configurations are valid motions.

    Args:
        joints: The types of all of the group's joints, by name.
        cars: Names of the steered joints, steered by the robot's card or by the request.
        field: Name of the request's field that needs convex regions, for the error.

    Raises:
        ProblemInvalid: A joint floats, or is steered.
    """
    floating = [name for name, kind in joints.items() if kind is JointType.FLOATING]
    if floating:
        message = (
            f"{field}: convex regions are not defined for floating joints "
            f"({', '.join(floating)}): their rotations do not form a vector space"
        )
        raise ProblemInvalid(message, {"field": field, "joints": floating})
    if cars:
        names = sorted(cars)
        message = (
            f"{field}: paths inside convex regions are straight lines, which the steered joints "
            f"({', '.join(names)}) cannot follow"
        )
        raise ProblemInvalid(message, {"field": field, "joints": names})


def validate_one_turn(joints: Iterable[Joint], bounds: Mapping[str, Sequence[float]]) -> None:
    """Raise if the bounds of an angle on a circle span more than one turn.

    Args:
        joints: All of the group's joints; none floats.
        bounds: Lowest and highest value by position name [rad or m].

    Raises:
        ProblemInvalid: Bounds of a continuous joint or of a yaw are wider than a turn.
    """
    for joint in joints:
        for name, is_circle in zip(joint.position_names, joint.wraps, strict=True):
            low, high = bounds.get(name, (0.0, 0.0))
            if is_circle and high - low > tau + _TURN_TOLERANCE:
                field = f"bounds.{name}"
                message = (
                    f"{field}: [{low:g}, {high:g}] spans {high - low:.6g} rad, more than one turn "
                    f"({tau:.6g} rad) of an angle on a circle; give at most one turn"
                )
                raise ProblemInvalid(message, {"field": field, "bounds": [low, high]})
