"""What a request may say about cars."""

from collections.abc import Mapping, Sequence

from planning.domain.robot.steering import Steering
from planning.errors import ProblemInvalid, UnknownName

# Of turning radii [m].
LEAST_RADIUS, LARGEST_RADIUS = 1e-3, 1e3
# OMPL's planners that check every edge of their solution in the direction of motion. The others
# check some from the goal's side, which is the same only where a car drives backwards. A test tells
# which these are.
_DIRECTED = ("BITstar", "InformedRRTstar", "KPIECE1", "RRT", "RRTConnect", "RRTstar", "SORRTstar")


def agreed_steering(
    own: Mapping[str, Steering], asked: Mapping[str, Steering], planar: Sequence[str]
) -> dict[str, Steering]:
    """Return how bases are steered that are cars by themselves, or that a request says are.

    Args:
        own: What the robots can do, by joint.
        asked: What a request wants, by joint.
        planar: The joints that a request may make a car of.

    Raises:
        UnknownName: There is no such planar joint.
        ProblemInvalid: A turning radius makes no sense, or the robot itself cannot drive so.
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
    """Go on only if every planner can search for such cars.

    Raises:
        ProblemInvalid: One checks motions backwards, and a car has no reverse.
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
    """Return the error of a space that a joint cannot have."""
    field = "search.spaces"
    return ProblemInvalid(f"{field}: {name!r}: {reason}", {"field": field, "name": name})
