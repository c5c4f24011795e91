"""Steps towards quicker drives, and drives of fewer letters.

Two kinds of moves take turns. A descent changes ways and bends: the model's best within a box,
which grows and shrinks by what a step truly brings. When it has come to rest, drives of one letter
less are tried, each from where it is nearest: without a letter, or with one for two that lead the
same way. A rest costs more than most letters are long, so this is where most is gained.
"""

import numpy as np

from planning.domain.request.deadline import Deadline
from planning.refine.cars.arc_segments import NOWHERE, ArcSegments, PathSamples
from planning.refine.cars.drive_evaluation import DriveEvaluation
from planning.refine.cars.drive_model import DriveModel

# Half of the box's sides, about, as what it moves places by [m].
_FIRST_BOX, _LEAST_BOX, _LARGEST_BOX = 0.05, 1e-4, 0.4
_SHRINK, _GROW = 0.4, 2.0
# Of what the model promised, what must be kept for a step to count, not to shrink, to grow.
_KEPT, _POOR, _GOOD = 0.1, 0.25, 0.7
# A promise of less than this share of the duration is not worth a step.
_WORTHWHILE = 3e-4
# Ways that are shorter are let go of, if that costs nothing [m].
_BRIEF = 1e-4
# Steps, not seconds, decide when to give up, so that the same request gives the same bytes.
_MOST_STEPS, _MOST_IN_ALL = 25, 160
# In so many steps, what a drive costs beyond its target must become this share of that.
_SOON, _COME_NEAR = 4, 0.5


class DriveTrustRegion:
    """Looks for quicker drives.

    Attributes:
        num_steps: How many steps were tried.
    """

    def __init__(self, model: DriveModel, share: Deadline) -> None:
        """Nothing is begun after `share`."""
        self._model = model
        self._share = share
        self.num_steps = 0

    @property
    def is_over(self) -> bool:
        """Whether enough was tried, or there is no time."""
        return self.num_steps >= _MOST_IN_ALL or self._share.is_over

    def settled(
        self, letters: ArcSegments, watched: PathSamples = NOWHERE, target: float = np.inf
    ) -> DriveEvaluation:
        """Return where a descent from a drive that ends at the goal comes to rest.

        Args:
            letters: The drive.
            watched: Where distances are demanded besides the usual spots.
            target: A cost of no interest; what does not come near it soon is given up.
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
        """Return the model's best drive in a box, and how much of its promise was kept.

        None where nothing is promised; the drive itself where none ends at the goal.
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
        """Return drives of one letter less that end at the goal, the most promising first.

        None when it is over.
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
        """Return the drive without letters that are too short to matter."""
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
    """Return how large the box is after so much of a promise was kept."""
    if kept < _POOR:
        return box * _SHRINK
    return min(box * _GROW, _LARGEST_BOX) if kept > _GOOD else box
