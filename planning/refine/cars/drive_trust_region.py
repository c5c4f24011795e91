"""DriveTrustRegion: trust-region descent of car paths, and removal of segments.

Two kinds of moves alternate. A descent changes lengths and curvatures: the model's minimiser within
a box, which grows and shrinks by the ratio of achieved to predicted decrease. After its
convergence, paths of one segment less are tried: without one segment, or with two in the same
direction merged. A stop between segments costs more time than most segments, so this is where most
is gained.
"""

import numpy as np

from planning.domain.request.deadline import Deadline
from planning.refine.cars.arc_segments import NOWHERE, ArcSegments, PathSamples
from planning.refine.cars.drive_evaluation import DriveEvaluation
from planning.refine.cars.drive_model import DriveModel

# Half of the box's side, approximately, as the displacement of samples [m]: first, least, largest.
_FIRST_BOX, _LEAST_BOX, _LARGEST_BOX = 0.05, 1e-4, 0.4
_SHRINK, _GROW = 0.4, 2.0
# Shares of the predicted decrease that must be achieved: to accept a step, not to shrink the box,
# to grow it.
_KEPT, _POOR, _GOOD = 0.1, 0.25, 0.7
# Least predicted decrease for a step, as a share of the duration.
_WORTHWHILE = 3e-4
# Length below which segments are removed if that costs nothing [m].
_BRIEF = 1e-4
# Steps, not seconds, decide when to give up, so that the same request gives the same bytes.
_MOST_STEPS, _MOST_IN_ALL = 25, 160
# Number of steps within which the cost above the target must fall to this share.
_SOON, _COME_NEAR = 4, 0.5


class DriveTrustRegion:
    """Trust-region iteration for car paths.

    Attributes:
        num_steps: Number of steps tried.
    """

    def __init__(self, model: DriveModel, share: Deadline) -> None:
        """Prepare; no step begins after `share`."""
        self._model = model
        self._share = share
        self.num_steps = 0

    @property
    def is_over(self) -> bool:
        """Whether the number of steps or the time is used up."""
        return self.num_steps >= _MOST_IN_ALL or self._share.is_over

    def settled(
        self, letters: ArcSegments, watched: PathSamples = NOWHERE, target: float = np.inf
    ) -> DriveEvaluation:
        """Return the result of a descent from a path that ends at the goal.

        Args:
            letters: Segments of the path.
            watched: Additional samples at which distances are kept.
            target: Cost to beat; a descent that does not approach it soon is abandoned.
        """
        seen, box = self._model.look(letters, watched), _FIRST_BOX
        begun = seen.cost
        for k in range(1, _MOST_STEPS + 1):
            if self.is_over or box < _LEAST_BOX:
                break
            tried, kept = self._step(seen, box, watched)
            if tried is None:
                break
            box = _box_after(box, kept)
            seen = tried if kept > _KEPT else seen
            if k % _SOON == 0:
                if seen.cost - target > max(_COME_NEAR * (begun - target), 0.0):
                    break
                begun = seen.cost
        return self._without_brief(seen)

    def _step(
        self, seen: DriveEvaluation, box: float, watched: PathSamples
    ) -> tuple[DriveEvaluation | None, float]:
        """Return the model's best path in a box, and the achieved share of its predicted decrease.

        None if no decrease is predicted; the given path if the step cannot be made to end at the
        goal.
        """
        stepped, promised = self._model.step(seen, box)
        if promised < _WORTHWHILE * seen.duration:
            return None, 0.0
        self.num_steps += 1
        ended = self._model.ended(stepped, box)
        if ended is None:
            return seen, 0.0
        tried = self._model.look(ended, watched)
        return tried, (seen.cost - tried.cost) / promised

    def fewer(self, seen: DriveEvaluation) -> list[ArcSegments]:
        """Return paths of one segment less that end at the goal, those of least cost first.

        None of them if the steps or the time are used up.
        """
        letters = seen.letters
        count = len(letters)
        tried = [letters.without(i) for i in range(count) if count > 1]
        alike = np.flatnonzero(letters.ways[:-1] * letters.ways[1:] > 0)
        tried += [letters.with_one_of(int(i)) for i in alike]
        looks: list[DriveEvaluation] = []
        for some in tried:
            ended = None if self.is_over else self._model.ended(some, _FIRST_BOX)
            if ended is not None:
                looks.append(self._model.look(ended))
        if self.is_over:
            return []
        return [look.letters for look in sorted(looks, key=lambda look: look.cost)]

    def _without_brief(self, seen: DriveEvaluation) -> DriveEvaluation:
        """Return the path without segments that are too short to matter."""
        while len(seen.letters) > 1:
            letters = seen.letters
            sizes = np.maximum(np.abs(letters.ways), np.abs(letters.moves).max(axis=1, initial=0.0))
            shortest = int(np.argmin(sizes))
            if sizes[shortest] > _BRIEF:
                break
            ended = self._model.ended(letters.without(shortest), _FIRST_BOX)
            looked = None if ended is None else self._model.look(ended)
            if looked is None or looked.cost > seen.cost:
                break
            seen = looked
        return seen


def _box_after(box: float, kept: float) -> float:
    """Return the box's size after a step with this share of its predicted decrease."""
    if kept < _POOR:
        return box * _SHRINK
    return min(box * _GROW, _LARGEST_BOX) if kept > _GOOD else box
