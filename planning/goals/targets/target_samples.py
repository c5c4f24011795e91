"""TargetSamples: target poses of the IK solver and their assignment to trials and seeds."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int64

from planning.domain.arrays import Indices
from planning.domain.geometry.pose import Pose
from planning.goals.targets.tool_target import ToolTarget


@dataclass(frozen=True)
class ExactPoses:
    """Batch of target poses X_WG of a tool frame without tolerance, stored as arrays.

    Attributes:
        frame: Full name of the tool frame.
        positions: p_WG [m], shape (n, 3).
        quaternions: R_WG, unit quaternions, shape (n, 4).
    """

    frame: str
    positions: Float64[np.ndarray, "n 3"]
    quaternions: Float64[np.ndarray, "n 4"]

    def __len__(self) -> int:
        """Return the number of poses."""
        return len(self.positions)

    @property
    def tool_targets(self) -> list[ToolTarget]:
        """Tool targets without tolerance, one per pose."""
        exact = np.zeros(3)
        return [
            ToolTarget(self.frame, Pose(position, quaternion), exact, exact)
            for position, quaternion in zip(self.positions, self.quaternions, strict=True)
        ]


@dataclass(frozen=True)
class TargetSamples:
    """Targets of one tool frame for a range of trials; a trial is one seed with one target.

    Attributes:
        targets: Targets for the solver.
        pose_indices: Index of the goal's pose that each target belongs to, shape (num_targets,).
        targets_per_seed: Number of successive trials that use the same seed.
        first_trial: Number of the trial that uses the first target.
        end_trial: Number of the first trial without a target; None if targets repeat cyclically.
    """

    targets: list[ToolTarget] | ExactPoses
    pose_indices: Int64[np.ndarray, " num_targets"]
    targets_per_seed: int
    first_trial: int = 0
    end_trial: int | None = None

    def trials(self, first: int, count: int) -> tuple[Indices, Indices]:
        """Return the seed number and target index of each of `count` trials from number `first`."""
        numbers = np.arange(first, first + count)
        target_indices = (numbers - self.first_trial) % len(self.pose_indices)
        return numbers // self.targets_per_seed, target_indices

    def end_within(self, max_trials: int) -> int:
        """Return the trial number to end before: `end_trial`, but at most `max_trials`."""
        return max_trials if self.end_trial is None else min(self.end_trial, max_trials)


def all_seed_target_pairs(targets: list[ToolTarget]) -> TargetSamples:
    """Return target samples that combine every seed with every target."""
    return TargetSamples(targets, np.arange(len(targets)), len(targets))
