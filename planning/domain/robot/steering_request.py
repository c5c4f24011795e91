"""Requests for steered (car-like) bases: steering from the robot and the request, and planners."""

from collections.abc import Mapping, Sequence

from planning.domain.robot.steering import Steering
from planning.errors import ProblemInvalid, UnknownName

# Range of turning radii [m].
MIN_TURNING_RADIUS, MAX_TURNING_RADIUS = 1e-3, 1e3
# OMPL's planners that check every edge of their solution in the direction of motion. The others
# check some from the goal's side, which is the same only where a car drives backwards. A test
# determines which these are.
_FORWARD_PLANNERS = (
    "BITstar",
    "InformedRRTstar",
    "KPIECE1",
    "RRT",
    "RRTConnect",
    "RRTstar",
    "SORRTstar",
)


def resolve_steering(
    robot_steering: Mapping[str, Steering], requested: Mapping[str, Steering], planar: Sequence[str]
) -> dict[str, Steering]:
    """Return the steering of bases by joint: the robot's own, and that of the request.

    Args:
        robot_steering: Steering that the robots have, by joint.
        requested: Steering that the request sets, by joint.
        planar: The planar joints that a request may steer.

    Raises:
        UnknownName: There is no such planar joint.
        ProblemInvalid: A turning radius is invalid, or the robot itself cannot turn as tightly
            or drive backwards.
    """
    for name, steering in requested.items():
        if name not in planar:
            raise UnknownName.among("planar joint", name, planar)
        if not MIN_TURNING_RADIUS <= steering.turning_radius <= MAX_TURNING_RADIUS:
            reason = (
                f"its turning radius must be between {MIN_TURNING_RADIUS} "
                f"and {MAX_TURNING_RADIUS} m"
            )
            raise invalid_space(name, reason)
        car = robot_steering.get(name, steering)
        if steering.turning_radius < car.turning_radius or (steering.reverse and not car.reverse):
            reason = f"the robot's own turning radius is {car.turning_radius} m"
            raise invalid_space(name, reason if car.reverse else f"{reason}, and it has no reverse")
    return {**robot_steering, **requested}


def validate_forward_planners(planners: Sequence[str], steering: Mapping[str, Steering]) -> None:
    """Raise unless every planner can search for cars with this steering.

    Raises:
        ProblemInvalid: A planner checks motions backwards, and a car has no reverse.
    """
    if all(car.reverse for car in steering.values()):
        return
    for name in planners:
        if name not in _FORWARD_PLANNERS:
            known = list(_FORWARD_PLANNERS)
            message = (
                f"planner {name!r} checks motions backwards, and this car has no reverse; planners "
                f"that check them in the direction of motion: {known}"
            )
            raise ProblemInvalid(message, {"field": "search.planner", "known": known})


def invalid_space(name: str, reason: str) -> ProblemInvalid:
    """Return the error for a state space that a joint cannot have."""
    field = "search.spaces"
    return ProblemInvalid(f"{field}: {name!r}: {reason}", {"field": field, "name": name})
