"""Options of a request for the search space: metric weights, bounds, held rotations, steering."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from jaxtyping import Float64

from planning.domain.robot.joints import JointGroup, JointLimits, JointType
from planning.domain.robot.steering import Steering, steered, steering_of
from planning.domain.robot.steering_request import invalid_space, resolve_steering
from planning.errors import ProblemInvalid, UnknownName

_WEIGHT_RANGE = (1e-3, 1e3)
_SPACES = ("full", "position")
_ROTATION_TYPES = (JointType.PLANAR, JointType.FLOATING)


def metric_weights(
    group: JointGroup, weights: Mapping[str, float]
) -> Float64[np.ndarray, " num_blocks"]:
    """Return a metric weight for each of the group's blocks; a block's name overrides its joint's.

    Raises:
        UnknownName: There is no such joint or block.
        ProblemInvalid: A weight is not between 0.001 and 1000.
    """
    if not weights:
        return np.ones(len(group.blocks))
    joints = {name: joint.name for joint in group.joints for name, _ in joint.blocks}
    known = {*joints, *joints.values()}
    for name, weight in weights.items():
        if name not in known:
            raise UnknownName.among("joint or block", name, known)
        if not _WEIGHT_RANGE[0] <= weight <= _WEIGHT_RANGE[1]:
            field = "search.weights"
            message = f"{field}: {name!r} is {weight}; it must be between 0.001 and 1000"
            raise ProblemInvalid(message, {"field": field, "name": name})
    return np.array([
        weights.get(block, weights.get(joint, 1.0)) for block, joint in joints.items()
    ])


def bounded_limits(
    group: JointGroup, limits: JointLimits, bounds: Mapping[str, tuple[float, float]]
) -> JointLimits:
    """Return position limits, tightened to the search bounds of a request.

    Raises:
        UnknownName: There is no such position coordinate.
        ProblemInvalid: Bounds are not an interval within the limits, or are those of a quaternion.
    """
    if not bounds:
        return limits
    lower, upper = limits.lower.copy(), limits.upper.copy()
    quaternions = {
        name
        for joint in group.joints
        if joint.type is JointType.FLOATING
        for name in joint.position_names[:4]
    }
    for name, (low, high) in bounds.items():
        if name not in group.position_names:
            raise UnknownName.among("position", name, group.position_names)
        if name in quaternions:
            raise _bad_bounds(name, "quaternions have no bounds")
        row = group.position_names.index(name)
        lower[row], upper[row] = max(lower[row], low), min(upper[row], high)
        if not (np.isfinite([low, high]).all() and lower[row] <= upper[row]):
            reason = f"[{low}, {high}] is not an interval within the limits"
            raise _bad_bounds(name, reason)
    return replace(limits, lower=lower, upper=upper)


def resolve_space(group: JointGroup, spaces: Mapping[str, str | Steering]) -> JointGroup:
    """Return the group with the steering of its bases that a request declares as cars.

    Raises:
        UnknownName: There is no such planar joint.
        ProblemInvalid: A turning radius is out of range, or the robot itself cannot drive so.
    """
    if not spaces:
        return group
    requested = {name: how for name, how in spaces.items() if isinstance(how, Steering)}
    if not requested:
        return group
    planar = [joint.name for joint in group.joints if joint.type is JointType.PLANAR]
    return steered(group, resolve_steering(steering_of(group), requested, planar))


def held_rotations(group: JointGroup, spaces: Mapping[str, str | Steering]) -> list[int]:
    """Return the coordinates of q that a search keeps at their start values.

    Raises:
        UnknownName: There is no such planar or floating joint, or no such space.
        ProblemInvalid: The rotation to hold is that of a car.
    """
    offsets: dict[str, list[int]] = {}
    iq = 0
    for joint in group.joints:
        if joint.type in _ROTATION_TYPES:
            is_planar = joint.type is JointType.PLANAR
            offsets[joint.name] = [iq + 2] if is_planar else list(range(iq, iq + 4))
        iq += joint.num_positions
    held_indices: list[int] = []
    for name, space in spaces.items():
        if name not in offsets:
            raise UnknownName.among("planar or floating joint", name, offsets)
        if isinstance(space, Steering):
            continue
        if space not in _SPACES:
            raise UnknownName.among("space", space, _SPACES)
        if space == "position" and name in steering_of(group):
            raise invalid_space(name, "a car cannot keep its rotation")
        held_indices += offsets[name] if space == "position" else []
    return sorted(held_indices)


def _bad_bounds(name: str, reason: str) -> ProblemInvalid:
    field = "search.bounds"
    return ProblemInvalid(f"{field}: {name!r}: {reason}", {"field": field, "name": name})
