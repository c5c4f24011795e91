"""CurveModel: cost of a curve by its control points, and its local convex model (a QP).

The duration is that of the minimum-time squared path velocity b along the curve, which depends on
the control points P through bounds that are bilinear in (P, b). They are linearized in both,
distances in P, and the duration is expanded to second order in b. The model's minimizer within a
box around P is the next curve, whose own minimum-time path velocity gives its true cost. Distances
are penalized (exact penalty), not strict; the clearance objective has a variable at every instant:
the shortfall of the nearest pair there.
"""

from dataclasses import replace

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array, Indices
from planning.domain.robot.joints import JointLimits
from planning.refine.constraints.clearance_objective import ClearanceCost
from planning.refine.constraints.distance_query import DistanceQuery, DistanceRows
from planning.refine.constraints.rate_bounds import RateBounds
from planning.refine.curves.curve_evaluation import DISTANCE_PENALTY, CurveEvaluation
from planning.refine.curves.native_grid import native_grid
from planning.refine.curves.path_velocity import (
    NormalizedDerivatives,
    both_ends,
    duration_gradient,
    path_grid,
)
from planning.refine.model.curve_evaluator import CurveEvaluator
from planning.refine.model.distance_rows import distance_rows, reachable_distances
from planning.refine.model.native_steps import NativeSteps
from planning.refine.model.path_velocity_constraints import RATE_PENALTY
from planning.refine.model.penalty_qp import PenaltyQp
from planning.refine.model.penalty_rows import PenaltyRows
from planning.refine.model.variable_layout import make_variable_layout

# Proximal weight: cost of moving one control point by half of the box's side, in durations. Many
# sets of control points describe the same motion; the nearest one is chosen.
_PROXIMAL_WEIGHT = 1e-4
# Largest relative decrease and increase of b within one step.
_MAX_RELATIVE_DECREASE, _MAX_RELATIVE_INCREASE = 0.7, 1.5
# Rates below these shares of their bounds have no row.
_MIN_ACCELERATION_RATIO, _MIN_VELOCITY_RATIO = 0.3, 0.4
# Ratio of the penalty of a shortfall beyond the shortfall variable to the cost of that variable: it
# must exceed 1 for the variable to be used.
_PENALTY_RATIO = 2.0
# Least width of the box, even where the position limits leave none.
_MIN_BOX_WIDTH = 1e-6
# The same for the kernel, in its order.
_MODEL_WEIGHTS = (
    _PROXIMAL_WEIGHT,
    _MAX_RELATIVE_DECREASE,
    _MAX_RELATIVE_INCREASE,
    _MIN_ACCELERATION_RATIO,
    _MIN_VELOCITY_RATIO,
    RATE_PENALTY,
    _MIN_BOX_WIDTH,
)


class CurveModel:
    """Cost and convex model of curves of one number of control points, with distances kept."""

    def __init__(
        self,
        distance_query: DistanceQuery,
        limits: JointLimits,
        bounds: RateBounds,
        num_control_points: int,
        num_samples: int,
        clearance_objective: ClearanceCost | None = None,
    ) -> None:
        """Build the model, with distances at instants evenly in (0, 1)."""
        self._clearance_objective = clearance_objective
        self._limits = limits
        self._bounds = bounds
        self._grid = path_grid(num_control_points)
        num_shortfalls = 0 if clearance_objective is None else num_samples
        self._layout = make_variable_layout(
            num_control_points, len(bounds.velocity), num_shortfalls
        )
        self._evaluator = CurveEvaluator(
            distance_query, bounds, num_control_points, num_samples, clearance_objective
        )
        grid = native_grid(num_control_points)
        self._native_steps = (
            None
            if grid is None or clearance_objective is not None
            else NativeSteps(grid, self._layout, bounds, limits, _MODEL_WEIGHTS)
        )

    def add_samples(self, parameters: Float64[np.ndarray, " m"]) -> None:
        """Add instants at which distances are kept; `evaluate_again` adds them to evaluations."""
        self._evaluator.add_samples(parameters)

    def evaluate(self, points: Float64[np.ndarray, "k nq"]) -> CurveEvaluation:
        """Return the evaluation of a curve."""
        return self._evaluator.evaluate(points)

    def evaluate_again(self, evaluation: CurveEvaluation) -> CurveEvaluation:
        """Return an evaluation with the distances at those instants that were added after it."""
        return self._evaluator.evaluate_again(evaluation)

    def evaluate_trial(
        self, points: Float64[np.ndarray, "k nq"], current: CurveEvaluation, merit: float
    ) -> CurveEvaluation | None:
        """Return the evaluation of a step from a curve, or None if its merit is above `merit`."""
        return self._evaluator.evaluate_trial(points, current, merit)

    def step(self, evaluation: CurveEvaluation, radius: float) -> tuple[Array, float]:
        """Return the control points of the model's minimizer, and the predicted decrease [s].

        Args:
            evaluation: Evaluation of the curve around which the model is.
            radius: Half of the box's sides around every control point, as the time to cross it at
                the velocity limit.
        """
        radii = radius * self._bounds.velocity
        if self._native_steps is None:
            return self.reference_step(evaluation, radius)
        return self._native_steps.step(evaluation, radii, self._evaluator.distance_weights)

    def reference_step(self, evaluation: CurveEvaluation, radius: float) -> tuple[Array, float]:
        """Return the same by numpy, with the clearance objective if there is one."""
        radii = radius * self._bounds.velocity
        program = self._make_program(evaluation, radii)
        x = program.solve_by_active_rows()
        points = evaluation.points.copy()
        points[1:-1] += x[self._layout.control_points[1:-1]] * radii
        points[1:-1] = np.clip(points[1:-1], self._limits.lower, self._limits.upper)
        zero_step = np.zeros_like(x)
        if self._clearance_objective is not None and evaluation.clearances is not None:
            zero_step[self._layout.shortfalls] = self._clearance_objective.shortfalls(
                evaluation.clearances, len(self._layout.shortfalls)
            )
        predicted_decrease = program.cost(zero_step) - program.cost(x)
        return points, predicted_decrease * evaluation.duration

    def _make_program(self, evaluation: CurveEvaluation, radii: Array) -> PenaltyQp:
        """Return the QP, in units of the duration, of the box, and of b itself."""
        points, path_velocity = self._layout.control_points[1:-1], self._layout.path_velocity[1:-1]
        c = np.zeros(self._layout.num_variables)
        q = np.full(self._layout.num_variables, _PROXIMAL_WEIGHT)
        lower, upper = -np.ones_like(c), np.ones_like(c)
        gradient = (
            duration_gradient(self._grid, evaluation.path_velocity)[1:-1] / evaluation.duration
        )
        # First and second derivative of a duration proportional to b^(-1/2).
        c[path_velocity], q[path_velocity] = -gradient, 1.5 * gradient
        lower[path_velocity], upper[path_velocity] = -_MAX_RELATIVE_DECREASE, _MAX_RELATIVE_INCREASE
        lower[points] = np.maximum((self._limits.lower - evaluation.points[1:-1]) / radii, -1.0)
        upper[points] = np.minimum((self._limits.upper - evaluation.points[1:-1]) / radii, 1.0)
        lower = np.minimum(lower, 0.0)
        upper = np.maximum(upper, lower + _MIN_BOX_WIDTH)
        rows = self._rate_rows(evaluation, radii)
        distances = distance_rows(
            self._layout.control_points,
            evaluation.distances,
            self._evaluator.distance_weights,
            radii,
            DISTANCE_PENALTY / evaluation.duration,
        )
        if self._clearance_objective is not None and evaluation.clearances is not None:
            shortfalls = self._layout.shortfalls
            cost_per_sample = self._clearance_objective.weight / (
                len(shortfalls) * evaluation.duration
            )
            c[shortfalls] = cost_per_sample * self._clearance_objective.distance
            q[shortfalls] = lower[shortfalls] = 0.0
            rows.append(
                self._clearance_rows(
                    evaluation.clearances,
                    self._clearance_objective.distance,
                    radii,
                    _PENALTY_RATIO * cost_per_sample,
                )
            )
        layout, linearizations = self._layout, evaluation.load_linearizations
        columns = layout.control_points, layout.path_velocity, radii
        loads = tuple(part.rows(*columns) for part in linearizations if not part.are_vectors)
        balls = tuple(part.balls(*columns) for part in linearizations if part.are_vectors)
        return PenaltyQp(c, q, lower, upper, tuple(rows), distances, loads, balls)

    def _rate_rows(self, evaluation: CurveEvaluation, radii: Array) -> list[PenaltyRows]:
        derivatives = NormalizedDerivatives.of(self._grid, evaluation.points, self._bounds)
        rows = [
            self._acceleration_rows(evaluation, derivatives, radii),
            self._velocity_rows(evaluation, derivatives, radii),
        ]
        if self._bounds.jerk is not None:
            rows.append(self._jerk_rows(evaluation, derivatives, radii, self._bounds.jerk))
        return rows

    def _acceleration_rows(
        self, evaluation: CurveEvaluation, derivatives: NormalizedDerivatives, radii: Array
    ) -> PenaltyRows:
        """Return rows that bound r'' b + r' u in both signs, by interval, coordinate and end."""
        grid, b = self._grid, evaluation.path_velocity
        u = np.diff(b) / (2 * grid.step)
        weights = grid.second * both_ends(b)[..., None] + grid.first * u[:, None, None]
        by_control_point = weights[:, None] * (radii / self._bounds.acceleration)[:, None, None]
        at_low, at_high = derivatives.acceleration_gradients(grid)
        by_path_velocity = np.stack(
            [at_low * b[:-1, None, None], at_high * b[1:, None, None]], axis=-1
        )
        values = np.concatenate([by_control_point, by_path_velocity.transpose(0, 2, 1, 3)], axis=-1)
        current = derivatives.accelerations(grid, b).transpose(0, 2, 1)
        bounds = self._bounds.acceleration_range[:, None, :, None]
        rows = PenaltyRows.between(self._columns(2), values, current, bounds, RATE_PENALTY)
        return rows.selected(rows.lower_bounds > _MIN_ACCELERATION_RATIO - 1)

    def _velocity_rows(
        self, evaluation: CurveEvaluation, derivatives: NormalizedDerivatives, radii: Array
    ) -> PenaltyRows:
        """Return rows that bound |r'| sqrt(b) at the low end of every interval but the first."""
        root = np.sqrt(evaluation.path_velocity[1:-1])
        current = derivatives.first_by_velocity[1:, 0] * root[:, None]
        signs = np.sign(current)
        by_control_point = (self._grid.first[1:, 0] * root[:, None])[:, None, :] * (
            radii / self._bounds.velocity * signs
        )[..., None]
        values = np.concatenate([by_control_point, (np.abs(current) / 2)[..., None]], axis=-1)
        columns = self._columns(1)[1:, :, 0]
        is_selected = np.abs(current) > _MIN_VELOCITY_RATIO
        return PenaltyRows(
            columns[is_selected],
            -values[is_selected],
            np.abs(current)[is_selected] - 1,
            RATE_PENALTY,
        )

    def _jerk_rows(
        self,
        evaluation: CurveEvaluation,
        derivatives: NormalizedDerivatives,
        radii: Array,
        jerk: Array,
    ) -> PenaltyRows:
        """Return rows that bound |r'''| b^(3/2) at both ends of every interval."""
        b = both_ends(evaluation.path_velocity) ** 1.5
        current = derivatives.third_by_jerk[:, :, None] * b[:, None]
        signs = np.sign(current)
        by_control_point = (
            self._grid.third[:, None, None]
            * ((radii / jerk)[:, None] * b[:, None] * signs)[..., None]
        )
        by_path_velocity = (1.5 * np.abs(current))[..., None] * np.eye(2)
        values = np.concatenate([by_control_point, by_path_velocity], axis=-1)
        is_selected = np.abs(current) > _MIN_VELOCITY_RATIO
        return PenaltyRows(
            self._columns(2)[is_selected],
            -values[is_selected],
            np.abs(current)[is_selected] - 1,
            RATE_PENALTY,
        )

    def _columns(self, num_path_velocities: int) -> Indices:
        """Return columns of 4 control points and of b at one or both ends of every interval.

        Shape (n, nq, 2, 4 + num_path_velocities), the same for both ends.
        """
        points = self._layout.control_points[self._grid.control_points].transpose(0, 2, 1)
        path_velocity = both_ends(self._layout.path_velocity)[:, :num_path_velocities]
        path_velocity = np.broadcast_to(
            path_velocity[:, None], (*points.shape[:2], num_path_velocities)
        )
        columns = np.concatenate([points, path_velocity], axis=-1)
        return np.broadcast_to(columns[:, :, None], (*points.shape[:2], 2, 4 + num_path_velocities))

    def _clearance_rows(
        self, clearances: DistanceRows, distance: float, radii: Array, penalty: float
    ) -> PenaltyRows:
        """Return rows of target distances minus the shortfall variables, over the distance."""
        rows = distance_rows(
            self._layout.control_points,
            clearances,
            self._evaluator.clearance_weights,
            radii,
            penalty,
        ).expanded
        active = reachable_distances(clearances, radii)
        shortfalls = self._layout.shortfalls[clearances.sample_indices[active]]
        return replace(
            rows,
            columns=np.column_stack([rows.columns, shortfalls]),
            values=np.column_stack([rows.values, np.full(len(active), distance)]),
        )
