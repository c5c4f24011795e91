"""RegionSamples: exact target poses sampled from regions, in blocks, as IK trials consume them."""

from collections.abc import Iterator, Sequence

import numpy as np

from planning.goals.targets.ball_target import BallTarget
from planning.goals.targets.region_target import RegionTarget
from planning.goals.targets.target_samples import ExactPoses, TargetSamples
from planning.goals.targets.workspace_bound import WorkspaceBound

# Poses per block, over all regions.
_AT_ONCE = 640


class RegionSamples:
    """Sequence of exact target poses, one per trial, in the regions in turn; centers come first.

    Repeated iteration yields the same poses.
    """

    def __init__(
        self,
        regions: Sequence[RegionTarget | BallTarget],
        reach: WorkspaceBound,
        max_trials: int,
        rng: np.random.Generator,
    ) -> None:
        """Draw the first block, for at most `max_trials` trials overall.

        Later blocks use spawned generators, so other uses of `rng` do not depend on the number of
        blocks.
        """
        self._regions, self._reach, self._max_trials = regions, reach, max_trials
        self._rng = rng
        self._blocks = [self._drawn(0, rng)]

    def __iter__(self) -> Iterator[TargetSamples]:
        """Yield the target samples block by block, up to the last trial."""
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
        # The region's center, the first sample, is skipped in later blocks.
        drawn = [one.samples(count + again, self._reach, rng) for one in self._regions]
        positions, turns = (np.stack(part, axis=1)[again:] for part in zip(*drawn, strict=True))
        frame = self._regions[0].frame
        poses = ExactPoses(frame, positions.reshape(-1, 3), turns.reshape(-1, 4))
        return TargetSamples(
            poses, np.arange(len(poses)) % num_regions, 1, begin, begin + len(poses)
        )
