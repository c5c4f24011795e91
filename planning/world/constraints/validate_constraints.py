"""Validation of path constraints: existing names and valid numbers."""

from collections.abc import Iterable

import numpy as np

from planning.domain.request.constraint import (
    DistanceBand,
    KeepIn,
    KeepOut,
    LockedJoints,
    OrientationCone,
    PathConstraint,
    PathPredicate,
    PlacedBox,
    PositionBand,
    TightLimits,
)
from planning.domain.robot.joints import JointGroup
from planning.errors import ProblemInvalid, UnknownName
from planning.world.constraints.body_pairs import banded_pairs
from planning.world.world import World


def validate_constraints(
    world: World, group: JointGroup, constraints: tuple[PathConstraint, ...]
) -> None:
    """Raise unless every constraint is valid in this world, for this group.

    Raises:
        UnknownName: A body, frame or joint does not exist.
        ProblemInvalid: A number is invalid; evidence has the `field`.
    """
    for i, constraint in enumerate(constraints):
        _validate_constraint(world, group, constraint, f"path_constraints.{i}")


def _validate_constraint(
    world: World, group: JointGroup, constraint: PathConstraint, field: str
) -> None:
    match constraint:
        case DistanceBand():
            names = [*(constraint.bodies or ()), *(constraint.to or ())]
            _validate_names("body", names, world.drake.all_bodies)
            _raise_unless(0 <= constraint.min < constraint.max, field, "0 <= min < max is needed")
            banded_pairs(world, group, constraint, field)
        case KeepOut() | KeepIn() | PositionBand():
            world.validate_frame(constraint.frame)
            _validate_box(world, constraint.box, field, is_solid=isinstance(constraint, KeepOut))
        case OrientationCone():
            world.validate_frame(constraint.frame)
            world.validate_frame(constraint.reference)
            for name in ("axis", "direction"):
                length = float(np.linalg.norm(getattr(constraint, name)))
                _raise_unless(1e-9 < length < np.inf, field, f"{name} must not be zero")
            is_angle = 0 < constraint.tolerance <= np.pi
            _raise_unless(is_angle, field, "tolerance must be an angle above 0 and at most pi")
        case LockedJoints():
            _validate_names("joint", constraint.joints, [joint.name for joint in group.joints])
        case TightLimits():
            _validate_names("joint", constraint.limits, group.position_names)
            is_ordered = all(low <= high for low, high in constraint.limits.values())
            _raise_unless(is_ordered, field, "the lower limit must not exceed the upper one")
        case PathPredicate():
            is_positive = 0 < constraint.resolution < np.inf
            _raise_unless(is_positive, field, "resolution must be positive")


def _validate_box(world: World, box: PlacedBox, field: str, *, is_solid: bool) -> None:
    world.validate_frame(box.reference)
    _raise_unless(bool((box.size > 0).all()), field, "every side of the box must be longer than 0")
    _raise_unless(
        bool(np.isfinite(box.size).any()), field, "at least one side of the box must be finite"
    )
    if is_solid:
        _raise_unless(
            bool(np.isfinite(box.size).all()), field, "every side of the box must be finite"
        )


def _validate_names(kind: str, names: Iterable[str], known: Iterable[str]) -> None:
    listed = list(known)
    for name in names:
        if name not in listed:
            raise UnknownName.among(kind, name, listed)


def _raise_unless(is_valid: bool, field: str, message: str) -> None:  # noqa: FBT001
    if not is_valid:
        raise ProblemInvalid(f"{field}: {message}", {"field": field})
