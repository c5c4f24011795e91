"""What a group must be like to have regions, and to plan in them."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from math import tau

from planning.domain.robot.joints import Joint, JointType
from planning.errors import ProblemInvalid

# What bounds in rounded numbers, as -3.1416 to 3.1416, may be wider than a turn [rad].
_ROUNDED = 1e-3


def require_convex(joints: Mapping[str, JointType], cars: Collection[str], field: str) -> None:
    """Go on only if straight motions between a group's configurations make sense.

    Args:
        joints: The kinds of all of the group's joints, by name.
        cars: Those that are steered, by themselves or because a request says so.
        field: What is asked for in vain, as a request names it.

    Raises:
        ProblemInvalid: A joint floats, or is steered.
    """
    floating = [name for name, kind in joints.items() if kind is JointType.FLOATING]
    if floating:
        message = (
            f"{field}: rotations in space are no vectors, so a floating joint "
            f"({', '.join(floating)}) has no convex regions"
        )
        raise ProblemInvalid(message, {"field": field, "joints": floating})
    if cars:
        names = sorted(cars)
        message = f"{field}: ways inside regions are straight; {', '.join(names)} cannot drive them"
        raise ProblemInvalid(message, {"field": field, "joints": names})


def require_one_turn(joints: Iterable[Joint], bounds: Mapping[str, Sequence[float]]) -> None:
    """Go on only if bounds of angles on a circle hold no posture twice.

    Args:
        joints: All of the group's joints; none floats.
        bounds: Lowest and highest value by position name [rad or m].

    Raises:
        ProblemInvalid: Bounds of a continuous joint or of a yaw are wider than a turn.
    """
    for joint in joints:
        for name, is_circle in zip(joint.position_names, joint.wraps, strict=True):
            low, high = bounds.get(name, (0.0, 0.0))
            if is_circle and high - low > tau + _ROUNDED:
                field = f"bounds.{name}"
                message = (
                    f"{field}: [{low:g}, {high:g}] is {high - low:.6g} rad wide, and after one "
                    f"turn ({tau:.6g} rad) every posture comes again; give one turn or less"
                )
                raise ProblemInvalid(message, {"field": field, "bounds": [low, high]})
