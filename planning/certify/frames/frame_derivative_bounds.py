"""Frame derivative bounds: of a frame's origin, on whole pieces of a trajectory.

From the world to the frame lie joints k = 1..n, each with a rotation R_k(t), a translation T_k(t)
and a rigid link l_k behind it: p = sum_k R_1 .. R_k (l_k + T_k), up to fixed rotations, which
change no length. Replace every Taylor coefficient at an instant by a bound on its size that holds
on the piece (a majorant): a joint that rotates by q has R(t + h) = R(t) exp([a] (q(t + h) - q(t))),
so

    |p^(m)| / m! <= the coefficient of h^m in  sum_k exp(Q_1 + .. + Q_k) (|l_k| + |T_k|),

with Q_k(h) = sum_m>0 max |q_k^(m)| h^m / m!. Where the axis moves, R = R_0 exp(delta), Q is the
integral of a majorant of the angular velocity, from `angular_velocity_bounds`.

The same series bounds rounding errors. Let e_km bound the error of q_k^(m). The error of the
computed frame is then at most the difference between the series with |q_k^(m)| + e_km and the one
with |q_k^(m)|, the constant terms e_k0 included: each power of each difference is a sum of products
in which lengths count as above. For a rotation in space the error of J is at most e_0 / 2, and that
of its derivative at most e_1 / 2 + e_0 |delta'| / 3; factors 1 + e_0 on all sizes cover both.
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

from planning.certify.clearance.motion_bounds import MovingJoint, joint_chains, moving_joints
from planning.certify.intervals import bernstein
from planning.certify.intervals.angular_velocity_bounds import angular_velocity_bounds
from planning.certify.intervals.rounding import UNIT_ROUNDOFF, rounding_bounds
from planning.certify.request import CertifyRequest
from planning.domain.arrays import Array
from planning.errors import ModelInvalid
from planning.world.drake_model import DrakeModel

_ORDER = 4
_FACTORIALS = np.array([float(factorial(m)) for m in range(_ORDER + 1)])
# Bound on the relative rounding error of sums and products here, and of kinematics.
_RELATIVE_ROUNDING = 64 * UNIT_ROUNDOFF


def derivative_bounds(
    model: DrakeModel, request: CertifyRequest, frame: str
) -> Float64[np.ndarray, "n 4"]:
    """Return bounds on |p'|, |p''|, |p'''| and |p''''| of a frame's origin on every piece.

    Raises:
        ModelInvalid: A joint moves in a way that cannot be bounded here.
    """
    return _origin_series(model, request, frame, 1)[:, 1:]


def direction_bounds(
    model: DrakeModel, request: CertifyRequest, frame: str
) -> Float64[np.ndarray, "n 4"]:
    """Return bounds on the first four derivatives of a unit vector fixed in a frame.

    The vector is R_1 .. R_n u: the same series, with a last link of length 1 and no translations.

    Raises:
        ModelInvalid: A joint moves in a way that cannot be bounded here.
    """
    return _direction_series(model, request, frame, 1)[:, 1:]


def origin_errors(
    model: DrakeModel, request: CertifyRequest, frame: str
) -> Float64[np.ndarray, "n 3"]:
    """Bound the rounding errors of a frame's origin, velocity and acceleration, by piece.

    Raises:
        ModelInvalid: A joint moves in a way that cannot be bounded here.
    """
    return _rounding_growth([
        _origin_series(model, request, frame, num_errors) for num_errors in (1, 2)
    ])[:, :3]


def direction_errors(
    model: DrakeModel, request: CertifyRequest, frame: str
) -> Float64[np.ndarray, " n"]:
    """Bound the rounding error of a unit vector fixed in a frame, on every piece.

    Raises:
        ModelInvalid: A joint moves in a way that cannot be bounded here.
    """
    return _rounding_growth([
        _direction_series(model, request, frame, num_errors) for num_errors in (1, 2)
    ])[:, 0]


def _rounding_growth(bounds: list[Array]) -> Array:
    """Return the second minus the first bound, rounding errors of both included."""
    bound, wider_bound = bounds
    with np.errstate(invalid="ignore"):
        return np.nan_to_num(
            wider_bound - bound + _RELATIVE_ROUNDING * wider_bound, nan=np.inf, posinf=np.inf
        )


def _origin_series(
    model: DrakeModel, request: CertifyRequest, frame: str, num_errors: int
) -> Array:
    """Bound the origin and its derivatives plus `num_errors` times the rounding errors, (n, 5)."""
    count = request.trajectory.num_pieces
    total, rotation_sum = np.zeros((count, _ORDER + 1)), np.zeros((count, _ORDER + 1))
    with np.errstate(over="ignore", invalid="ignore"):
        for link in _links(model, request, frame):
            rotation, translation = _joint_majorants(model, request, link.joint, num_errors)
            rotation_sum += rotation
            arm = np.array(translation)
            arm[:, 0] += link.length
            total += _product(_exponential(rotation_sum), arm)
    # NaN is the result of overflow: no bound.
    return np.where(np.isnan(total), np.inf, total * _FACTORIALS)


def _direction_series(
    model: DrakeModel, request: CertifyRequest, frame: str, num_errors: int
) -> Array:
    rotation_sum = np.zeros((request.trajectory.num_pieces, _ORDER + 1))
    with np.errstate(over="ignore", invalid="ignore"):
        for link in _links(model, request, frame):
            rotation_sum += _joint_majorants(model, request, link.joint, num_errors)[0]
        total = _exponential(rotation_sum) * _FACTORIALS
    return np.where(np.isnan(total), np.inf, total)


@dataclass(frozen=True)
class _ChainLink:
    """A joint of the chain, and its distance to the next joint or to the frame [m]."""

    joint: MovingJoint
    length: float


def _links(model: DrakeModel, request: CertifyRequest, name: str) -> list[_ChainLink]:
    """Return the chain of joints between the world and a frame, in order."""
    moving = moving_joints(model, request.group)
    chains = joint_chains(model, moving)
    context = model.plant.CreateDefaultContext()
    full = model.embed(request.group, request.reference, request.state)
    model.plant.SetPositions(context, full)
    frame = model.frame(name)
    ends: list[tuple[int, MovingJoint, Array, Array]] = []
    for k in chains[int(frame.body)]:
        joint = moving[k].joint
        near, far = joint.frame_on_parent(), joint.frame_on_child()
        # Drake may run a joint from the tip to the base.
        if k not in chains[int(joint.child_body().index())]:
            near, far = far, near
        rank = len(chains[int(far.body().index())])
        positions = [np.array(f.CalcPoseInWorld(context).translation()) for f in (near, far)]
        ends.append((rank, moving[k], positions[0], positions[1]))
    ends.sort(key=lambda entry: entry[0])
    tip = np.array(frame.pose(context).translation())
    # Without a joint between world and frame the frame does not move.
    nexts = [near for _, _, near, _ in ends[1:]] + [tip] * bool(ends)
    return [
        _ChainLink(joint, float(np.linalg.norm(there - far)))
        for (_, joint, _, far), there in zip(ends, nexts, strict=True)
    ]


def _joint_majorants(
    model: DrakeModel, request: CertifyRequest, moving: MovingJoint, num_errors: int
) -> tuple[Array, Array]:
    """Return majorants of a joint's rotation, without constant, and of its translation, (n, 5).

    The constant of the rotation is the rounding error beyond the first time.
    """
    zero = np.zeros((request.trajectory.num_pieces, _ORDER + 1))
    majorants = _block_majorants(request, moving, num_errors)
    joint = moving.joint
    match joint:
        case RevoluteJoint():
            return _with_constant(*majorants[0]), zero
        case PrismaticJoint():
            return zero, _with_displacement(
                majorants[0][0], _initial_displacements(model, request, joint, 0)
            )
        case PlanarJoint():
            return _with_constant(*majorants[1]), _with_displacement(
                majorants[0][0], _initial_displacements(model, request, joint, 0, 2)
            )
        case QuaternionFloatingJoint():
            return _spatial_rotation_majorant(*majorants[0]), _with_displacement(
                majorants[1][0], _initial_displacements(model, request, joint, 4, 7)
            )
        case _:
            message = f"joint {joint.name()!r} of kind {joint.type_name()!r} cannot be certified"
            raise ModelInvalid(message, {"joint": joint.name(), "reason": message})


def _block_majorants(
    request: CertifyRequest, moving: MovingJoint, num_errors: int
) -> list[tuple[Array, Array]]:
    """Return majorants of the joint's blocks, |c^(m)| / m! on every piece, each shape (n, 5).

    The constant is the largest distance of the block from its value at the beginning of the piece.
    Rounding errors are added `num_errors` times; those of the block itself, beyond the first time,
    are returned separately (n,).
    """
    curve, widths = request.trajectory, np.diff(request.trajectory.breaks)
    joints = request.group.joints
    begin = sum(joint.num_velocities for joint in joints[: moving.group_index])
    majorants: list[tuple[Array, Array]] = []
    for _, indices in joints[moving.group_index].blocks:
        columns = [begin + i for i in indices]
        coefficients = curve.coefficients[:, :, columns]
        series, rounding_errors = np.empty((2, curve.num_pieces, _ORDER + 1))
        for m in range(_ORDER + 1):
            form = bernstein.from_power(bernstein.derivative(coefficients, m), widths)
            errors = rounding_bounds(np.abs(form).max(axis=1), coefficients, widths, m)
            rounding_errors[:, m] = np.linalg.norm(errors, axis=1)
            if m == 0:
                form = form - form[:, :1]
            series[:, m] = np.linalg.norm(form, axis=2).max(axis=1)
        series = moving.scale * (series + num_errors * rounding_errors) / _FACTORIALS
        majorants.append((series, moving.scale * (num_errors - 1) * rounding_errors[:, 0]))
    return majorants


def _initial_displacements(
    model: DrakeModel, request: CertifyRequest, joint: Any, first: int, last: int = 1
) -> Array:
    """Return the displacement of a joint at the beginning of each piece [m], shape (n,)."""
    q = request.trajectory.positions(request.trajectory.breaks[:-1])
    full = model.embed(request.group, q, request.state)
    begin = joint.position_start()
    return np.linalg.norm(full[:, begin + first : begin + last], axis=1)


def _with_displacement(series: Array, displacements: Array) -> Array:
    total = np.array(series)
    total[:, 0] += displacements
    return total


def _with_constant(series: Array, constant: Array) -> Array:
    total = np.array(series)
    total[:, 0] = constant
    return total


def _spatial_rotation_majorant(series: Array, constant: Array) -> Array:
    """Return the majorant of a rotation in space from that of its tangent."""
    rates = angular_velocity_bounds((series * _FACTORIALS)[:, 1:].T * (1 + constant))
    return np.column_stack([constant, rates.T]) / _FACTORIALS


def _exponential(series: Array) -> Array:
    """Return exp of a series."""
    powers = _with_constant(series, np.zeros(len(series)))
    total = term = np.zeros_like(series)
    total[:, 0] = 1.0
    for j in range(1, _ORDER + 1):
        term = _product(term, powers) / j
        total = total + term
    return total * np.exp(series[:, :1])


def _product(a: Array, b: Array) -> Array:
    """Return products of series, truncated to the number of coefficients."""
    product = np.zeros_like(a)
    for i in range(_ORDER + 1):
        product[:, i:] += a[:, i : i + 1] * b[:, : _ORDER + 1 - i]
    return product
