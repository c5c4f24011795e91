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
from planning.refine.model.penalty_rows import BallRows, PenaltyRows

# Instants at which all load ratios are below the first have no rows, and sums below the second have
# none, as rates have none.
MIN_LOAD_RATIO, MIN_ROW_RATIO = 0.5, 0.3
# The same for static loads, which change with the curve alone.
_MIN_STATIC_LOAD_RATIO = 0.75
# Largest change of a row's sum by a step, in units of its entries: b may grow by half.
_MAX_CHANGE_FACTOR = 1.5
_UPPER_SIGNS, _BOTH_SIGNS = (1.0,), (1.0, -1.0)


@dataclass(frozen=True)
class LoadLinearization:
    """Large ratios of one load at samples on every interval of the grid, with derivatives.

    Attributes:
        samples: The samples, m of them.
        vectors: Load ratios, vectors whose norms are bounded, shape (m, balls, dims).
        derivatives: Their derivatives by q, v and vdot, shape (3, m, balls, dims, nq).
        is_one_sided: Whether numbers have no bound below.
        is_static: Whether they depend on the curve alone; each grid point is sampled once then.
        bound: Bound of the norms.
        penalty: Penalty of exceeding the bound by its own size, in durations.
    """

    samples: CurveSamples
    vectors: Float64[np.ndarray, "m balls dims"]
    derivatives: Float64[np.ndarray, "3 m balls dims nq"]
    is_one_sided: bool = False
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
        selected = np.flatnonzero((squares > MIN_LOAD_RATIO**2).any(axis=1))
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
        """Return rows that can bind within a step and balls by the kernel, as it takes them.

        Starts, columns, values, bounds and penalties of each; None if there is no load. Arguments
        are those of `rows` and `balls`, which are the reference.
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
            self.is_one_sided,
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

    @property
    def are_vectors(self) -> bool:
        """Whether the loads are vectors, whose lengths are bounded, and not numbers."""
        return self.vectors.shape[2] > 1

    @cached_property
    def ratios(self) -> Array:
        """All components of the vectors, shape (m, rows)."""
        m, balls, dims = self.vectors.shape
        return self.vectors.reshape(m, balls * dims)

    @cached_property
    def by_control_point(self) -> Array:
        """Derivatives of the components by coordinates of control points, (m, rows, 4, nq)."""
        return self.samples.by_control_point(*self._row_derivatives)

    @cached_property
    def by_path_velocity(self) -> Array:
        """Derivatives by b at both ends of the interval, times b, shape (m, rows, 2)."""
        _, by_v, by_vdot = self._row_derivatives
        return self.samples.by_path_velocity(by_v, by_vdot)

    @cached_property
    def is_selected(self) -> Flags:
        """Mask of the balls to use, without duplicates, shape (m, balls)."""
        if self.is_static:
            return np.ones(self.vectors.shape[:2], dtype=bool)
        # Those that do not depend on u are equal on both sides of a grid point.
        by_vdot = self.derivatives[2]
        return by_vdot.any(axis=(2, 3)) | (self.samples.fractions < 1)[:, None]

    @cached_property
    def _row_derivatives(self) -> tuple[Array, ...]:
        """Derivatives of the components by q, v and vdot, each of shape (m, rows, nq)."""
        return tuple(part.reshape(*self.ratios.shape, part.shape[-1]) for part in self.derivatives)

    def balls(self, points: Indices, path_velocity: Indices, radii: Array) -> BallRows:
        """Return a ball for each vector; arguments are those of `rows`."""
        values, columns = self._entries(points, path_velocity, radii)
        chosen = self.is_selected
        centers = self.vectors[chosen] / self.bound
        return BallRows(columns[chosen], values[chosen] / self.bound, centers, self.penalty)

    def rows(self, points: Indices, path_velocity: Indices, radii: Array) -> PenaltyRows:
        """Return the rows of numbers that can bind within a step.

        Args:
            points: Columns of the control points' coordinates, shape (k, nq).
            path_velocity: Columns of b, shape (n + 1,).
            radii: Half of the box's sides around control points, shape (nq,).
        """
        all_values, all_columns = self._entries(points, path_velocity, radii)
        values, columns = all_values[self.is_selected][:, 0], all_columns[self.is_selected]
        ratios = self.ratios[self.is_selected]
        max_change = _MAX_CHANGE_FACTOR * np.abs(values).sum(axis=1) / self.bound
        # Both bounds of a row follow each other: rows of the same columns are one block.
        signs = np.array(_UPPER_SIGNS if self.is_one_sided else _BOTH_SIGNS)
        lower_bounds = signs * ratios[:, None] / self.bound - 1
        least = np.maximum(-max_change, MIN_ROW_RATIO - 1)
        rows, chosen = np.nonzero(lower_bounds > least[:, None])
        row_values = -signs[chosen, None] * values[rows] / self.bound
        return PenaltyRows(columns[rows], row_values, lower_bounds[rows, chosen], self.penalty)

    def _entries(
        self, points: Indices, path_velocity: Indices, radii: Array
    ) -> tuple[Array, Indices]:
        """Return derivatives, (m, balls, dims, entries), and columns, (m, balls, entries)."""
        m, balls, dims = self.vectors.shape
        of_points = points[self.samples.control_points].reshape(m, 4 * points.shape[1])
        intervals = self.samples.intervals
        of_velocities = path_velocity[np.stack([intervals, intervals + 1], axis=1)]
        columns = np.concatenate([of_points, of_velocities], axis=1)
        by_control_point = self.by_control_point * radii
        by_control_point = by_control_point.reshape(m, balls * dims, of_points.shape[1])
        values = np.concatenate([by_control_point, self.by_path_velocity], axis=2)
        return (
            values.reshape(m, balls, dims, columns.shape[1]),
            np.broadcast_to(columns[:, None], (m, balls, columns.shape[1])),
        )
