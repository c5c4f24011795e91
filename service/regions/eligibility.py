"""Whether a group can have regions at all, by the summary of its scene."""

from collections.abc import Mapping

from planning.domain.request.region_request import validate_convex
from planning.domain.robot.joints import JointType
from planning.domain.robot.steering import Steering
from service.scenes.models.summary import Group


def own_cars(group: Group) -> dict[str, Steering]:
    """Return how those joints are steered that are so in any request."""
    # Scenes that were stored by older versions know nothing of cars.
    return {
        joint.name: Steering(joint.steering.turning_radius, joint.steering.reverse)
        for joint in group.joints
        if joint.steering is not None
    }


def check_eligible(group: Group, cars: Mapping[str, Steering], field: str) -> None:
    """Check that the group can have regions.

    Raises:
        ProblemInvalid: A joint floats, or is steered.
    """
    joints = {joint.name: JointType(joint.type) for joint in group.joints}
    validate_convex(joints, cars, field)
