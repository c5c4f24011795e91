"""DriveModel: cost of a car path as a function of its segments, and its local convex model.

The duration is a sum over segments, for the car rests between them, and it is concave in each
length: its linearization never overestimates the gain, and short segments shrink to nothing.
Distances are linear in lengths and curvatures through the poses. Distances and the end at the goal
are penalized (exact penalty); a step of the model is then corrected so that it ends at the goal
(`end_constraint`).
"""

from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.robot.joints import JointLimits
from planning.refine.cars.arc_segments import NO_SAMPLES, ArcSegments, PathSamples, sample_poses
from planning.refine.cars.drive_evaluation import DriveEvaluation
from planning.refine.cars.drive_problem import DriveProblem
from planning.refine.cars.end_constraint import (
    projected_to_goal,
    trust_region_radii,
    variable_bounds,
)
from planning.refine.cars.segment_times import SegmentTimes
from planning.refine.constraints.clearance_objective import ClearanceCost
from planning.refine.constraints.distance_query import DistanceQuery, DistanceRows
from planning.refine.curves.curve_evaluation import DISTANCE_PENALTY
from planning.refine.model.penalty_qp import PenaltyQp
from planning.refine.model.penalty_rows import PenaltyRows

# Spacing of the samples at which distances are kept [m, and rad of another joint], and most samples
# per segment.
_SAMPLE_SPACING, _MAX_SAMPLES_PER_SEGMENT = 0.03, 64
# Signed margin above which pairs are ignored [m].
_INFLUENCE_DISTANCE = 0.1
# Proximal weight: cost of a change by half of the box's side [s], so that of equal paths the
# nearest is chosen.
_PROXIMAL_WEIGHT = 1e-4
# Penalty of a miss of the goal in the model [s/m].
_GOAL_PENALTY = 100.0
# Margin of x and y to their limits, for arcs may bulge between samples [m].
_POSITION_MARGIN = 1e-3
_DIFFERENCE_STEP = 1e-6
# Least width of the box, even where bounds leave none.
_MIN_BOX_WIDTH = 1e-9


class DriveModel:
    """Cost and convex model of the car paths of one problem."""

    def __init__(
        self,
        problem: DriveProblem,
        distance_query: DistanceQuery,
        limits: JointLimits,
        segment_times: SegmentTimes,
        clearance_objective: ClearanceCost | None = None,
    ) -> None:
        """Build the model; angle limits in `limits` are shifted to the turn of the start."""
        self.problem = problem
        self._distance_query = distance_query
        self._limits = limits
        self._segment_times = segment_times
        self._clearance_objective = clearance_objective
        position_indices = slice(problem.car_index, problem.car_index + 2)
        ends = np.stack([problem.start[:2], problem.goal[:2]])
        low, high = limits.lower[position_indices], limits.upper[position_indices]
        margins = np.stack([(ends - low).min(axis=0), (high - ends).min(axis=0)]) / 2
        low, high = np.stack([low, -high]) + np.clip(margins, 0.0, _POSITION_MARGIN)
        # x, y >= low and -x, -y >= high: `high` are the negated upper limits.
        self._position_bounds = np.concatenate([low, high])

    def evaluate(
        self, segments: ArcSegments, extra_samples: PathSamples = NO_SAMPLES
    ) -> DriveEvaluation:
        """Return the evaluation of a path that ends at the goal, also at `extra_samples`."""
        samples = extra_samples.followed_by(_default_samples(segments))
        segment_poses = sample_poses(self.problem.start, segments, samples)
        other_positions = segments.other_positions[samples.segments]
        other_positions = (
            other_positions
            + samples.fractions[:, None] * segments.other_displacements[samples.segments]
        )
        qs = self.problem.positions(segment_poses.poses, other_positions)[:-1]
        distances = self._distance_query.within(qs, _INFLUENCE_DISTANCE)
        duration = objective = self.duration(segments)
        clearances = None
        if self._clearance_objective is not None and len(qs):
            clearances = self._clearance_objective.distance_query.within(qs, _INFLUENCE_DISTANCE)
            objective += self._clearance_objective.cost(clearances, len(qs))
        limit_violation = float(np.maximum(-self._position_margins(segment_poses.poses), 0.0).sum())
        return DriveEvaluation(
            segments,
            samples,
            segment_poses,
            distances,
            clearances,
            duration,
            objective,
            limit_violation,
        )

    def duration(self, segments: ArcSegments) -> float:
        """Return the duration of a path [s]."""
        return float(
            self._segment_times.durations(
                segments.signed_lengths, segments.turning_angles, segments.other_displacements
            ).sum()
        )

    def projected_to_goal(self, segments: ArcSegments, radius: float) -> ArcSegments | None:
        """Return nearby segments that end at the goal, or None."""
        return projected_to_goal(self.problem, segments, radius)

    def step(self, evaluation: DriveEvaluation, radius: float) -> tuple[ArcSegments, float]:
        """Return the model's minimizer within a box, and the predicted decrease of the cost [s].

        Its segments need not end at the goal.

        Args:
            evaluation: Evaluation of the path around which the model is.
            radius: About half of the box's side, as the displacement of samples [m].
        """
        segments = evaluation.segments
        num_other_variables = len(evaluation.segments.other_positions[1:-1].ravel())
        radii = np.concatenate([
            trust_region_radii(self.problem, segments, radius),
            np.full(num_other_variables, 2 * radius),
        ])
        lower, upper = self._bounds(segments)
        variables = segments.variables
        low = np.clip((lower - variables) / radii, -1.0, 0.0)
        high = np.maximum(np.clip((upper - variables) / radii, 0.0, 1.0), low + _MIN_BOX_WIDTH)
        proximal_weights = np.full(len(variables), _PROXIMAL_WEIGHT)
        rows = [self._goal_rows(evaluation, radii), self._position_rows(evaluation, radii)]
        rows.append(self._distance_rows(evaluation, evaluation.distances, radii, DISTANCE_PENALTY))
        if self._clearance_objective is not None and evaluation.clearances is not None:
            penalty = self._clearance_objective.weight / (len(evaluation.samples.segments) - 1)
            rows.append(self._distance_rows(evaluation, evaluation.clearances, radii, penalty))
        gradient = self._duration_gradient(segments) * radii
        program = PenaltyQp(gradient, proximal_weights, low, high, tuple(rows))
        x = program.solve()
        predicted_decrease = program.cost(np.zeros_like(x)) - program.cost(x)
        return segments.with_variables(
            np.clip(variables + x * radii, lower, upper)
        ), predicted_decrease

    def _bounds(self, segments: ArcSegments) -> tuple[Array, Array]:
        lower, upper = variable_bounds(self.problem, segments)
        other_indices, count = self.problem.other_indices, len(segments) - 1
        return (
            np.concatenate([lower, np.tile(self._limits.lower[other_indices], count)]),
            np.concatenate([upper, np.tile(self._limits.upper[other_indices], count)]),
        )

    def _goal_rows(self, evaluation: DriveEvaluation, radii: Array) -> PenaltyRows:
        jacobian = np.zeros((3, len(radii)))
        jacobian[:, : evaluation.segment_poses.jacobians.shape[2]] = (
            evaluation.segment_poses.jacobians[-1]
        )
        return _dense_rows(
            np.concatenate([jacobian, -jacobian]) * radii, np.zeros(6), _GOAL_PENALTY
        )

    def _distance_rows(
        self, evaluation: DriveEvaluation, distances: DistanceRows, radii: Array, penalty: float
    ) -> PenaltyRows:
        """Return rows of distances that a step within the box could make too short."""
        problem = self.problem
        values = (
            evaluation.derivatives_by_variables(
                distances.sample_indices,
                distances.gradients,
                problem.car_index,
                problem.other_indices,
            )
            * radii
        )
        is_active = distances.signed_margins < np.abs(values).sum(axis=1)
        return _dense_rows(values[is_active], -distances.signed_margins[is_active], penalty)

    def _position_rows(self, evaluation: DriveEvaluation, radii: Array) -> PenaltyRows:
        """Return rows that keep x and y within their limits."""
        jacobians = evaluation.segment_poses.jacobians[:, :2]
        values = np.zeros((len(jacobians), 4, len(radii)))
        values[:, :, : jacobians.shape[2]] = np.concatenate([jacobians, -jacobians], axis=1)
        values *= radii
        signed_margins = self._position_margins(evaluation.segment_poses.poses)
        is_active = signed_margins < np.abs(values).sum(axis=2)
        return _dense_rows(values[is_active], -signed_margins[is_active], DISTANCE_PENALTY)

    def _position_margins(self, poses: Float64[np.ndarray, "m 3"]) -> Float64[np.ndarray, "m 4"]:
        """Return the signed margins of x and y to their limits [m]."""
        return np.concatenate([poses[:, :2], -poses[:, :2]], axis=1) - self._position_bounds

    def _duration_gradient(self, segments: ArcSegments) -> Array:
        """Return the gradient of the duration by all variables, by finite differences."""
        signed_lengths, curvatures, displacements = (
            segments.signed_lengths,
            segments.curvatures,
            segments.other_displacements,
        )
        k, h = displacements.shape[1], _DIFFERENCE_STEP
        length_steps = np.where(signed_lengths < 0, -h, h)
        all_lengths = np.concatenate([
            signed_lengths,
            signed_lengths + length_steps,
            *[signed_lengths] * (k + 1),
        ])
        all_curvatures = np.concatenate([curvatures, curvatures, curvatures + h, *[curvatures] * k])
        shifted = (displacements + h * np.eye(k)[:, None]).reshape(k * len(signed_lengths), k)
        all_displacements = np.concatenate([displacements, displacements, displacements, shifted])
        durations = self._segment_times.durations(
            all_lengths, all_lengths * all_curvatures, all_displacements
        )
        durations = durations.reshape(k + 3, len(signed_lengths))
        rates = (durations[1:] - durations[0]) / np.vstack([
            length_steps,
            np.full((k + 1, len(signed_lengths)), h),
        ])
        between = (rates[2:, :-1] - rates[2:, 1:]).T
        return np.concatenate([rates[0], rates[1], between.ravel()])


def _default_samples(segments: ArcSegments) -> PathSamples:
    """Return samples evenly along every segment, its end included."""
    segment_sizes = np.maximum(
        np.abs(segments.signed_lengths),
        np.abs(segments.other_displacements).max(axis=1, initial=0.0),
    )
    counts = np.clip(np.ceil(segment_sizes / _SAMPLE_SPACING), 1, _MAX_SAMPLES_PER_SEGMENT).astype(
        int
    )
    sample_segments = np.repeat(np.arange(len(segments)), counts)
    sample_numbers = (
        np.arange(len(sample_segments)) - np.repeat(np.cumsum(counts) - counts, counts) + 1
    )
    return PathSamples(sample_segments, sample_numbers / counts[sample_segments])


def _dense_rows(values: Array, lower_bounds: Array, penalty: float) -> PenaltyRows:
    columns: Any = np.broadcast_to(np.arange(values.shape[1]), values.shape)
    return PenaltyRows(columns, values, lower_bounds, penalty)
