"""Bounds on the derivatives of a frame's origin along a trajectory, on whole pieces.

From the world to the frame lie joints k = 1..n, each with a rotation R_k(t), a shift T_k(t) and a
rigid link l_k behind it: p = sum_k R_1 .. R_k (l_k + T_k), up to fixed turns, which change no
length. Replace every Taylor coefficient at an instant by a bound on its size that holds on the
piece (a majorant): a joint that turns by q has R(t + h) = R(t) exp([a] (q(t + h) - q(t))), so

    |p^(m)| / m! <= the coefficient of h^m in  sum_k exp(Q_1 + .. + Q_k) (|l_k| + |T_k|),

with Q_k(h) = sum_m>0 max |q_k^(m)| h^m / m!. Where the axis moves, R = R_0 exp(delta), Q is the
integral of a majorant of the angular velocity, which `turn_bounds` has.
"""

from dataclasses import dataclass
from math import factorial
from typing import Any

import numpy as np
from jaxtyping import Float64
from pydrake.multibody.tree import (
    PlanarJoint,
    PrismaticJoint,
    QuaternionFloatingJoint,
    RevoluteJoint,
)

from planning.certify import bernstein
from planning.certify.motion_bounds import MovingJoint, joint_chains, moving_joints
from planning.certify.request import CertifyRequest
from planning.certify.turn_bounds import turn_bounds
from planning.errors import ModelInvalid
from planning.world.drake_model import DrakeModel

type Array = np.ndarray[Any, np.dtype[np.float64]]

_ORDER = 4
_FACTORIALS = np.array([float(factorial(m)) for m in range(_ORDER + 1)])


def derivative_bounds(
    model: DrakeModel, request: CertifyRequest, frame: str
) -> Float64[np.ndarray, "n 4"]:
    """Return bounds on |p'|, |p''|, |p'''| and |p''''| of a frame's origin on every piece.

    Raises:
        ModelInvalid: A joint moves in a way that cannot be bounded here.
    """
    links = _links(model, request, frame)
    count = request.trajectory.num_pieces
    total, turned = np.zeros((count, _ORDER + 1)), np.zeros((count, _ORDER + 1))
    with np.errstate(over="ignore", invalid="ignore"):
        for link in links:
            turn, shift = _series(model, request, link.moving)
            turned += turn
            reach = np.array(shift)
            reach[:, 0] += link.length
            total += _product(_exponential(turned), reach)
    # Not a number is what overflow leaves behind: no bound.
    return np.where(np.isnan(total), np.inf, total * _FACTORIALS)[:, 1:]


def direction_bounds(
    model: DrakeModel, request: CertifyRequest, frame: str
) -> Float64[np.ndarray, "n 4"]:
    """Return bounds on the first four derivatives of a unit vector that turns with a frame.

    It is R_1 .. R_n u: the same series, with a last link of length 1 and no shifts.

    Raises:
        ModelInvalid: A joint moves in a way that cannot be bounded here.
    """
    turned = np.zeros((request.trajectory.num_pieces, _ORDER + 1))
    with np.errstate(over="ignore", invalid="ignore"):
        for link in _links(model, request, frame):
            turned += _series(model, request, link.moving)[0]
        total = _exponential(turned) * _FACTORIALS
    return np.where(np.isnan(total), np.inf, total)[:, 1:]


@dataclass(frozen=True)
class _Link:
    """A joint on the way to the frame, and how far the next one, or the frame, is from it [m]."""

    moving: MovingJoint
    length: float


def _links(model: DrakeModel, request: CertifyRequest, name: str) -> list[_Link]:
    """Return what lies between the world and a frame, in order."""
    moving = moving_joints(model, request.group)
    chains = joint_chains(model, moving)
    context = model.plant.CreateDefaultContext()
    full = model.embed(request.group, request.reference, request.state)
    model.plant.SetPositions(context, full)
    frame = model.frame(name)
    ends: list[tuple[int, MovingJoint, Array, Array]] = []
    for k in chains[int(frame.body().index())]:
        joint = moving[k].joint
        near, far = joint.frame_on_parent(), joint.frame_on_child()
        # Drake may run a joint from the tip to the base.
        if k not in chains[int(joint.child_body().index())]:
            near, far = far, near
        rank = len(chains[int(far.body().index())])
        places = [np.array(f.CalcPoseInWorld(context).translation()) for f in (near, far)]
        ends.append((rank, moving[k], places[0], places[1]))
    ends.sort(key=lambda entry: entry[0])
    tip = np.array(frame.CalcPoseInWorld(context).translation())
    # Without a joint in between the frame does not move, however far away it is.
    nexts = [near for _, _, near, _ in ends[1:]] + [tip] * bool(ends)
    return [
        _Link(joint, float(np.linalg.norm(there - far)))
        for (_, joint, _, far), there in zip(ends, nexts, strict=True)
    ]


def _series(model: DrakeModel, request: CertifyRequest, moving: MovingJoint) -> tuple[Array, Array]:
    """Return majorants of a joint's turn, without constant, and of its shift, shape (n, 5)."""
    nothing = np.zeros((request.trajectory.num_pieces, _ORDER + 1))
    sizes = _sizes(request, moving)
    joint = moving.joint
    match joint:
        case RevoluteJoint():
            return _without_constant(sizes[0]), nothing
        case PrismaticJoint():
            return nothing, _placed(sizes[0], _shifts(model, request, joint, 0))
        case PlanarJoint():
            return _without_constant(sizes[1]), _placed(
                sizes[0], _shifts(model, request, joint, 0, 2)
            )
        case QuaternionFloatingJoint():
            return _turn(sizes[0]), _placed(sizes[1], _shifts(model, request, joint, 4, 7))
        case _:
            message = f"joint {joint.name()!r} of kind {joint.type_name()!r} cannot be certified"
            raise ModelInvalid(message, {"joint": joint.name(), "reason": message})


def _sizes(request: CertifyRequest, moving: MovingJoint) -> list[Array]:
    """Return majorants of the member's blocks, |c^(m)| / m! on every piece, each shape (n, 5).

    The constant is how far the block is from where the piece begins.
    """
    curve, widths = request.trajectory, np.diff(request.trajectory.breaks)
    joints = request.group.joints
    begin = sum(joint.num_velocities for joint in joints[: moving.member])
    member = joints[moving.member]
    found: list[Array] = []
    for _, indices in member.blocks:
        columns = [begin + i for i in indices]
        coefficients = curve.coefficients[:, :, columns]
        series = np.empty((curve.num_pieces, _ORDER + 1))
        for m in range(_ORDER + 1):
            form = bernstein.from_power(bernstein.derivative(coefficients, m), widths)
            if m == 0:
                form = form - form[:, :1]
            series[:, m] = np.linalg.norm(form, axis=2).max(axis=1)
        found.append(moving.scale * series / _FACTORIALS)
    return found


def _shifts(
    model: DrakeModel, request: CertifyRequest, joint: Any, first: int, last: int = 1
) -> Array:
    """Return how far a joint is shifted where each piece begins [m], shape (n,)."""
    q = request.trajectory.positions(request.trajectory.breaks[:-1])
    full = model.embed(request.group, q, request.state)
    begin = joint.position_start()
    return np.linalg.norm(full[:, begin + first : begin + last], axis=1)


def _placed(sizes: Array, shifts: Array) -> Array:
    placed = np.array(sizes)
    placed[:, 0] += shifts
    return placed


def _without_constant(series: Array) -> Array:
    found = np.array(series)
    found[:, 0] = 0.0
    return found


def _turn(sizes: Array) -> Array:
    """Return the majorant of a turn in space from that of its tangent, without constant."""
    rates = turn_bounds((sizes * _FACTORIALS)[:, 1:].T)
    return np.column_stack([np.zeros(len(sizes)), rates.T]) / _FACTORIALS


def _exponential(series: Array) -> Array:
    """Return exp of series without constant."""
    total = term = np.zeros_like(series)
    total[:, 0] = 1.0
    for j in range(1, _ORDER + 1):
        term = _product(term, series) / j
        total = total + term
    return total


def _product(a: Array, b: Array) -> Array:
    """Return products of series, cut off behind the last coefficient."""
    product = np.zeros_like(a)
    for i in range(_ORDER + 1):
        product[:, i:] += a[:, i : i + 1] * b[:, : _ORDER + 1 - i]
    return product
