"""LoadLinearization: a load along one curve at one path velocity, linearized in both."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array, Flags, Indices
from planning.refine.constraints.load import MAX_STATIC_LOAD, Load, difference_quotients
from planning.refine.curves.curve_samples import CurveSamples
from planning.refine.model.path_velocity_constraints import RATE_PENALTY
from planning.refine.model.penalty_qp import PenaltyRows

# Load ratios below this have no row.
_MIN_LOAD_RATIO = 0.5
# The same for static loads, which change with the curve alone.
_MIN_STATIC_LOAD_RATIO = 0.75
# Largest change of a row's sum by a step, in units of its entries: b may grow by half.
_MAX_CHANGE_FACTOR = 1.5
# Angles between the normals of tangent planes and the vector itself [rad].
_TILT_ANGLES = (0.2, 0.5)
# A tangent plane bounds a ball on one side; a scalar is bounded on both.
_UPPER_SIGNS, _BOTH_SIGNS = (1.0,), (1.0, -1.0)


@dataclass(frozen=True)
class LoadLinearization:
    """Large ratios of one load at samples on every interval of the grid, with derivatives.

    Attributes:
        sample_indices: Indices of the samples, shape (m,).
        control_points: Indices of the control points with nonzero weight there, shape (m, 4).
        intervals: Index of each sample's interval, on which u is constant, shape (m,).
        ratios: Load ratios, shape (m, rows).
        by_control_point: Their derivatives by coordinates of control points, shape (m, rows, 4,
            nq).
        by_path_velocity: By b at both ends of the interval, times b, shape (m, rows, 2).
        is_selected: Mask of the rows to use, without duplicates, shape (m, rows).
        signs: Signs with a bound: above, or above and below.
        bound: Bound of the ratios.
        penalty: Penalty of exceeding the bound by its own size, in durations.
    """

    sample_indices: Indices
    control_points: Indices
    intervals: Indices
    ratios: Array
    by_control_point: Array
    by_path_velocity: Array
    is_selected: Flags
    signs: tuple[float, ...]
    bound: float = 1.0
    penalty: float = RATE_PENALTY

    @classmethod
    def of(cls, load: Load, samples: CurveSamples) -> "LoadLinearization":
        """Linearize the load of a motion."""
        vectors = load.load_ratios(*samples.motion)
        selected = np.flatnonzero((np.linalg.norm(vectors, axis=2) > _MIN_LOAD_RATIO).any(axis=1))
        vectors, samples = vectors[selected], samples.selected(selected)
        normals = _normals(vectors)
        rows = len(selected), normals.shape[1] * normals.shape[2]
        by_q, by_v, by_vdot = (
            np.einsum("mbrd,mbdj->mbrj", normals, part).reshape(*rows, part.shape[-1])
            for part in load.derivatives(*samples.motion)
        )
        return cls(
            samples.grid_indices,
            samples.control_points,
            samples.intervals,
            np.einsum("mbrd,mbd->mbr", normals, vectors).reshape(rows),
            samples.by_control_point(by_q, by_v, by_vdot),
            samples.by_path_velocity(by_v, by_vdot),
            # Rows that do not depend on u are equal on both sides of a grid point.
            by_vdot.any(axis=2) | (samples.fractions < 1)[:, None],
            _BOTH_SIGNS if vectors.shape[2] == 1 else _UPPER_SIGNS,
        )

    @classmethod
    def of_static_load(
        cls, load: Load, samples: CurveSamples, penalty: float
    ) -> "LoadLinearization":
        """Linearize the static load."""
        samples = samples.selected(np.flatnonzero(samples.fractions == 1))
        static_loads = load.static_load(samples.states[0])
        selected = np.flatnonzero((np.abs(static_loads) > _MIN_STATIC_LOAD_RATIO).any(axis=1))
        samples = samples.selected(selected)
        (by_q,) = difference_quotients(load.static_load, samples.states[0])
        zeros = np.zeros_like(by_q)
        return cls(
            samples.grid_indices,
            samples.control_points,
            samples.intervals,
            static_loads[selected],
            samples.by_control_point(by_q, zeros, zeros),
            samples.by_path_velocity(zeros, zeros),
            np.ones(by_q.shape[:2], dtype=bool),
            _BOTH_SIGNS,
            MAX_STATIC_LOAD,
            penalty,
        )

    def rows(self, points: Indices, path_velocity: Indices, radii: Array) -> PenaltyRows:
        """Return the rows that can bind within a step.

        Args:
            points: Columns of the control points' coordinates, shape (k, nq).
            path_velocity: Columns of b, shape (n + 1,).
            radii: Half of the box's sides around control points, shape (nq,).
        """
        m, num_ratios = self.ratios.shape
        by_control_point = (self.by_control_point * radii).reshape(m, num_ratios, 4 * len(radii))
        values = np.concatenate([by_control_point, self.by_path_velocity], axis=2)[self.is_selected]
        path_velocity_columns = np.stack(
            [path_velocity[self.intervals], path_velocity[self.intervals + 1]], axis=-1
        )
        control_point_columns = points[self.control_points].reshape(m, 4 * points.shape[1])
        columns = np.repeat(
            np.concatenate([control_point_columns, path_velocity_columns], axis=1),
            self.is_selected.sum(axis=1),
            axis=0,
        )
        ratios = self.ratios[self.is_selected]
        max_change = _MAX_CHANGE_FACTOR * np.abs(values).sum(axis=1) / self.bound
        # Both bounds of a row follow each other: rows of the same columns are one block.
        signs = np.array(self.signs)
        lower_bounds = signs * ratios[:, None] / self.bound - 1
        rows, chosen = np.nonzero(lower_bounds > -max_change[:, None])
        row_values = -signs[chosen, None] * values[rows] / self.bound
        return PenaltyRows(columns[rows], row_values, lower_bounds[rows, chosen], self.penalty)


def _normals(vectors: Float64[np.ndarray, "m balls dims"]) -> Float64[np.ndarray, "m balls k dims"]:
    """Return outward normals of planes tangent to the unit ball near the vectors' directions.

    The first is along the vector and linearizes its length; those around it keep a step from moving
    far along the first plane, where it would leave the ball.
    """
    if vectors.shape[2] == 1:
        return np.ones((*vectors.shape, 1))
    length = np.linalg.norm(vectors, axis=2, keepdims=True)
    direction = np.where(length > 0, vectors, np.eye(3)[0]) / np.where(length > 0, length, 1.0)
    smallest_axis = np.eye(3)[np.abs(direction).argmin(axis=2)]
    side = np.cross(direction, smallest_axis)
    side /= np.linalg.norm(side, axis=2, keepdims=True)
    second_side = np.cross(direction, side)
    tangents = np.stack([side, second_side, -side, -second_side], axis=2)
    tilted = [
        np.cos(angle) * direction[:, :, None] + np.sin(angle) * tangents for angle in _TILT_ANGLES
    ]
    return np.concatenate([direction[:, :, None], *tilted], axis=2)
