"""Constraint checks: one check per path constraint, on the whole interval of a trajectory."""

from planning.certify.clearance.band_check import band_check
from planning.certify.frames.frame_checks import box_check, cone_check
from planning.certify.joints.joint_checks import lock_check, tight_limits_check
from planning.certify.request import CertifyRequest
from planning.certify.sampled.predicate_check import predicate_check
from planning.domain.report.certificate import Check
from planning.domain.request.constraint import (
    DistanceBand,
    KeepIn,
    KeepOut,
    LockedJoints,
    OrientationCone,
    PathConstraint,
    PathPredicate,
    PositionBand,
    TightLimits,
    constraint_label,
)
from planning.domain.request.deadline import Deadline
from planning.world.drake_model import DrakeModel


def constraint_checks(
    model: DrakeModel, request: CertifyRequest, deadline: Deadline
) -> list[Check]:
    """Return one check per path constraint, in the order of the constraints.

    Raises:
        DeadlineExceeded: Time ran out.
        Canceled: The caller canceled.
        ModelInvalid: A shape or joint of a kind that cannot be certified.
    """
    return [
        _check(constraint_label(i, constraint), constraint, model, request, deadline)
        for i, constraint in enumerate(request.constraints)
    ]


def _check(
    name: str,
    constraint: PathConstraint,
    model: DrakeModel,
    request: CertifyRequest,
    deadline: Deadline,
) -> Check:
    match constraint:
        case DistanceBand():
            return band_check(name, constraint, model, request, deadline)
        case KeepIn() | KeepOut() | PositionBand():
            return box_check(name, constraint, model, request, deadline)
        case OrientationCone():
            return cone_check(name, constraint, model, request, deadline)
        case LockedJoints():
            return lock_check(name, constraint, request)
        case TightLimits():
            return tight_limits_check(name, constraint, request)
        case PathPredicate():
            return predicate_check(name, constraint, request, deadline)
