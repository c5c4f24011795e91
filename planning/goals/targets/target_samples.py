"""TargetSamples: what the solver is sent to, trial by trial."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64, Int64

from planning.domain.geometry.pose import Pose
from planning.goals.targets.tool_target import ToolTarget

type Array = np.ndarray[Any, np.dtype[np.float64]]
type Indices = np.ndarray[Any, np.dtype[np.int64]]


@dataclass(frozen=True)
class ExactPoses:
    """Poses X_WG of a tool frame that shall be met exactly; there may be very many.

    Attributes:
        frame: Full name of the tool frame.
        positions: p_WG [m].
        quaternions: R_WG, unit quaternions.
    """

    frame: str
    positions: Float64[np.ndarray, "n 3"]
    quaternions: Float64[np.ndarray, "n 4"]

    def __len__(self) -> int:
        """How many there are."""
        return len(self.positions)

    @property
    def each(self) -> list[ToolTarget]:
        """The same as targets without tolerance."""
        exact = np.zeros(3)
        return [
            ToolTarget(self.frame, Pose(p, a), exact, exact)
            for p, a in zip(self.positions, self.quaternions, strict=True)
        ]


@dataclass(frozen=True)
class TargetSamples:
    """Some targets of one tool frame.

    Attributes:
        targets: What the solver is given.
        poses: Which of the goal's poses each target stands for, shape (num_targets,).
        targets_per_seed: How many trials a seed is used for, each with the next target.
        first: The trial that takes the first target.
        end: The first trial that there is no target for; None if they are taken over again.
    """

    targets: list[ToolTarget] | ExactPoses
    poses: Int64[np.ndarray, " num_targets"]
    targets_per_seed: int
    first: int = 0
    end: int | None = None

    def trials(self, first: int, count: int) -> tuple[Indices, Indices]:
        """Return which seed and which target each of some trials takes."""
        numbers = np.arange(first, first + count)
        return numbers // self.targets_per_seed, (numbers - self.first) % len(self.poses)

    def end_within(self, max_trials: int) -> int:
        """Return the trial to end before, which is `max_trials` at most."""
        return max_trials if self.end is None else min(self.end, max_trials)


def every_seed(targets: list[ToolTarget]) -> TargetSamples:
    """Return aims that send every seed to every target."""
    return TargetSamples(targets, np.arange(len(targets)), len(targets))
