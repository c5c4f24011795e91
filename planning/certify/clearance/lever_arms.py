"""Lever arms: bounds on the motion of collision shapes per joint rate, at any configuration.

Between a joint and a point that it carries lie the axes of other joints. The distance from each
axis to the next does not depend on the configuration, except for the stroke of prismatic joints
between, which their limits bound. So the sum of these distances bounds the point's distance from
the joint's axis, and that distance times an angle bounds the displacement of the point.
`motion_bounds` is sharper, for one configuration.
"""

from dataclasses import dataclass
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from jaxtyping import Float64
from pydrake.multibody.tree import BodyIndex, PlanarJoint, PrismaticJoint, RevoluteJoint
from pydrake.planning import RobotDiagram

from planning.certify.clearance.candidate_pairs import geometry_of
from planning.certify.clearance.collision_shapes import CollisionShapes
from planning.certify.clearance.motion_bounds import MovingJoint, joint_chains, moving_joints
from planning.certify.request import CertifyRequest
from planning.domain.arrays import Array
from planning.world.drake_model import DrakeModel

_lever_arm_cache: WeakKeyDictionary[RobotDiagram, dict[tuple[str | bytes, ...], Array]] = (
    WeakKeyDictionary()
)


def lever_arms_of(model: DrakeModel, request: CertifyRequest) -> Float64[np.ndarray, " nv"]:
    """Return the largest approach of two shapes per change of each of a group's coordinates.

    Two shapes that both move with a joint keep their distance, so the bound is on the displacement
    of any point of a shape. All other joints are fixed at the request's state. A lever arm is
    infinite for joints without a bound (floating) [m per rad or m].

    Raises:
        ModelInvalid: A shape of a kind that cannot be certified.
    """
    cache = _lever_arm_cache.setdefault(model.diagram, {})
    limits = request.limits
    key = (
        request.group.name,
        *(array.tobytes() for array in (request.state, limits.lower, limits.upper)),
    )
    if key not in cache:
        cache[key] = _lever_arms(model, request)
    return cache[key]


@dataclass(frozen=True)
class _JointFrames:
    """A moving joint: positions of its frames in world, and its largest extension [m]."""

    near: Array
    far: Array
    stroke: float


def _lever_arms(model: DrakeModel, request: CertifyRequest) -> Array:
    moving = moving_joints(model, request.group)
    chains = joint_chains(model, moving)
    context = model.plant.CreateDefaultContext()
    model.plant.SetPositions(context, model.apply_couplings(np.array(request.state)))
    frames = [
        _joint_frames(request, moving_joint, k, chains, context)
        for k, moving_joint in enumerate(moving)
    ]
    arms = np.zeros(len(moving))
    shapes = geometry_of(model).shapes
    for row, body in enumerate(shapes.bodies):
        joint_chain = chains.get(int(body), frozenset())
        position = _sphere_center(model, context, shapes, row)
        # From the tip inwards: a joint farther from the world has more joints before it.
        ordered = sorted(
            joint_chain, key=lambda k: len(_far_body(moving[k], k, chains)[1]), reverse=True
        )
        length = float(shapes.radii[row])
        for k in ordered:
            length += float(np.linalg.norm(position - frames[k].far))
            arms[k] = max(arms[k], length)
            length += frames[k].stroke
            position = frames[k].near
    return _by_coordinate(request, moving, arms)


def _by_coordinate(request: CertifyRequest, moving: list[MovingJoint], arms: Array) -> Array:
    """Return the sum of lever arms of all joints moved by each coordinate, followers included."""
    lever_arms = np.zeros(request.group.num_velocities)
    firsts = np.cumsum([0, *(joint.num_velocities for joint in request.group.joints)])
    for moving_joint, arm in zip(moving, arms, strict=True):
        first = int(firsts[moving_joint.group_index])
        match moving_joint.joint:
            case RevoluteJoint():
                lever_arms[first] += moving_joint.scale * arm
            case PrismaticJoint():
                lever_arms[first] += moving_joint.scale
            case PlanarJoint():
                lever_arms[first : first + 3] += [1.0, 1.0, arm]
            case _:
                lever_arms[first : int(firsts[moving_joint.group_index + 1])] = np.inf
    return lever_arms


def _joint_frames(
    request: CertifyRequest,
    moving_joint: MovingJoint,
    k: int,
    chains: dict[int, frozenset[int]],
    context: Any,
) -> _JointFrames:
    joint = moving_joint.joint
    frames = [joint.frame_on_parent(), joint.frame_on_child()]
    if _far_body(moving_joint, k, chains)[0] is joint.parent_body():
        frames.reverse()
    near, far = (np.array(frame.CalcPoseInWorld(context).translation()) for frame in frames)
    match joint:
        case RevoluteJoint():
            stroke = 0.0
        case PrismaticJoint():
            stroke = float(np.linalg.norm(far - near)) + moving_joint.scale * _limit_width(
                request, moving_joint
            )
        case _:
            stroke = np.inf
    return _JointFrames(near, far, stroke)


def _limit_width(request: CertifyRequest, moving_joint: MovingJoint) -> float:
    """Return the width of the limits of the joint that moves another."""
    first = sum(joint.num_positions for joint in request.group.joints[: moving_joint.group_index])
    return float(request.limits.upper[first] - request.limits.lower[first])


def _far_body(
    moving_joint: MovingJoint, k: int, chains: dict[int, frozenset[int]]
) -> tuple[Any, frozenset[int]]:
    """Return the body on the far side of a joint, as seen from the world, and its joint chain."""
    for body in (moving_joint.joint.child_body(), moving_joint.joint.parent_body()):
        chain = chains.get(int(body.index()), frozenset())
        if k in chain:
            return body, chain
    return moving_joint.joint.child_body(), frozenset()


def _sphere_center(model: DrakeModel, context: Any, shapes: CollisionShapes, row: int) -> Array:
    """Return the centre of a shape's bounding sphere in world [m]."""
    body = model.plant.get_body(BodyIndex(int(shapes.bodies[row])))
    return np.array(model.plant.EvalBodyPoseInWorld(context, body) @ shapes.centers[row])
