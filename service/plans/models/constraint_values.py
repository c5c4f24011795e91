"""Path constraints: from the wire to the domain."""

from collections.abc import Iterable

import numpy as np

from planning.domain.geometry.pose import Pose
from planning.domain.request.constraint import (
    DistanceBand,
    KeepIn,
    KeepOut,
    LockedJoints,
    OrientationCone,
    PathConstraint,
    PlacedBox,
    PositionBand,
    TightLimits,
)
from service.api.pose import PoseWire
from service.plans.models.constraints import (
    ConstraintWire,
    DistanceBandWire,
    JointLimitsWire,
    KeepInWire,
    KeepOutWire,
    LockedJointsWire,
    OrientationWire,
    PositionWire,
)


def constraint_values(constraints: Iterable[ConstraintWire]) -> tuple[PathConstraint, ...]:
    """Return the domain's constraints."""
    return tuple(_value(constraint) for constraint in constraints)


def _value(constraint: ConstraintWire) -> PathConstraint:  # noqa: PLR0911  (one a kind)
    match constraint:
        case DistanceBandWire():
            return DistanceBand(
                bodies=None if constraint.bodies is None else tuple(constraint.bodies),
                to=None if constraint.to is None else tuple(constraint.to),
                min=constraint.min,
                max=np.inf if constraint.max is None else constraint.max,
            )
        case KeepOutWire(frame=frame, box=box):
            return KeepOut(frame, box_value(box.size, box.pose))
        case KeepInWire(frame=frame, box=box):
            return KeepIn(frame, box_value(box.size, box.pose))
        case PositionWire(frame=frame, size=size, pose=pose):
            return PositionBand(frame, box_value(size, pose))
        case OrientationWire():
            return OrientationCone(
                frame=constraint.frame,
                axis=np.array(constraint.axis, dtype=np.float64),
                direction=np.array(constraint.direction, dtype=np.float64),
                tolerance=constraint.tolerance,
                reference=constraint.reference,
            )
        case LockedJointsWire():
            return LockedJoints(tuple(constraint.joints))
        case JointLimitsWire():
            return TightLimits({name: (a, b) for name, (a, b) in constraint.limits.items()})


def box_value(size: list[float] | list[float | None], pose: PoseWire) -> PlacedBox:
    """Return the domain's box; sides that are null are infinite."""
    sides = np.array([np.inf if side is None else side for side in size])
    return PlacedBox(sides, Pose.from_parts(pose.position, pose.quaternion, pose.rpy), pose.frame)
