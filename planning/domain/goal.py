"""Goals: what a motion shall reach."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.line import MAX_SHIFT, MAX_TURN
from planning.domain.pose import Pose
from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class JointGoal(Value):
    """Reach any of some configurations.

    Attributes:
        positions: The group's q, one per row, shape (n, nq), n >= 1.
    """

    positions: Float64[np.ndarray, "n nq"]


@dataclass(frozen=True, eq=False)
class ConfigurationGoal(Value):
    """Reach a configuration that the scene or the robot names.

    Attributes:
        name: For example "home".
    """

    name: str


@dataclass(frozen=True, eq=False)
class PoseTarget(Value):
    """Where a tool frame shall be.

    Attributes:
        pose: X_FG, the target G in the reference frame F.
        frame: Name of F; "world" or any frame of the scene.
    """

    pose: Pose
    frame: str = "world"


@dataclass(frozen=True, eq=False)
class PoseGoal(Value):
    """Bring a tool frame to any of some poses.

    Attributes:
        targets: The candidates, at least one; the index of the chosen one is in the result.
        frame: Full name of the tool frame; "" for the group's default.
        position_tolerance: Half-widths of the box about the target, in its axes [m], shape (3,).
        rotation_tolerance: Largest rotation vector components, in the target's axes [rad], shape
            (3,); an entry of pi or more leaves that axis free.
        approach: The last part of the motion is a straight line without a turn, which begins where
            the tool is displaced by this, in the target's axes [m], shape (3,); None for none.
        retreat: After the goal the tool goes on in a straight line by this, in the target's axes
            [m], shape (3,); None for none.
    """

    targets: tuple[PoseTarget, ...]
    frame: str
    position_tolerance: Float64[np.ndarray, "3"]
    rotation_tolerance: Float64[np.ndarray, "3"]
    approach: Float64[np.ndarray, "3"] | None = None
    retreat: Float64[np.ndarray, "3"] | None = None


@dataclass(frozen=True, eq=False)
class LineGoal(Value):
    """Bring a tool frame to a pose in a straight line, or through several, at rest at each.

    Attributes:
        targets: At least one; a frame that moves counts where the start puts it.
        frame: Full name of the tool frame; "" for the group's default.
        max_shift: How far the tool may be from the lines [m].
        max_turn: How far its rotation may be off [rad].
    """

    targets: tuple[PoseTarget, ...]
    frame: str = ""
    max_shift: float = MAX_SHIFT
    max_turn: float = MAX_TURN


type Goal = JointGoal | ConfigurationGoal | PoseGoal | LineGoal
