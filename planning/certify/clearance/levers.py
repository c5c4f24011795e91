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

_read: WeakKeyDictionary[RobotDiagram, dict[tuple[str | bytes, ...], Array]] = WeakKeyDictionary()


def levers_of(model: DrakeModel, request: CertifyRequest) -> Float64[np.ndarray, " nv"]:
    """Return the largest approach of two shapes per change of each of a group's coordinates.

    Two shapes that both move with a joint keep their distance, so the bound is on the displacement
    of any point of a shape. All other joints are fixed at the request's state. A lever is infinite
    for joints without a bound (floating) [m per rad or m].

    Raises:
        ModelInvalid: A shape of a kind that cannot be certified.
    """
    known = _read.setdefault(model.diagram, {})
    limits = request.limits
    key = (
        request.group.name,
        *(array.tobytes() for array in (request.state, limits.lower, limits.upper)),
    )
    if key not in known:
        known[key] = _levers(model, request)
    return known[key]


@dataclass(frozen=True)
class _Link:
    """A moving joint: positions of its frames in world, and its largest extension [m]."""

    near: Array
    far: Array
    stroke: float


def _levers(model: DrakeModel, request: CertifyRequest) -> Array:
    moving = moving_joints(model, request.group)
    chains = joint_chains(model, moving)
    context = model.plant.CreateDefaultContext()
    model.plant.SetPositions(context, model.follow(np.array(request.state)))
    links = [_link(request, moved, k, chains, context) for k, moved in enumerate(moving)]
    arms = np.zeros(len(moving))
    shapes = geometry_of(model).shapes
    for row, body in enumerate(shapes.bodies):
        carried = chains.get(int(body), frozenset())
        place = _place(model, context, shapes, row)
        # From the tip inwards: a joint farther from the world has more joints before it.
        ordered = sorted(carried, key=lambda k: len(_outer(moving[k], k, chains)[1]), reverse=True)
        length = float(shapes.radii[row])
        for k in ordered:
            length += float(np.linalg.norm(place - links[k].far))
            arms[k] = max(arms[k], length)
            length += links[k].stroke
            place = links[k].near
    return _by_coordinate(request, moving, arms)


def _by_coordinate(request: CertifyRequest, moving: list[MovingJoint], arms: Array) -> Array:
    """Return the sum of levers of all joints moved by each coordinate, followers included."""
    levers = np.zeros(request.group.num_velocities)
    firsts = np.cumsum([0, *(joint.num_velocities for joint in request.group.joints)])
    for moved, arm in zip(moving, arms, strict=True):
        first = int(firsts[moved.member])
        match moved.joint:
            case RevoluteJoint():
                levers[first] += moved.scale * arm
            case PrismaticJoint():
                levers[first] += moved.scale
            case PlanarJoint():
                levers[first : first + 3] += [1.0, 1.0, arm]
            case _:
                levers[first : int(firsts[moved.member + 1])] = np.inf
    return levers


def _link(
    request: CertifyRequest,
    moved: MovingJoint,
    k: int,
    chains: dict[int, frozenset[int]],
    context: Any,
) -> _Link:
    joint = moved.joint
    frames = [joint.frame_on_parent(), joint.frame_on_child()]
    if _outer(moved, k, chains)[0] is joint.parent_body():
        frames.reverse()
    near, far = (np.array(frame.CalcPoseInWorld(context).translation()) for frame in frames)
    match joint:
        case RevoluteJoint():
            stroke = 0.0
        case PrismaticJoint():
            stroke = float(np.linalg.norm(far - near)) + moved.scale * _range(request, moved)
        case _:
            stroke = np.inf
    return _Link(near, far, stroke)


def _range(request: CertifyRequest, moved: MovingJoint) -> float:
    """Return the width of the limits of the joint that moves another."""
    first = sum(joint.num_positions for joint in request.group.joints[: moved.member])
    return float(request.limits.upper[first] - request.limits.lower[first])


def _outer(
    moved: MovingJoint, k: int, chains: dict[int, frozenset[int]]
) -> tuple[Any, frozenset[int]]:
    """Return the body on the far side of a joint, as seen from the world, and its joint chain."""
    for body in (moved.joint.child_body(), moved.joint.parent_body()):
        chain = chains.get(int(body.index()), frozenset())
        if k in chain:
            return body, chain
    return moved.joint.child_body(), frozenset()


def _place(model: DrakeModel, context: Any, shapes: CollisionShapes, row: int) -> Array:
    """Return the centre of a shape's bounding sphere in world [m]."""
    body = model.plant.get_body(BodyIndex(int(shapes.bodies[row])))
    return np.array(model.plant.EvalBodyPoseInWorld(context, body) @ shapes.centers[row])
