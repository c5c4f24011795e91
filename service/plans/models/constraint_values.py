"""Path constraints: from the wire to the domain."""

from collections.abc import Iterable

import numpy as np

from planning.domain.geometry import pose as geometry
from planning.domain.request import constraint as domain
from service.api.models import Pose
from service.plans.models.constraints import (
    Constraint,
    DistanceBand,
    JointLimits,
    KeepIn,
    KeepOut,
    LockedJoints,
    Orientation,
    Position,
)


def constraint_values(constraints: Iterable[Constraint]) -> tuple[domain.PathConstraint, ...]:
    """Return the domain's constraints."""
    return tuple(_value(constraint) for constraint in constraints)


def _value(constraint: Constraint) -> domain.PathConstraint:  # noqa: PLR0911  (one a kind)
    match constraint:
        case DistanceBand():
            return domain.DistanceBand(
                bodies=None if constraint.bodies is None else tuple(constraint.bodies),
                to=None if constraint.to is None else tuple(constraint.to),
                min=constraint.min,
                max=np.inf if constraint.max is None else constraint.max,
            )
        case KeepOut(frame=frame, box=box):
            return domain.KeepOut(frame, box_value(box.size, box.pose))
        case KeepIn(frame=frame, box=box):
            return domain.KeepIn(frame, box_value(box.size, box.pose))
        case Position(frame=frame, size=size, pose=pose):
            return domain.PositionBand(frame, box_value(size, pose))
        case Orientation():
            return domain.OrientationCone(
                frame=constraint.frame,
                axis=np.array(constraint.axis, dtype=np.float64),
                direction=np.array(constraint.direction, dtype=np.float64),
                tolerance=constraint.tolerance,
                reference=constraint.reference,
            )
        case LockedJoints():
            return domain.LockedJoints(tuple(constraint.joints))
        case JointLimits():
            return domain.TightLimits({name: (a, b) for name, (a, b) in constraint.limits.items()})


def box_value(size: list[float] | list[float | None], pose: Pose) -> domain.PlacedBox:
    """Return the domain's box; sides that are null are infinite."""
    sides = np.array([np.inf if side is None else side for side in size])
    return domain.PlacedBox(
        sides, geometry.Pose.from_parts(pose.position, pose.quaternion, pose.rpy), pose.frame
    )
