"""Evidence of failures about what grippers hold."""

from typing import TypedDict

from pydantic import with_config

from service.api.failures.parts import OPEN


@with_config(OPEN)
class GraspEvidence(TypedDict):
    """Why fingers do not hold an object."""

    object: str
    """Name of the object"""
    width: float
    """Distance of the fingers where they have closed [m]"""
    distances: list[float | None]
    """Distance between the object and each finger then [m]; null beyond 5 cm"""
    bound: float
    """Largest distances that are allowed [m]"""


@with_config(OPEN)
class GraspLostEvidence(TypedDict):
    """Object that slipped in its gripper, and how far."""

    object: str
    """Name of the object"""
    frame: str
    """Frame that it is attached to"""
    slip: float
    """Largest distance of a corner of its bounding box from where it was held [m]"""
    bound: float
    """Largest slip that is tolerated [m]"""
    time: float
    """Time along the motion [s]"""
