"""MotionModel: cost of a spline motion, and its local convex model (a QP) in points and duration.

Rates, distances and loads are linearized, under exact penalties; the cost is a sum of squares of
linearized residuals, each a variable of its own. The duration is a variable by its logarithm.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array, Indices
from planning.refine.constraints.distance_query import DistanceRows
from planning.refine.curves.bspline_basis import basis_weights, greville_abscissae
from planning.refine.model.distance_rows import distance_rows
from planning.refine.model.penalty_qp import PenaltyQp
from planning.refine.model.penalty_rows import PenaltyRows
from planning.refine.motion.load_rows import LoadRows
from planning.refine.motion.motion_cost import LEAST_COST
from planning.refine.motion.motion_program import MotionTask
from planning.refine.motion.motion_residuals import NUM_NODES, Residuals, cost_residuals
from planning.refine.motion.spline_matrices import quadrature_nodes, rate_maps
from planning.refine.motion.spline_motion import SplineMotion

# Signed margin above which pairs are ignored [m].
_INFLUENCE_DISTANCE = 0.1
# Penalties, in costs of the first motion: of a metre less than the required distance, per instant
# and pair; of a rate or load by its bound, per control point or instant; of a residual's equation.
_DISTANCE_PENALTY, _BOUND_PENALTY, _RESIDUAL_PENALTY = 100.0, 30.0, 30.0
# Proximal weight of a step of one control point by half of the box's side.
_PROXIMAL_WEIGHT = 1e-6
# Range of a residual, in square roots of the first motion's cost.
_MAX_RESIDUAL = 10.0
# Relative reserve to bounds on rates and loads.
_RESERVE = 1e-5
# Least width of the box, even where position limits or the bound on the duration leave none.
_MIN_BOX_WIDTH = 1e-6


@dataclass(frozen=True)
class MotionEvaluation:
    """Cost and constraints of one motion.

    Attributes:
        motion: The motion.
        cost: Its cost, in costs of the first motion.
        merit: Cost and penalties.
        distances: Distances of near pairs at the instants.
    """

    motion: SplineMotion
    cost: float
    merit: float
    distances: DistanceRows

    @property
    def merit_scale(self) -> float:
        """Scale of the merit: the cost."""
        return self.cost


class MotionModel:
    """Cost and convex model of motions of one task, with distances kept at instants."""

    def __init__(
        self, task: MotionTask, first: SplineMotion, instants: Float64[np.ndarray, " m"]
    ) -> None:
        """Build the model; `first` is where its cost is 1."""
        self._task = task
        self._count = task.cost.num_control_points
        self._scale = 1 / max(task.cost.value(first.points, first.duration), LEAST_COST)
        self._weights = basis_weights(self._count, instants)
        self._loads = tuple(LoadRows.of(load, self._count) for load in task.bounds.loads)
        self._layout = _Layout.of(task, len(list(cost_residuals(task.cost, *_of(first)))))
        bounds = task.bounds
        self._sizes = {1: bounds.velocity, 2: bounds.acceleration}
        if bounds.jerk is not None:
            self._sizes[3] = bounds.jerk
        self._rate_maps = {order: rate_maps(self._count, order)[0] for order in self._sizes}

    def evaluate(self, motion: SplineMotion) -> MotionEvaluation:
        """Return the evaluation of a motion."""
        distances = self._task.problem.distance_query.within(
            self._weights.apply(motion.points), _INFLUENCE_DISTANCE
        )
        cost = self._scale * self._task.cost.value(motion.points, motion.duration)
        excess = -float(np.minimum(distances.signed_margins, 0.0).sum())
        violations = [
            np.maximum(ratios / ranges[:, None] - 1, 0.0).sum()
            for ratios, ranges in self._rates(motion).values()
        ]
        violations += [np.maximum(rows.values(*_of(motion)) - 1, 0.0).sum() for rows in self._loads]
        merit = cost + _DISTANCE_PENALTY * excess + _BOUND_PENALTY * float(sum(violations))
        return MotionEvaluation(motion, cost, merit, distances)

    def evaluate_trial(
        self, motion: SplineMotion, _current: MotionEvaluation, _merit: float
    ) -> MotionEvaluation:
        """Return the evaluation of a step, whatever its merit."""
        return self.evaluate(motion)

    def step(self, evaluation: MotionEvaluation, radius: float) -> tuple[SplineMotion, float]:
        """Return the model's minimizer, and the predicted decrease of the merit.

        Args:
            evaluation: Evaluation of the motion around which the model is.
            radius: Half of the box's sides: around every control point, as the time to cross it at
                the velocity limit [s], and around the logarithm of the duration.
        """
        motion = evaluation.motion
        residuals = list(cost_residuals(self._task.cost, *_of(motion)))
        radii = radius * self._task.bounds.velocity
        program = self._make_program(evaluation, residuals, radius)
        x, layout = program.solve(), self._layout
        zero_step = np.zeros_like(x)
        zero_step[layout.residuals] = self._residual_values(residuals)
        points = motion.points + np.append(x, 0.0)[layout.points] * radii
        longest = self._task.cost.objective.max_duration or np.inf
        duration = min(motion.duration * float(np.exp(radius * x[layout.time])), longest)
        predicted_decrease = program.cost(zero_step) - program.cost(x)
        return self.within_limits(SplineMotion(points, duration)), predicted_decrease

    def within_limits(self, motion: SplineMotion) -> SplineMotion:
        """Return a motion with its control points within the position limits, but for its ends."""
        limits, inner = self._task.problem.chart_limits, self._layout.points[:, 0] >= 0
        points = motion.points.copy()
        points[inner] = np.clip(points[inner], limits.lower, limits.upper)
        return SplineMotion(points, motion.duration)

    def _residual_values(self, residuals: list[Residuals]) -> Array:
        values = [part.values.ravel() for part in residuals]
        return np.sqrt(self._scale) * np.concatenate([np.zeros(0), *values])

    def _make_program(
        self, evaluation: MotionEvaluation, residuals: list[Residuals], radius: float
    ) -> PenaltyQp:
        motion, layout = evaluation.motion, self._layout
        radii = radius * self._task.bounds.velocity
        c, q = np.zeros(layout.num_variables), np.full(layout.num_variables, _PROXIMAL_WEIGHT)
        lower, upper = -np.ones_like(c), np.ones_like(c)
        objective, limits = self._task.cost.objective, self._task.problem.chart_limits
        c[layout.time] = self._scale * objective.time_weight * motion.duration * radius
        q[layout.time] += c[layout.time] * radius
        if objective.max_duration is not None:
            upper[layout.time] = np.log(objective.max_duration / motion.duration) / radius
        inner = layout.points[:, 0] >= 0
        columns = layout.points[inner]
        lower[columns] = np.maximum((limits.lower - motion.points[inner]) / radii, -1.0)
        upper[columns] = np.minimum((limits.upper - motion.points[inner]) / radii, 1.0)
        lower, upper = np.minimum(lower, 0.0), np.minimum(np.maximum(upper, _MIN_BOX_WIDTH), 1.0)
        upper = np.maximum(upper, lower + _MIN_BOX_WIDTH)
        q[layout.residuals] = 2.0
        lower[layout.residuals], upper[layout.residuals] = -_MAX_RESIDUAL, _MAX_RESIDUAL
        rows = [*self._residual_rows(residuals, radii, radius)]
        rows += [self._rate_rows(motion, order, radii, radius) for order in self._rate_maps]
        rows += [self._load_rows(load, motion, radii, radius) for load in self._loads]
        distances = distance_rows(
            layout.points, evaluation.distances, self._weights, radii, _DISTANCE_PENALTY
        )
        rows = tuple(part for part in rows if len(part.lower_bounds))
        return PenaltyQp(c, q, lower, upper, rows, distances)

    def _residual_rows(
        self, residuals: list[Residuals], radii: Array, radius: float
    ) -> list[PenaltyRows]:
        """Return rows that make a variable of every residual."""
        found: list[PenaltyRows] = []
        variables = iter(self._layout.residuals.reshape(max(len(residuals), 1), -1))
        root = np.sqrt(self._scale)
        for part, own in zip(residuals, variables, strict=False):
            columns, entries, values = part.rows(self._layout.points, self._layout.time, radii)
            entries[:, -1] *= radius
            columns = np.column_stack([columns, own])
            entries = root * np.column_stack([entries, np.full(len(own), -1 / root)])
            found += [
                PenaltyRows(columns, sign * entries, -sign * root * values, _RESIDUAL_PENALTY)
                for sign in (1.0, -1.0)
            ]
        return found

    def _rates(self, motion: SplineMotion) -> dict[int, tuple[Array, Array]]:
        """Return rates over the larger bound, shape (n, nq), and their range, by order."""
        symmetric = np.broadcast_to([[-1.0], [1.0]], self._task.bounds.acceleration_range.shape)
        found: dict[int, tuple[Array, Array]] = {}
        for order, matrix in self._rate_maps.items():
            ratios = matrix @ motion.points / (self._sizes[order] * motion.duration**order)
            ranges = self._task.bounds.acceleration_range if order == 2 else symmetric
            found[order] = ratios, (1 - _RESERVE) * ranges
        return found

    def _rate_rows(
        self, motion: SplineMotion, order: int, radii: Array, radius: float
    ) -> PenaltyRows:
        """Return rows that bound the control points of a derivative, those within reach.

        They are linear in the control points, |M P| <= bound T^k, and at most T^k (1 + k log T) is
        permitted where T is 1: a linearized M P / T^k would err by products of both steps.
        """
        matrix, size = self._rate_maps[order], self._sizes[order]
        current, ranges = self._rates(motion)[order]
        first = np.arange(len(matrix))[:, None] + np.arange(order + 1)
        weights = np.take_along_axis(matrix, first, axis=1)
        by_point = weights[:, None] * (radii / (size * motion.duration**order))[:, None]
        values = np.concatenate([by_point, np.zeros((*current.shape, 1))], axis=2)
        columns = self._layout.points[first].transpose(0, 2, 1)
        times = np.full((*columns.shape[:2], 1), self._layout.time)
        columns = np.concatenate([columns, times], axis=2)
        rows = PenaltyRows.between(columns, values, current, ranges[:, None], _BOUND_PENALTY)
        rows.values[:, -1] = order * radius
        return _within_reach(rows)

    def _load_rows(
        self, rows: LoadRows, motion: SplineMotion, radii: Array, radius: float
    ) -> PenaltyRows:
        """Return rows that bound a load at its instants."""
        values, gradients = rows(np.append(motion.points.ravel(), motion.duration))
        m, nq = len(rows.control_points), len(radii)
        by_point = gradients[:, :-1].reshape(m, -1, self._count, nq)
        by_point = np.take_along_axis(by_point, rows.control_points[:, None, :, None], axis=2)
        by_point = (by_point * radii).reshape(len(values), -1)
        by_time = gradients[:, -1:] * motion.duration * radius
        columns = self._layout.points[rows.control_points].reshape(m, -1)
        columns = np.repeat(columns, len(values) // m, axis=0)
        columns = np.column_stack([columns, np.full(len(values), self._layout.time)])
        entries = -np.concatenate([by_point, by_time], axis=1)
        return _within_reach(PenaltyRows(columns, entries, values - (1 - _RESERVE), _BOUND_PENALTY))


@dataclass(frozen=True)
class _Layout:
    """Columns of variables; those of near instants are near, which keeps the skyline narrow.

    Attributes:
        points: Columns of control points; -1 for those that are fixed, shape (k, nq).
        residuals: Columns of residuals, objective by objective and node by node.
        time: Column of the logarithm of the duration, the last one.
        num_variables: Number of variables.
    """

    points: Indices
    residuals: Indices
    time: int
    num_variables: int

    @classmethod
    def of(cls, task: MotionTask, num_objectives: int) -> "_Layout":
        count, nq = task.cost.num_control_points, task.problem.waypoints.shape[1]
        inner = slice(task.num_rest_points, count - task.num_rest_points)
        nodes = np.tile(np.repeat(quadrature_nodes(count, NUM_NODES), nq), num_objectives)
        instants = np.concatenate([np.repeat(greville_abscissae(count)[inner], nq), nodes])
        rank = np.empty(len(instants), dtype=np.intp)
        rank[np.argsort(instants, kind="stable")] = np.arange(len(instants))
        points = np.full((count, nq), -1)
        num_inner = points[inner].size
        points[inner] = rank[:num_inner].reshape(-1, nq)
        return cls(points, rank[num_inner:], len(instants), len(instants) + 1)


def _of(motion: SplineMotion) -> tuple[Array, float]:
    return motion.points, motion.duration


def _within_reach(rows: PenaltyRows) -> PenaltyRows:
    """Return the rows that a step within the box could violate."""
    return rows.selected(rows.lower_bounds + np.abs(rows.values).sum(axis=1) > 0)
