"""Goals: what a motion shall reach."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.geometry.pose import Pose
from planning.domain.goals.linear_moves import MAX_SHIFT, MAX_TURN, Displacement
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
class PoseBall(Value):
    """All poses within a weighted distance of one, in place of a box and a rotation.

    The distance is sqrt((w_x x)^2 + (w_y y)^2 + (w_z z)^2 + (w_r theta)^2), with x, y, z the way
    from the target's origin to the tool's [m] and theta the angle between them [rad].

    Attributes:
        tolerance: The largest distance, positive.
        weights: w_x, w_y, w_z [1/m] and w_r [1/rad], none negative, shape (4,); what has no weight
            is free.
        frame: By whose axes x, y and z are: "" for the target's own, "world", or any frame of the
            scene.
    """

    tolerance: float
    weights: Float64[np.ndarray, "4"]
    frame: str = ""


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
        ball: Accepts other poses than the two tolerances say, which count for nothing then; the
            solutions are spread over them. None for what the tolerances say.
    """

    targets: tuple[PoseTarget, ...]
    frame: str
    position_tolerance: Float64[np.ndarray, "3"]
    rotation_tolerance: Float64[np.ndarray, "3"]
    approach: Float64[np.ndarray, "3"] | None = None
    retreat: Float64[np.ndarray, "3"] | None = None
    ball: PoseBall | None = None


@dataclass(frozen=True, eq=False)
class LineGoal(Value):
    """Bring a tool frame to a pose in a straight line, or through several, at rest at each.

    Attributes:
        targets: At least one: a pose, or a way from where the line before it ends; a frame that
            moves counts where the start puts it.
        frame: Full name of the tool frame; "" for the group's default.
        max_shift: How far the tool may be from the lines [m].
        max_turn: How far its rotation may be off [rad].
    """

    targets: tuple[PoseTarget | Displacement, ...]
    frame: str = ""
    max_shift: float = MAX_SHIFT
    max_turn: float = MAX_TURN


@dataclass(frozen=True, eq=False)
class RegionGoal(Value):
    """Bring a tool frame into any of some regions; the solutions are spread over them.

    The pose X_GT that the tool frame T has in the region's frame G is in the region if its
    position is in the box, and its rotation is as far from none as `rotation_tolerance` allows:

    - No axis is free: every component of its rotation vector is within its bound.
    - One is: it is a turn about that axis, then a tilt (a rotation vector square to the axis)
      whose components are within their bounds. "Any yaw" is z free and the others 0.
    - Two are: it is a turn about the third axis, within its bound, then any tilt.
    - Three are: it is any rotation.

    Attributes:
        targets: X_FG, the middle of each region; at least one.
        frame: Full name of the tool frame; "" for the group's default.
        position_tolerance: Half-widths of the box, in G's axes [m], shape (3,); infinite leaves an
            axis free, and solutions are then looked for as far as the group reaches.
        rotation_tolerance: By G's axes [rad], shape (3,); pi or more leaves an axis free.
        approach: As of PoseGoal, in G's axes, wherever in the region the motion ends.
        retreat: The same.
    """

    targets: tuple[PoseTarget, ...]
    frame: str
    position_tolerance: Float64[np.ndarray, "3"]
    rotation_tolerance: Float64[np.ndarray, "3"]
    approach: Float64[np.ndarray, "3"] | None = None
    retreat: Float64[np.ndarray, "3"] | None = None


@dataclass(frozen=True, eq=False)
class RelativeGoal(Value):
    """Move a tool frame T from where the start has it.

    Without a reference the displacement is in T itself: X_WT_goal = X_WT @ displacement. With a
    reference F its axes at the start count: T's origin moves by R_WF p and T turns about its own
    origin by R_WF R R_WF^-1, where p and R are the displacement's parts. So "5 cm up" is
    position (0, 0, 0.05) in "world", whichever way T looks.

    Attributes:
        displacement: By how much.
        frame: Full name of T; "" for the group's default.
        reference: Name of F, any frame of the scene; "" for T itself.
    """

    displacement: Pose
    frame: str = ""
    reference: str = ""


@dataclass(frozen=True, eq=False)
class GoalPredicate:
    """Reach any configuration that a function of yours accepts.

    It is looked for in the start, near it, and then among configurations drawn within the joint
    limits, or by `draw`. A function has no content that could be compared, so this is no `Value`:
    it equals itself alone, and a problem with it can neither be compared nor hashed.

    Attributes:
        accepts: Says of the group's q, shape (nq,), whether it is a goal. Free of side effects.
        draw: Makes a candidate q, shape (nq,), from a generator; None for the joint limits.
    """

    accepts: Callable[[np.ndarray[Any, np.dtype[np.float64]]], bool]
    draw: Callable[[np.random.Generator], np.ndarray[Any, np.dtype[np.float64]]] | None = None


# Goals that may have an approach and a retreat.
type LinedGoal = PoseGoal | RegionGoal
type ReachGoal = PoseGoal | RegionGoal | RelativeGoal
type Goal = JointGoal | ConfigurationGoal | ReachGoal | LineGoal | GoalPredicate
