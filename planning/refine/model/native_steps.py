"""NativeSteps: convex steps of curves by the native kernel, one call each.

The same as `CurveModel.reference_step` in numpy, which is the reference, and what runs without the
kernel.
"""

from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.robot.joints import JointLimits
from planning.refine.constraints.rate_bounds import RateBounds
from planning.refine.curves.bspline_basis import BasisWeights
from planning.refine.curves.curve_evaluation import DISTANCE_PENALTY, CurveEvaluation
from planning.refine.curves.native_grid import kernel_bounds
from planning.refine.model.penalty_qp import MAX_STEPS, TOLERANCE
from planning.refine.model.variable_layout import VariableLayout

_NO_INTEGERS, _NO_NUMBERS = np.zeros(0, dtype=np.int64), np.zeros(0)
_NO_ROWS = np.zeros(1, dtype=np.int64), _NO_INTEGERS, _NO_NUMBERS, _NO_NUMBERS, _NO_NUMBERS


class NativeSteps:
    """Convex steps of curves of one layout."""

    def __init__(
        self,
        grid: Any,
        layout: VariableLayout,
        bounds: RateBounds,
        limits: JointLimits,
        model_weights: tuple[float, ...],
    ) -> None:
        """Prepare for a layout; `model_weights` are the kernel's ModelWeights, in order."""
        self._grid = grid
        self._bounds = kernel_bounds(bounds)
        self._limits = np.array(limits.lower), np.array(limits.upper)
        self._layout = (
            np.ascontiguousarray(layout.control_points, dtype=np.int64),
            np.ascontiguousarray(layout.path_velocity, dtype=np.int64),
            layout.num_variables,
        )
        self._model_weights = np.array(model_weights)

    def step(
        self,
        evaluation: CurveEvaluation,
        radii: Float64[np.ndarray, " nq"],
        distance_weights: BasisWeights,
    ) -> tuple[Array, float]:
        """Return the control points of the model's minimizer, and the predicted decrease [s].

        Args:
            evaluation: Evaluation of the curve around which the model is.
            radii: Half of the box's sides around every control point.
            distance_weights: Weights of the control points at the instants of distances.
        """
        distances = evaluation.distances
        margins = (
            np.ascontiguousarray(distance_weights.control_points[:, 0], dtype=np.int64),
            distance_weights.values,
            np.ascontiguousarray(distances.sample_indices, dtype=np.int64),
            distances.signed_margins,
            np.ascontiguousarray(distances.gradients),
            DISTANCE_PENALTY / evaluation.duration,
        )
        step: tuple[Array, float] = self._grid.step(
            self._bounds,
            np.ascontiguousarray(evaluation.points),
            evaluation.path_velocity,
            self._layout,
            self._model_weights,
            (radii, *self._limits),
            *self._load_rows(evaluation, radii),
            margins,
            TOLERANCE,
            MAX_STEPS,
        )
        return step

    def _load_rows(self, evaluation: CurveEvaluation, radii: Array) -> tuple[Any, ...]:
        """Return rows and balls of all loads: starts, columns, values, bounds, prices of each."""
        points, path_velocity, _ = self._layout
        parts = [
            rows
            for linearization in evaluation.load_linearizations
            if (rows := linearization.native_rows(points, path_velocity, radii)) is not None
        ]
        if not parts:
            return _NO_ROWS, _NO_ROWS
        return parts[0] if len(parts) == 1 else tuple(map(_joined, zip(*parts, strict=True)))


def _joined(parts: tuple[tuple[Array, ...], ...]) -> tuple[Any, ...]:
    """Return sparse rows one after another."""
    starts, *others = zip(*parts, strict=True)
    offsets = np.cumsum([0, *(part[-1] for part in starts)])
    begins = [part[:-1] + begin for part, begin in zip(starts, offsets, strict=False)]
    return np.concatenate([*begins, offsets[-1:]]), *map(np.concatenate, others)
