"""CurveEvaluator: the true merit of curves, and as little of it as decides about a step."""

from dataclasses import replace

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array, Indices
from planning.refine.constraints.clearance_objective import ClearanceCost
from planning.refine.constraints.distance_query import DistanceQuery, DistanceRows
from planning.refine.constraints.rate_bounds import RateBounds
from planning.refine.curves.bspline_basis import BasisWeights, position_weights
from planning.refine.curves.curve_evaluation import CurveEvaluation, distance_penalty
from planning.refine.curves.path_velocity import duration_of, path_grid
from planning.refine.model.load_evaluation import LoadEvaluation, path_velocity_along

# Signed margin above which pairs are ignored [m].
_INFLUENCE_DISTANCE = 0.1
# Share of the instants at which a step is looked at first.
_FIRST_SHARE = 1 / 6


class CurveEvaluator:
    """Evaluations of curves of one number of control points, with distances at instants.

    Attributes:
        parameters: Path parameters s of the instants, shape (m,).
        distance_weights: Weights of the control points at these.
        clearance_weights: The same at the instants of the clearance objective.
    """

    def __init__(
        self,
        distance_query: DistanceQuery,
        bounds: RateBounds,
        num_control_points: int,
        num_samples: int,
        clearance_objective: ClearanceCost | None,
    ) -> None:
        """Begin with instants evenly in (0, 1)."""
        self._distance_query = distance_query
        self._bounds = bounds
        self._num_control_points = num_control_points
        self._grid = path_grid(num_control_points)
        self._clearance_objective = clearance_objective
        self.parameters = np.linspace(0.0, 1.0, num_samples + 2)[1:-1]
        self.distance_weights: BasisWeights = position_weights(num_control_points, self.parameters)
        self.clearance_weights = self.distance_weights

    def add_samples(self, parameters: Float64[np.ndarray, " m"]) -> None:
        """Add instants at which distances are kept; `evaluate_again` adds them to evaluations."""
        self.parameters = np.concatenate([self.parameters, parameters])
        self.distance_weights = position_weights(self._num_control_points, self.parameters)

    def evaluate(self, points: Float64[np.ndarray, "k nq"]) -> CurveEvaluation:
        """Return the evaluation of a curve."""
        qs = self.distance_weights.apply(points)
        return self._with_distances(points, qs, *path_velocity_along(points, self._bounds))

    def evaluate_again(self, evaluation: CurveEvaluation) -> CurveEvaluation:
        """Return an evaluation with the distances at those instants that were added after it."""
        known, weights = evaluation.num_instants, self.distance_weights
        added = BasisWeights(weights.control_points[known:], weights.values[known:])
        distances = evaluation.distances
        more = self._distance_query.within(added.apply(evaluation.points), _INFLUENCE_DISTANCE)
        joined = DistanceRows(
            np.concatenate([distances.sample_indices, more.sample_indices + known]),
            np.concatenate([distances.signed_margins, more.signed_margins]),
            np.concatenate([distances.gradients, more.gradients]),
        )
        return replace(evaluation, distances=joined, num_instants=len(self.parameters))

    def evaluate_trial(
        self, points: Float64[np.ndarray, "k nq"], current: CurveEvaluation, merit: float
    ) -> CurveEvaluation | None:
        """Return the evaluation of a step from a curve, or None if its merit is above `merit`.

        No term of a merit is negative: once a part of the sum is above, the rest does not matter.

        Args:
            points: Control points after the step.
            current: Evaluation before the step, at the same instants.
            merit: The largest merit that is of interest [s].
        """
        path_velocity, loads = path_velocity_along(points, self._bounds)
        rest = merit - duration_of(self._grid, path_velocity)
        rest -= 0.0 if loads is None else loads.penalty
        if rest < 0:
            return None
        qs = self.distance_weights.apply(points)
        changes = qs - self.distance_weights.apply(current.points)
        first = _nearest_instants(current.distances, changes)
        if distance_penalty(self._distance_query.within(qs[first], 0.0)) > rest:
            return None
        return self._with_distances(points, qs, path_velocity, loads)

    def _with_distances(
        self, points: Array, qs: Array, path_velocity: Array, loads: LoadEvaluation | None
    ) -> CurveEvaluation:
        """Return the evaluation of a curve at instants with configurations qs."""
        duration = duration_of(self._grid, path_velocity)
        distances = self._distance_query.within(qs, _INFLUENCE_DISTANCE)
        clearances, objective = None, duration
        if self._clearance_objective is not None:
            at = self.clearance_weights.apply(points)
            clearances = self._clearance_objective.distance_query.within(at, _INFLUENCE_DISTANCE)
            objective += self._clearance_objective.cost(clearances, len(at))
        return CurveEvaluation(
            points, path_velocity, duration, distances, len(qs), clearances, objective, loads
        )


def _nearest_instants(distances: DistanceRows, changes: Float64[np.ndarray, "m nq"]) -> Indices:
    """Return the instants with the least signed margins after a step, to first order, in order."""
    samples = distances.sample_indices
    increases = np.einsum("mj,mj->m", distances.gradients, changes[samples])
    predicted = distances.signed_margins + increases
    least = np.full(len(changes), np.inf)
    np.minimum.at(least, samples, predicted)
    count = max(1, int(_FIRST_SHARE * len(changes)))
    return np.sort(np.argsort(least, kind="stable")[:count])
