"""What a group must be like to have regions, and to plan in them."""

from collections.abc import Collection, Mapping

from planning.domain.joints import JointType
from planning.errors import ProblemInvalid


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
