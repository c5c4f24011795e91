"""RegionSamples: exact target poses sampled from regions, in blocks, as IK trials consume them."""

from collections.abc import Iterator, Sequence

import numpy as np

from planning.goals.targets.ball_target import BallTarget
from planning.goals.targets.region_target import RegionTarget
from planning.goals.targets.target_samples import ExactPoses, TargetSamples
from planning.goals.targets.workspace_bound import WorkspaceBound

# Poses per block, over all regions.
_BLOCK_SIZE = 640


class RegionSamples:
    """Sequence of exact target poses, one per trial, in the regions in turn; centers come first.

    Repeated iteration yields the same poses.
    """

    def __init__(
        self,
        regions: Sequence[RegionTarget | BallTarget],
        workspace: WorkspaceBound,
        max_trials: int,
        rng: np.random.Generator,
    ) -> None:
        """Draw the first block, for at most `max_trials` trials overall.

        Later blocks use spawned generators, so other uses of `rng` do not depend on the number of
        blocks.
        """
        self._regions, self._workspace, self._max_trials = regions, workspace, max_trials
        self._rng = rng
        self._blocks = [self._draw_block(0, rng)]

    def __iter__(self) -> Iterator[TargetSamples]:
        """Yield the target samples block by block, up to the last trial."""
        for i in range(self._max_trials):
            if i == len(self._blocks):
                begin = self._blocks[-1].end_trial
                if begin is None or begin >= self._max_trials:
                    return
                self._blocks.append(self._draw_block(begin, self._rng.spawn(1)[0]))
            yield self._blocks[i]

    def _draw_block(self, begin: int, rng: np.random.Generator) -> TargetSamples:
        num_regions, is_later_block = len(self._regions), begin > 0
        count = -(-min(_BLOCK_SIZE, self._max_trials - begin) // num_regions)
        # The region's center, the first sample, is skipped in later blocks.
        samples = [
            one.sample_poses(count + is_later_block, self._workspace, rng) for one in self._regions
        ]
        positions, turns = (
            np.stack(part, axis=1)[is_later_block:] for part in zip(*samples, strict=True)
        )
        frame = self._regions[0].frame
        poses = ExactPoses(frame, positions.reshape(-1, 3), turns.reshape(-1, 4))
        return TargetSamples(
            poses, np.arange(len(poses)) % num_regions, 1, begin, begin + len(poses)
        )
