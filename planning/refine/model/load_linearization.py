"""LoadLinearization: a load along one curve at one path velocity, linearized in both."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array, Flags, Indices
from planning.kernel.native import native
from planning.refine.constraints.load import MAX_STATIC_LOAD, Load, difference_quotients
from planning.refine.constraints.path_load import PathLoad
from planning.refine.curves.curve_samples import CurveSamples
from planning.refine.model.path_velocity_constraints import RATE_PENALTY
from planning.refine.model.penalty_qp import PenaltyRows

# Instants at which all load ratios are below the first have no rows, and sums below the second have
# none, as rates have none.
_MIN_LOAD_RATIO, _MIN_ROW_RATIO = 0.5, 0.3
# The same for static loads, which change with the curve alone.
_MIN_STATIC_LOAD_RATIO = 0.75
# Largest change of a row's sum by a step, in units of its entries: b may grow by half.
_MAX_CHANGE_FACTOR = 1.5
# Angle between the normals of tangent planes and the vector itself [rad].
_TILT_ANGLE = 0.4
# A tangent plane bounds a ball on one side; a scalar is bounded on both.
_UPPER_SIGNS, _BOTH_SIGNS = (1.0,), (1.0, -1.0)


@dataclass(frozen=True)
class LoadLinearization:
    """Large ratios of one load at samples on every interval of the grid, with derivatives.

    Attributes:
        samples: The samples, m of them.
        vectors: Load ratios, vectors whose norms are bounded, shape (m, balls, dims).
        derivatives: Their derivatives by q, v and vdot, shape (3, m, balls, dims, nq).
        is_static: Whether they depend on the curve alone; each grid point is sampled once then.
        bound: Bound of the norms.
        penalty: Penalty of exceeding the bound by its own size, in durations.
    """

    samples: CurveSamples
    vectors: Float64[np.ndarray, "m balls dims"]
    derivatives: Float64[np.ndarray, "3 m balls dims nq"]
    is_static: bool = False
    bound: float = 1.0
    penalty: float = RATE_PENALTY

    @classmethod
    def of(cls, load: Load, along: PathLoad, samples: CurveSamples) -> "LoadLinearization":
        """Linearize the load of a motion along a curve."""
        if not along.depends_on_u:
            # Equal on both sides of a grid point.
            samples = samples.selected(np.flatnonzero(samples.fractions < 1))
        vectors = along.ratios(samples.grid_indices, samples.b, samples.u)
        squares = np.einsum("mbd,mbd->mb", vectors, vectors)
        selected = np.flatnonzero((squares > _MIN_LOAD_RATIO**2).any(axis=1))
        samples = samples.selected(selected)
        return cls(samples, vectors[selected], load.derivatives(*samples.motion))

    @classmethod
    def of_static_load(
        cls, load: Load, along: PathLoad, samples: CurveSamples, penalty: float
    ) -> "LoadLinearization | None":
        """Linearize the static load; None where it is small everywhere."""
        static_loads = along.static_load[samples.grid_indices]
        is_large = (np.abs(static_loads) > _MIN_STATIC_LOAD_RATIO).any(axis=1)
        selected = np.flatnonzero(is_large & (samples.fractions == 1))
        if not len(selected):
            return None
        samples = samples.selected(selected)
        (by_q,) = difference_quotients(load.static_load, samples.states[0])
        derivatives = np.stack([by_q, np.zeros_like(by_q), np.zeros_like(by_q)])[:, :, :, None]
        vectors = static_loads[selected][:, :, None]
        return cls(
            samples, vectors, derivatives, is_static=True, bound=MAX_STATIC_LOAD, penalty=penalty
        )

    def native_rows(
        self, points: Indices, path_velocity: Indices, radii: Array
    ) -> tuple[Array, ...] | None:
        """Return the rows that can bind within a step by the kernel, as it takes them.

        Starts, columns, values, least sums and penalties; None if there are no rows. Arguments are
        those of `rows`, which is the reference.
        """
        if not self.vectors.size:
            return None
        module: Any = native()
        return module.load_rows(
            self._native_samples,
            np.ascontiguousarray(self.vectors),
            np.ascontiguousarray(self.derivatives),
            (points, path_velocity),
            radii,
            self.bound,
            self.penalty,
            self.is_static,
        )

    @cached_property
    def _native_samples(self) -> tuple[Any, ...]:
        """The samples as the kernel takes them."""
        samples = self.samples
        return (
            np.ascontiguousarray(samples.control_points[:, 0], dtype=np.int64),
            np.ascontiguousarray(samples.intervals, dtype=np.int64),
            samples.fractions,
            samples.interval_ends,
            np.ascontiguousarray(samples.states[1:]),
            samples.weights,
            samples.step,
        )

    @cached_property
    def ratios(self) -> Array:
        """Sums to bound: components of the vectors along normals, shape (m, rows)."""
        products = np.einsum("mbrd,mbd->mbr", self._normals, self.vectors)
        return products.reshape(len(products), products.shape[1] * products.shape[2])

    @cached_property
    def by_control_point(self) -> Array:
        """Derivatives of the sums by coordinates of control points, shape (m, rows, 4, nq)."""
        return self.samples.by_control_point(*self._row_derivatives)

    @cached_property
    def by_path_velocity(self) -> Array:
        """Derivatives by b at both ends of the interval, times b, shape (m, rows, 2)."""
        _, by_v, by_vdot = self._row_derivatives
        return self.samples.by_path_velocity(by_v, by_vdot)

    @cached_property
    def is_selected(self) -> Flags:
        """Mask of the rows to use, without duplicates, shape (m, rows)."""
        if self.is_static:
            return np.ones_like(self.ratios, dtype=bool)
        # Rows that do not depend on u are equal on both sides of a grid point.
        by_vdot = self._row_derivatives[2]
        return by_vdot.any(axis=2) | (self.samples.fractions < 1)[:, None]

    @cached_property
    def _normals(self) -> Array:
        return _normals(self.vectors)

    @cached_property
    def _row_derivatives(self) -> tuple[Array, ...]:
        """Derivatives of the sums by q, v and vdot, each of shape (m, rows, nq)."""
        return tuple(
            np.einsum("mbrd,mbdj->mbrj", self._normals, part).reshape(
                *self.ratios.shape, part.shape[-1]
            )
            for part in self.derivatives
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
            [path_velocity[self.samples.intervals], path_velocity[self.samples.intervals + 1]],
            axis=-1,
        )
        control_point_columns = points[self.samples.control_points].reshape(m, 4 * points.shape[1])
        columns = np.repeat(
            np.concatenate([control_point_columns, path_velocity_columns], axis=1),
            self.is_selected.sum(axis=1),
            axis=0,
        )
        ratios = self.ratios[self.is_selected]
        max_change = _MAX_CHANGE_FACTOR * np.abs(values).sum(axis=1) / self.bound
        # Both bounds of a row follow each other: rows of the same columns are one block.
        signs = np.array(_BOTH_SIGNS if self.vectors.shape[2] == 1 else _UPPER_SIGNS)
        lower_bounds = signs * ratios[:, None] / self.bound - 1
        least = np.maximum(-max_change, _MIN_ROW_RATIO - 1)
        rows, chosen = np.nonzero(lower_bounds > least[:, None])
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
    tilted = np.cos(_TILT_ANGLE) * direction[:, :, None] + np.sin(_TILT_ANGLE) * tangents
    return np.concatenate([direction[:, :, None], tilted], axis=2)
