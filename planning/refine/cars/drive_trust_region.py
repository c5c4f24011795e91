"""DriveTrustRegion: trust-region descent of car paths, and removal of segments.

Two kinds of moves alternate. A descent changes lengths and curvatures: the model's minimizer within
a box, which grows and shrinks by the ratio of achieved to predicted decrease. After its
convergence, paths of one segment less are tried: without one segment, or with two in the same
direction merged. A stop between segments costs more time than most segments, so this is where most
is gained.
"""

import numpy as np

from planning.domain.request.deadline import Deadline
from planning.refine.cars.arc_segments import NO_SAMPLES, ArcSegments, PathSamples
from planning.refine.cars.drive_evaluation import DriveEvaluation
from planning.refine.cars.drive_model import DriveModel

# Half of the box's side, approximately, as the displacement of samples [m]: first, least, largest.
_INITIAL_RADIUS, _MIN_RADIUS, _MAX_RADIUS = 0.05, 1e-4, 0.4
_SHRINK_FACTOR, _GROW_FACTOR = 0.4, 2.0
# Shares of the predicted decrease that must be achieved: to accept a step, not to shrink the box,
# to grow it.
_ACCEPT_RATIO, _SHRINK_RATIO, _GROW_RATIO = 0.1, 0.25, 0.7
# Least predicted decrease for a step, as a share of the duration.
_MIN_PREDICTED_DECREASE = 3e-4
# Length below which segments are removed if that costs nothing [m].
_MAX_REMOVED_LENGTH = 1e-4
# Steps, not seconds, decide when to give up, so that the same request gives the same bytes.
_MAX_STEPS, _MAX_TOTAL_STEPS = 25, 160
# Number of steps within which the cost above the target must fall to this share.
_PROGRESS_STEPS, _PROGRESS_RATIO = 4, 0.5


class DriveTrustRegion:
    """Trust-region iteration for car paths.

    Attributes:
        num_steps: Number of steps tried.
    """

    def __init__(self, model: DriveModel, deadline: Deadline) -> None:
        """Prepare; no step begins after `deadline`."""
        self._model = model
        self._deadline = deadline
        self.num_steps = 0

    @property
    def is_over(self) -> bool:
        """Whether the number of steps or the time is used up."""
        return self.num_steps >= _MAX_TOTAL_STEPS or self._deadline.is_over

    def optimize(
        self, segments: ArcSegments, extra_samples: PathSamples = NO_SAMPLES, target: float = np.inf
    ) -> DriveEvaluation:
        """Return the result of a descent from a path that ends at the goal.

        Args:
            segments: Segments of the path.
            extra_samples: Additional samples at which distances are kept.
            target: Cost to beat; a descent that does not approach it soon is abandoned.
        """
        current, radius = self._model.evaluate(segments, extra_samples), _INITIAL_RADIUS
        last_merit = current.merit
        for k in range(1, _MAX_STEPS + 1):
            if self.is_over or radius < _MIN_RADIUS:
                break
            trial, ratio = self._step(current, radius, extra_samples)
            if trial is None:
                break
            radius = _next_radius(radius, ratio)
            current = trial if ratio > _ACCEPT_RATIO else current
            if k % _PROGRESS_STEPS == 0:
                if current.merit - target > max(_PROGRESS_RATIO * (last_merit - target), 0.0):
                    break
                last_merit = current.merit
        return self._without_short_segments(current)

    def _step(
        self, current: DriveEvaluation, radius: float, extra_samples: PathSamples
    ) -> tuple[DriveEvaluation | None, float]:
        """Return the model's best path in a box, and the achieved share of its predicted decrease.

        None if no decrease is predicted; the given path if the step cannot be made to end at the
        goal.
        """
        proposed, predicted_decrease = self._model.step(current, radius)
        if predicted_decrease < _MIN_PREDICTED_DECREASE * current.duration:
            return None, 0.0
        self.num_steps += 1
        projected = self._model.projected_to_goal(proposed, radius)
        if projected is None:
            return current, 0.0
        trial = self._model.evaluate(projected, extra_samples)
        return trial, (current.merit - trial.merit) / predicted_decrease

    def reductions(self, current: DriveEvaluation) -> list[ArcSegments]:
        """Return paths of one segment less that end at the goal, those of least cost first.

        None of them if the steps or the time are used up.
        """
        segments = current.segments
        num_segments = len(segments)
        candidates = [segments.without(i) for i in range(num_segments) if num_segments > 1]
        same_direction = np.flatnonzero(
            segments.signed_lengths[:-1] * segments.signed_lengths[1:] > 0
        )
        candidates += [segments.merged(int(i)) for i in same_direction]
        evaluations: list[DriveEvaluation] = []
        for candidate in candidates:
            projected = (
                None if self.is_over else self._model.projected_to_goal(candidate, _INITIAL_RADIUS)
            )
            if projected is not None:
                evaluations.append(self._model.evaluate(projected))
        if self.is_over:
            return []
        evaluations.sort(key=lambda evaluation: evaluation.merit)
        return [evaluation.segments for evaluation in evaluations]

    def _without_short_segments(self, current: DriveEvaluation) -> DriveEvaluation:
        """Return the path without segments that are too short to matter."""
        while len(current.segments) > 1:
            segments = current.segments
            sizes = np.maximum(
                np.abs(segments.signed_lengths),
                np.abs(segments.other_displacements).max(axis=1, initial=0.0),
            )
            shortest = int(np.argmin(sizes))
            if sizes[shortest] > _MAX_REMOVED_LENGTH:
                break
            projected = self._model.projected_to_goal(segments.without(shortest), _INITIAL_RADIUS)
            shortened = None if projected is None else self._model.evaluate(projected)
            if shortened is None or shortened.merit > current.merit:
                break
            current = shortened
        return current


def _next_radius(radius: float, ratio: float) -> float:
    """Return the box's size after a step with this share of its predicted decrease."""
    if ratio < _SHRINK_RATIO:
        return radius * _SHRINK_FACTOR
    return min(radius * _GROW_FACTOR, _MAX_RADIUS) if ratio > _GROW_RATIO else radius
