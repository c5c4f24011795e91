"""RegionSamples: exact poses in regions, drawn as trials are made."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from planning.goals.targets.ball_target import BallTarget
from planning.goals.targets.region_target import RegionTarget
from planning.goals.targets.target_samples import ExactPoses, TargetSamples
from planning.goals.targets.workspace_bound import WorkspaceBound

type Array = np.ndarray[Any, np.dtype[np.float64]]

# So many poses are drawn at once, over all regions.
_AT_ONCE = 640


class RegionSamples:
    """An exact pose in one of the regions for every trial, in turn; the middles come first.

    Whoever asks again is given the same ones.
    """

    def __init__(
        self,
        regions: Sequence[RegionTarget | BallTarget],
        reach: WorkspaceBound,
        max_trials: int,
        rng: np.random.Generator,
    ) -> None:
        """Draw the first ones, for so many trials at most.

        Later ones come from generators of their own: what else the one given is used for does not
        depend on how many are asked for.
        """
        self._regions, self._reach, self._max_trials = regions, reach, max_trials
        self._rng = rng
        self._blocks = [self._drawn(0, rng)]

    def __iter__(self) -> Iterator[TargetSamples]:
        """Yield aims for some trials, then for those after them, up to the last."""
        for i in range(self._max_trials):
            if i == len(self._blocks):
                begin = self._blocks[-1].end
                if begin is None or begin >= self._max_trials:
                    return
                self._blocks.append(self._drawn(begin, self._rng.spawn(1)[0]))
            yield self._blocks[i]

    def _drawn(self, begin: int, rng: np.random.Generator) -> TargetSamples:
        num_regions, again = len(self._regions), begin > 0
        count = -(-min(_AT_ONCE, self._max_trials - begin) // num_regions)
        # The middle, which is the first sample, is not for a second time.
        drawn = [one.samples(count + again, self._reach, rng) for one in self._regions]
        positions, turns = (np.stack(part, axis=1)[again:] for part in zip(*drawn, strict=True))
        frame = self._regions[0].frame
        poses = ExactPoses(frame, positions.reshape(-1, 3), turns.reshape(-1, 4))
        return TargetSamples(
            poses, np.arange(len(poses)) % num_regions, 1, begin, begin + len(poses)
        )
