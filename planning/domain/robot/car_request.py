"""Requests for steered (car-like) bases: steering from the robot and the request, and planners."""

from collections.abc import Mapping, Sequence

from planning.domain.robot.steering import Steering
from planning.errors import ProblemInvalid, UnknownName

# Range of turning radii [m].
LEAST_RADIUS, LARGEST_RADIUS = 1e-3, 1e3
# OMPL's planners that check every edge of their solution in the direction of motion. The others
# check some from the goal's side, which is the same only where a car drives backwards. A test
# determines which these are.
_DIRECTED = ("BITstar", "InformedRRTstar", "KPIECE1", "RRT", "RRTConnect", "RRTstar", "SORRTstar")


def agreed_steering(
    own: Mapping[str, Steering], asked: Mapping[str, Steering], planar: Sequence[str]
) -> dict[str, Steering]:
    """Return the steering of bases by joint: the robot's own, and that of the request.

    Args:
        own: Steering that the robots have, by joint.
        asked: Steering that the request sets, by joint.
        planar: The planar joints that a request may steer.

    Raises:
        UnknownName: There is no such planar joint.
        ProblemInvalid: A turning radius is invalid, or the robot itself cannot drive so.
    """
    for name, how in asked.items():
        if name not in planar:
            raise UnknownName.among("planar joint", name, planar)
        if not LEAST_RADIUS <= how.turning_radius <= LARGEST_RADIUS:
            reason = f"its turning radius must be between {LEAST_RADIUS} and {LARGEST_RADIUS} m"
            raise bad_space(name, reason)
        car = own.get(name, how)
        if how.turning_radius < car.turning_radius or (how.reverse and not car.reverse):
            reason = f"the robot's own turning radius is {car.turning_radius} m"
            raise bad_space(name, reason if car.reverse else f"{reason}, and it has no reverse")
    return {**own, **asked}


def require_directed(planners: Sequence[str], steering: Mapping[str, Steering]) -> None:
    """Raise unless every planner can search for cars with this steering.

    Raises:
        ProblemInvalid: A planner checks motions backwards, and a car has no reverse.
    """
    if all(car.reverse for car in steering.values()):
        return
    for name in planners:
        if name not in _DIRECTED:
            known = list(_DIRECTED)
            message = (
                f"planner {name!r} checks motions backwards, and this car has no reverse; planners "
                f"that check them in the direction of motion: {known}"
            )
            raise ProblemInvalid(message, {"field": "search.planner", "known": known})


def bad_space(name: str, reason: str) -> ProblemInvalid:
    """Return the error for a state space that a joint cannot have."""
    field = "search.spaces"
    return ProblemInvalid(f"{field}: {name!r}: {reason}", {"field": field, "name": name})
