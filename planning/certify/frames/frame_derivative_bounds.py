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
from functools import cached_property
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

from planning.certify.clearance.motion_bounds import MovingJoint
from planning.certify.frames.frame_chain import ChainLink, chain_links
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
_RELATIVE_ROUNDING = 2**10 * UNIT_ROUNDOFF
# Times that rounding errors are added: in the bound, and in the wider one that bounds errors.
_NUM_ERRORS = np.array([1.0, 2.0])[:, None, None]


@dataclass(frozen=True)
class PointBounds:
    """Bounds on a point's motion on every piece of a trajectory.

    Attributes:
        derivatives: Bounds on |p'|, |p''|, |p'''| and |p''''|, shape (n, 4).
        errors: Bounds on the rounding errors of p, p' and p'', shape (n, 3).
    """

    derivatives: Float64[np.ndarray, "n 4"]
    errors: Float64[np.ndarray, "n 3"]


def origin_bounds(model: DrakeModel, request: CertifyRequest, frame: str) -> PointBounds:
    """Return the bounds of a frame's origin.

    Raises:
        ModelInvalid: A joint moves in a way that cannot be bounded here.
    """
    return _FrameSeries(model, request, frame).of_origin()


def direction_bounds(model: DrakeModel, request: CertifyRequest, frame: str) -> PointBounds:
    """Return the bounds of the tip of a unit vector fixed in a frame.

    It is R_1 .. R_n u: the same series, with a last link of length 1 and no translations.

    Raises:
        ModelInvalid: A joint moves in a way that cannot be bounded here.
    """
    return _FrameSeries(model, request, frame).of_direction()


class _FrameSeries:
    """Series of one frame, of both numbers of errors: shape (2, n, 5)."""

    def __init__(self, model: DrakeModel, request: CertifyRequest, frame: str) -> None:
        self._model, self._request = model, request
        self._shape = 2, request.trajectory.num_pieces, _ORDER + 1
        with np.errstate(over="ignore", invalid="ignore"):
            self._links = chain_links(model, request, frame)
            majorants = [self._joint_majorants(link.joint) for link in self._links]
        self._rotations = np.array([rotation for rotation, _ in majorants])
        self._translations = [translation for _, translation in majorants]

    def of_origin(self) -> PointBounds:
        total = np.zeros(self._shape)
        with np.errstate(over="ignore", invalid="ignore"):
            if self._links:
                rotations = _exponential(np.cumsum(self._rotations, axis=0))
                arms = np.array([
                    _arm(*entry) for entry in zip(self._links, self._translations, strict=True)
                ])
                total = np.sum(_product(rotations, arms), axis=0)
            return _point_bounds(total * _FACTORIALS)

    def of_direction(self) -> PointBounds:
        with np.errstate(over="ignore", invalid="ignore"):
            rotation = np.sum(self._rotations, axis=0) + np.zeros(self._shape)
            return _point_bounds(_exponential(rotation) * _FACTORIALS)

    def _joint_majorants(self, moving: MovingJoint) -> tuple[Array, Array]:
        """Return majorants of a joint's rotation, without constant, and of its translation.

        The constant of the rotation is the rounding error beyond the first time.
        """
        zero = np.zeros(self._shape)
        majorants, joint = self._block_majorants(moving), moving.joint
        match joint:
            case RevoluteJoint():
                return _with_constant(*majorants[0]), zero
            case PrismaticJoint():
                return zero, self._with_displacement(majorants[0][0], joint, 0)
            case PlanarJoint():
                translation = self._with_displacement(majorants[0][0], joint, 0, 2)
                return _with_constant(*majorants[1]), translation
            case QuaternionFloatingJoint():
                translation = self._with_displacement(majorants[1][0], joint, 4, 7)
                return _spatial_rotation_majorant(*majorants[0]), translation
            case _:
                message = (
                    f"joint {joint.name()!r} of kind {joint.type_name()!r} cannot be certified"
                )
                raise ModelInvalid(message, {"joint": joint.name(), "reason": message})

    def _block_majorants(self, moving: MovingJoint) -> list[tuple[Array, Array]]:
        """Return majorants of the joint's blocks, |c^(m)| / m! on every piece.

        The constant is the largest distance of the block from its value at the beginning of the
        piece. The rounding errors of the block itself, beyond the first time, are returned
        separately, shape (2, n).
        """
        joints = self._request.group.joints
        begin = sum(joint.num_velocities for joint in joints[: moving.group_index])
        majorants: list[tuple[Array, Array]] = []
        for _, indices in joints[moving.group_index].blocks:
            columns = [begin + i for i in indices]
            forms, sizes, errors = self._forms
            if len(columns) == 1:
                sizes, errors = sizes[:, :, begin + indices[0]], errors[:, :, begin + indices[0]]
            else:
                sizes = np.stack([_largest_norm(form[:, :, columns]) for form in forms], axis=1)
                errors = np.linalg.norm(errors[:, :, columns], axis=2)
            series = moving.scale * (sizes + _NUM_ERRORS * errors) / _FACTORIALS
            constants = moving.scale * (_NUM_ERRORS[:, :, 0] - 1) * errors[:, 0]
            majorants.append((series, constants))
        return majorants

    @cached_property
    def _forms(self) -> tuple[list[Array], Array, Array]:
        """Bernstein forms of the derivatives by order, their sizes, and their rounding errors.

        Positions are relative to those at the beginning of the piece. Sizes are the largest
        coefficients of each coordinate, shape (n, 5, nv), as errors are.
        """
        curve = self._request.trajectory
        forms, sizes, errors = list[Array](), list[Array](), list[Array]()
        for m in range(_ORDER + 1):
            form = bernstein.from_power(
                bernstein.derivative(curve.coefficients, m), np.diff(curve.breaks)
            )
            largest = np.abs(form).max(axis=1)
            errors.append(rounding_bounds(largest, curve.coefficients, np.diff(curve.breaks), m))
            forms.append(form if m else form - form[:, :1])
            sizes.append(largest if m else np.abs(forms[0]).max(axis=1))
        return forms, np.stack(sizes, axis=1), np.stack(errors, axis=1)

    def _with_displacement(self, series: Array, joint: Any, first: int, last: int = 1) -> Array:
        """Return the series with the displacement of a joint at the beginning of each piece [m]."""
        request = self._request
        q = request.trajectory.positions(request.trajectory.breaks[:-1])
        full = self._model.embed(request.group, q, request.state)
        begin = joint.position_start()
        total = np.array(series)
        total[:, :, 0] += np.linalg.norm(full[:, begin + first : begin + last], axis=1)
        return total


def _point_bounds(series: Array) -> PointBounds:
    """Return the bounds by series of both numbers of errors; errors are their difference."""
    # NaN is the result of overflow: no bound.
    bound, wider_bound = np.where(np.isnan(series), np.inf, series)
    growth = wider_bound - bound + _RELATIVE_ROUNDING * wider_bound
    errors = np.nan_to_num(growth, nan=np.inf, posinf=np.inf)
    return PointBounds(bound[:, 1:], errors[:, :3])


def _arm(link: ChainLink, translation: Array) -> Array:
    """Return the majorant of a link with the translation of its joint."""
    total = np.array(translation)
    total[:, :, 0] += link.length
    return total


def _largest_norm(form: Array) -> Array:
    """Return the largest norm of a block's coefficients on each piece."""
    return np.linalg.norm(form, axis=2).max(axis=1)


def _with_constant(series: Array, constant: Array) -> Array:
    total = np.array(series)
    total[..., 0] = constant
    return total


def _spatial_rotation_majorant(series: Array, constant: Array) -> Array:
    """Return the majorant of a rotation in space from that of its tangent."""
    sizes = np.moveaxis((series * _FACTORIALS)[..., 1:] * (1 + constant)[..., None], -1, 0)
    rates = np.moveaxis(angular_velocity_bounds(sizes), 0, -1)
    return np.concatenate([constant[..., None], rates], axis=-1) / _FACTORIALS


def _exponential(series: Array) -> Array:
    """Return exp of series."""
    powers = _with_constant(series, np.zeros(series.shape[:-1]))
    total = term = np.zeros_like(series)
    total[..., 0] = 1.0
    for j in range(1, _ORDER + 1):
        term = _product(term, powers) / j
        total = total + term
    return total * np.exp(series[..., :1])


def _product(a: Array, b: Array) -> Array:
    """Return products of series, truncated to the number of coefficients."""
    product = np.zeros_like(a)
    for i in range(_ORDER + 1):
        product[..., i:] += a[..., i : i + 1] * b[..., : _ORDER + 1 - i]
    return product
