"""Goals: the sets of configurations or tool poses that a motion may end in."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.geometry.pose import Pose
from planning.domain.goals.linear_moves import (
    MAX_POSITION_DEVIATION,
    MAX_ROTATION_DEVIATION,
    Displacement,
)
from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class JointGoal(Value):
    """Goal: any of some configurations.

    Attributes:
        positions: The group's q, one per row, shape (n, nq), n >= 1.
    """

    positions: Float64[np.ndarray, "n nq"]


@dataclass(frozen=True, eq=False)
class ConfigurationGoal(Value):
    """Goal: a named configuration of the scene or the robot.

    Attributes:
        name: For example "home".
    """

    name: str


@dataclass(frozen=True, eq=False)
class PoseTarget(Value):
    """Target pose of a tool frame, in a reference frame.

    Attributes:
        pose: X_FG, the target G in the reference frame F.
        frame: Name of F; "world" or any frame of the scene.
    """

    pose: Pose
    frame: str = "world"


@dataclass(frozen=True, eq=False)
class PoseBall(Value):
    """Tolerance of a pose goal: all poses within a weighted distance of the target.

    It replaces the box and the rotation bounds. The distance is
    sqrt((w_x x)^2 + (w_y y)^2 + (w_z z)^2 + (w_r theta)^2), with x, y, z the displacement
    from the target's origin to the tool's [m] and theta the angle between them [rad].

    Attributes:
        tolerance: The largest distance, positive.
        weights: w_x, w_y, w_z [1/m] and w_r [1/rad], none negative, shape (4,); a direction of
            weight 0 is free.
        frame: Frame of the axes of x, y and z: "" for the target's own, "world", or any frame of
            the scene.
    """

    tolerance: float
    weights: Float64[np.ndarray, "4"]
    frame: str = ""


@dataclass(frozen=True, eq=False)
class PoseGoal(Value):
    """Goal: a tool frame at any of some poses, within tolerances.

    Attributes:
        targets: The candidates, at least one; the index of the chosen one is in the result.
        frame: Full name of the tool frame; "" for the group's default.
        position_tolerance: Half-widths of the box about the target, in its axes [m], shape (3,).
        rotation_tolerance: Largest rotation vector components, in the target's axes [rad], shape
            (3,); an entry of pi or more leaves that axis free.
        approach: Displacement of the tool at the beginning of the approach, the last part of the
            motion, a straight line without rotation; in the target's axes [m], shape (3,); None for
            none.
        retreat: Displacement of the tool in the retreat, a straight line after the goal; in the
            target's axes [m], shape (3,); None for none.
        ball: Tolerance that replaces the two others, which are ignored then; the solutions are
            spread over it. None for the two others.
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
    """Goal: a tool frame at the end of one or several straight lines, at rest after each.

    Attributes:
        targets: At least one: a pose, or a displacement from the end of the line before it; a frame
            that moves is taken at the start configuration.
        frame: Full name of the tool frame; "" for the group's default.
        max_position_deviation: Largest distance of the tool's origin from the lines [m].
        max_rotation_deviation: Largest error of its rotation [rad].
    """

    targets: tuple[PoseTarget | Displacement, ...]
    frame: str = ""
    max_position_deviation: float = MAX_POSITION_DEVIATION
    max_rotation_deviation: float = MAX_ROTATION_DEVIATION


@dataclass(frozen=True, eq=False)
class RegionGoal(Value):
    """Goal: a tool frame in any of some pose regions; the solutions are spread over them.

    The pose X_GT of the tool frame T in the region's frame G is in the region if its position is
    in the box, and its rotation within `rotation_tolerance`:

    - No axis is free: every component of its rotation vector is within its bound.
    - One is: it is a rotation about that axis, then a tilt (a rotation vector square to the axis)
      whose components are within their bounds. "Any yaw" is z free and the others 0.
    - Two are: it is a rotation about the third axis, within its bound, then any tilt.
    - Three are: it is any rotation.

    Attributes:
        targets: X_FG, the middle of each region; at least one.
        frame: Full name of the tool frame; "" for the group's default.
        position_tolerance: Half-widths of the box, in G's axes [m], shape (3,); infinite leaves an
            axis free, and solutions are then searched within the reach of the group.
        rotation_tolerance: By G's axes [rad], shape (3,); pi or more leaves an axis free.
        approach: As of PoseGoal, in G's axes, for every end pose in the region.
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
    """Goal: a tool frame T displaced relative to its pose at the start.

    Without a reference the displacement is in T itself: X_WT_goal = X_WT @ displacement. With a
    reference F its axes at the start count: T's origin moves by R_WF p and T turns about its own
    origin by R_WF R R_WF^-1, where p and R are the displacement's parts. So "5 cm up" is
    position (0, 0, 0.05) in "world", for any orientation of T.

    Attributes:
        displacement: The displacement.
        frame: Full name of T; "" for the group's default.
        reference: Name of F, any frame of the scene; "" for T itself.
    """

    displacement: Pose
    frame: str = ""
    reference: str = ""


@dataclass(frozen=True, eq=False)
class GoalPredicate:
    """Goal: any configuration that a Python function of the caller accepts.

    The search tries the start, configurations near it, and then configurations drawn within the
    joint limits, or by `draw`. A function has no content to compare, so this is no `Value`: it
    equals only itself, and a problem with it can be neither compared nor hashed.

    Attributes:
        accepts: Returns whether the group's q, shape (nq,), is a goal. Free of side effects.
        draw: Makes a candidate q, shape (nq,), from a generator; None for the joint limits.
    """

    accepts: Callable[[np.ndarray[Any, np.dtype[np.float64]]], bool]
    draw: Callable[[np.random.Generator], np.ndarray[Any, np.dtype[np.float64]]] | None = None


# Goals that may have an approach and a retreat.
type GoalWithLinearMoves = PoseGoal | RegionGoal
type ReachGoal = PoseGoal | RegionGoal | RelativeGoal
type Goal = JointGoal | ConfigurationGoal | ReachGoal | LineGoal | GoalPredicate
