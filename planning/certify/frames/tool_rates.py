"""ToolRates: bounds on the speeds and accelerations, linear and angular, of a tool frame.

The trajectory is cut into cells with little motion of each joint. In the middle of each, Drake
gives the Jacobian's columns (a_k; v_k), of rotation and of translation, for every joint coordinate
that moves, followers included. With |rate| <= r_k and |its derivative| <= b_k on the cell,

    |p'| <= sum v_k r_k,    |p''| <= sum v_k b_k + sum_ij |a_i x v_j| r_i r_j,
    |omega| <= sum a_k r_k,    |omega'| <= sum a_k b_k + (sum a_k r_k)^2 / 2,

where i is no farther from the tip than j (dv_j / dq_i = a_i x v_j), which max(a_i v_j, a_j v_i)
covers for any order. By the same derivative no v_j grows faster than sum r times the largest, so
while the joints move by D in sum each stays within (e^D - 1) max v of its value in the middle.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.certify.intervals.angular_velocity_bounds import angular_velocity_bounds
from planning.certify.intervals.equal_split import split_equally
from planning.certify.request import CertifyRequest
from planning.domain.arrays import Array, Indices
from planning.domain.request.deadline import Deadline
from planning.domain.robot.joints import JointType
from planning.world.drake_model import DrakeModel

# Largest sum of joint motions on a cell [rad or m].
_MAX_CELL_MOTION = 0.2
_BATCH_SIZE = 256


@dataclass(frozen=True)
class RateCells:
    """Time intervals of a trajectory, with bounds that hold on all of each.

    Attributes:
        begins: First instants [s], shape (n,).
        widths: Durations [s].
        speed: Bound on the speed of the tool's origin [m/s].
        acceleration: Bound on the acceleration of the tool's origin [m/s^2].
        angular_speed: Bound on the angular speed of the tool [rad/s].
        angular_acceleration: Bound on the angular acceleration of the tool [rad/s^2].
    """

    begins: Float64[np.ndarray, " n"]
    widths: Float64[np.ndarray, " n"]
    speed: Float64[np.ndarray, " n"]
    acceleration: Float64[np.ndarray, " n"]
    angular_speed: Float64[np.ndarray, " n"]
    angular_acceleration: Float64[np.ndarray, " n"]


class ToolRates:
    """Rates of one tool frame along one trajectory, by Drake in a context of its own."""

    def __init__(self, model: DrakeModel, request: CertifyRequest, frame: str) -> None:
        """Prepare; the frame must exist."""
        self._model, self._request = model, request
        self._plant = model.plant
        self._frame = model.frame(frame)
        self._context = model.plant.CreateDefaultContext()
        self._columns, self._leaders, self._scales = _moving_coordinates(model, request)

    def poses(
        self, times: Float64[np.ndarray, " n"], deadline: Deadline
    ) -> tuple[Float64[np.ndarray, "n 3 3"], Float64[np.ndarray, "n 3"]]:
        """Return R_WT and p_WT [m] at instants.

        Raises:
            DeadlineExceeded: Time ran out.
            Canceled: The caller canceled.
        """
        found = np.empty((len(times), 4, 4))
        for i, q in enumerate(self._plant_positions(times)):
            if i % _BATCH_SIZE == 0:
                deadline.check("certify")
            self._plant.SetPositions(self._context, q)
            found[i] = self._frame.pose(self._context).GetAsMatrix4()
        return found[:, :3, :3], found[:, :3, 3]

    def cells(self, begin: float, end: float) -> RateCells:
        """Return the cells between two instants, both of which must be breaks of the trajectory."""
        curve = self._request.trajectory
        breaks = curve.breaks
        middles = (breaks[:-1] + breaks[1:]) / 2
        pieces = np.flatnonzero((middles > begin) & (middles < end))
        rates, accelerations = _joint_rates(self._request, pieces)
        rates, accelerations = rates[:, self._leaders], accelerations[:, self._leaders]
        rates, accelerations = rates * self._scales, accelerations * self._scales
        widths = np.diff(breaks)[pieces]
        counts = np.maximum(1, np.ceil(rates.sum(axis=1) * widths / _MAX_CELL_MOTION)).astype(
            np.int64
        )
        owners, within = split_equally(counts)
        widths = (widths / counts)[owners]
        begins = breaks[pieces][owners] + within * widths
        rates, accelerations = rates[owners], accelerations[owners]
        angular_columns, linear_columns = self._jacobian_norms(begins + widths / 2)
        half_motion = (rates.sum(axis=1) * widths / 2)[:, None]
        linear_columns = linear_columns + np.expm1(half_motion) * linear_columns.max(
            axis=1, keepdims=True
        )
        pairs = angular_columns[:, :, None] * linear_columns[:, None, :]
        pairs = np.maximum(pairs, pairs.transpose(0, 2, 1))
        angular_speed = (angular_columns * rates).sum(axis=1)
        return RateCells(
            begins=begins,
            widths=widths,
            speed=(linear_columns * rates).sum(axis=1),
            acceleration=(linear_columns * accelerations).sum(axis=1)
            + np.einsum("ci,cij,cj->c", rates, pairs, rates),
            angular_speed=angular_speed,
            angular_acceleration=(angular_columns * accelerations).sum(axis=1)
            + angular_speed**2 / 2,
        )

    def _plant_positions(self, times: Array) -> Array:
        q = self._request.trajectory.positions(times)
        return self._model.embed(self._request.group, q, self._request.state)

    def _jacobian_norms(self, times: Array) -> tuple[Array, Array]:
        """Return the norms of the Jacobian's columns, rotation and translation, at instants."""
        jacobians = np.empty((len(times), 6, len(self._columns)))
        for i, q in enumerate(self._plant_positions(times)):
            self._plant.SetPositions(self._context, q)
            jacobian = self._frame.velocity_jacobian(self._plant, self._context)
            jacobians[i] = jacobian[:, self._columns]
        return np.linalg.norm(jacobians[:, :3], axis=1), np.linalg.norm(jacobians[:, 3:], axis=1)


def _moving_coordinates(
    model: DrakeModel, request: CertifyRequest
) -> tuple[Indices, Indices, Array]:
    """Return the moving velocity coordinates of the plant, their leaders in v, and the factors.

    The factor is the ratio of the two rates, not negative.
    """
    group_columns = model.velocity_indices(request.group)
    by_column = {int(column): (i, 1.0) for i, column in enumerate(group_columns)}
    for c in model.followers_of(request.group):
        leader, scale = by_column[c.leader_velocity]
        by_column[c.follower_velocity] = leader, scale * abs(c.multiplier)
    columns = np.array(list(by_column), dtype=np.intp)
    leaders = np.array([leader for leader, _ in by_column.values()], dtype=np.intp)
    return columns, leaders, np.array([scale for _, scale in by_column.values()])


def _joint_rates(request: CertifyRequest, pieces: Any) -> tuple[Array, Array]:
    """Bound each coordinate's rate and its derivative on pieces, shape (pieces, nv).

    For a floating joint, omega = J_r(delta) delta' is no longer than delta'.
    """
    forms = [form[:, pieces] for form in request.bernstein_forms[:3]]
    rounding_errors = request.rounding_errors[1:3]
    rates, accelerations = (
        np.abs(form).max(axis=2).T + error
        for form, error in zip(forms[1:], rounding_errors, strict=True)
    )
    begin = 0
    for joint in request.group.joints:
        if joint.type is JointType.FLOATING:
            angular = slice(begin, begin + 3)
            sizes = [
                np.linalg.norm(form[angular], axis=0).max(axis=1) + np.linalg.norm(error[angular])
                for form, error in zip(forms[1:], rounding_errors, strict=True)
            ]
            rate, acceleration = angular_velocity_bounds(np.stack(sizes))
            rates[:, angular], accelerations[:, angular] = rate[:, None], acceleration[:, None]
        begin += joint.num_velocities
    return rates, accelerations
