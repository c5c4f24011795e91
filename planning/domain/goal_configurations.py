"""What the goals stage found: configurations, or the nearest pose that it could."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.funnel import Funnel
from planning.domain.line import GoalLegs
from planning.domain.pose import Pose
from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class NearestPose(Value):
    """The nearest pose that the tool frame can take, free and within limits, to what it cannot.

    Attributes:
        pose: X_WT, the tool frame in world.
        positions: The group's q there, shape (nq,).
        translation_error: From the nearest pose within the goal's tolerance [m].
        rotation_error: From the same [rad].
        pose_index: To which of the goal's poses it is the nearest.
        binding: What keeps it from being nearer: "limits", "collision", or "reach" if neither.
        joints: The coordinates at their limits, if limits bind.
        pairs: The pairs of bodies at their margins, if collisions bind.
    """

    pose: Pose
    positions: Float64[np.ndarray, " nq"]
    translation_error: float
    rotation_error: float
    pose_index: int
    binding: str
    joints: tuple[str, ...] = ()
    pairs: tuple[tuple[str, str], ...] = ()

    @property
    def evidence(self) -> dict[str, Any]:
        """All of it as JSON has it."""
        return {
            "position": self.pose.position.tolist(),
            "quaternion": self.pose.quaternion.tolist(),
            "positions": self.positions.tolist(),
            "translation_error": self.translation_error,
            "rotation_error": self.rotation_error,
            "pose_index": self.pose_index,
            "binding": self.binding,
            "joints": list(self.joints),
            "pairs": [list(pair) for pair in self.pairs],
        }


@dataclass(frozen=True, eq=False)
class GoalConfigurations(Value):
    """What the goals stage found.

    Attributes:
        positions: The group's q, nearest to the start first, shape (n, nq), n >= 1.
        target_indices: Which candidate of the goal each row reaches.
        funnel: How many samples survived what.
        legs: Approach and retreat of each row; none if the goal has neither.
    """

    positions: Float64[np.ndarray, "n nq"]
    target_indices: tuple[int, ...]
    funnel: Funnel
    legs: tuple[GoalLegs, ...] = ()

    @property
    def entries(self) -> Float64[np.ndarray, "n nq"]:
        """Where the free part of a motion to each row ends: at its approach, if it has one."""
        approaches = [leg.approach for leg in self.legs]
        if not approaches or approaches[0] is None:
            return self.positions
        return np.stack([leg.positions[0] for leg in approaches if leg is not None])
