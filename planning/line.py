"""trace_line(): how far a tool can be moved in a straight line, and what stops it."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain import rotation
from planning.domain.deadline import Deadline
from planning.domain.goal import PoseTarget
from planning.domain.line import ToolLine
from planning.domain.line_trace import LineTrace
from planning.domain.pose import Pose
from planning.domain.value import Value
from planning.errors import ProblemInvalid
from planning.goals.line_stop import traced
from planning.goals.line_tracer import Fineness, LineTracer
from planning.goals.tool_target import placed
from planning.world.positions import require_positions
from planning.world.world import Array, World

__all__ = ["Displacement", "Fineness", "trace_line"]


@dataclass(frozen=True, eq=False)
class Displacement(Value):
    """A way without a turn.

    Attributes:
        vector: The way [m], shape (3,).
        frame: In whose axes: "world" or any frame of the scene, as it stands at the start.
    """

    vector: Float64[np.ndarray, "3"]
    frame: str = "world"


def trace_line(  # noqa: PLR0913  (a question in full)
    world: World,
    group: str,
    to: PoseTarget | Displacement,
    *,
    deadline: Deadline,
    start: Any = None,
    frame: str = "",
    margin: float | None = None,
    fineness: Fineness | None = None,
) -> LineTrace:
    """Follow the straight line of a tool from where it stands as far as it goes.

    The rotation turns along with the translation (slerp). What is found is a continuous motion of
    the group; straight ways between its waypoints keep to the line within `fineness`.

    Args:
        world: The scene, loaded.
        group: `robot` or `robot::group`.
        to: Where the line ends: a pose of the tool, or a way from where it stands.
        deadline: When to give up.
        start: The group's q, shape (nq,); None for the scene's state.
        frame: Full name of the tool frame; "" for the group's default.
        margin: Distance to keep [m]; None for the scene's.
        fineness: How near to the line, and in what steps.

    Not promised: collisions are looked for every 0.02 rad or m of joint space, not between; and a
    redundant group takes one of its many ways, which may end before another would.

    Raises:
        UnknownName: A group or frame does not exist.
        ProblemInvalid: The start does not fit the group.
        DeadlineExceeded: Time ran out.
        Canceled: Somebody asked for the end.
    """
    joints = world.group(group)
    given = world.positions(joints) if start is None else start
    q = require_positions(joints, given, "start")
    fine = fineness or Fineness()
    if not min(fine.max_shift, fine.max_turn, fine.max_step) > 0:
        message = "max_shift, max_turn and max_step of a line must be positive"
        raise ProblemInvalid(message, {"field": "fineness"})
    margins = world.margins(margin)
    tool = frame or joints.tool_frames[0]
    tracer = LineTracer(world, joints, tool, margins, fine)
    full = world.embed(joints, q)
    line = tool_line(world, full, tool, to)
    course = tracer.trace([line], q[None], deadline)[0]
    return traced(world, joints, margins, tracer.kinematics, course)


def tool_line(world: World, full: Array, tool: str, to: PoseTarget | Displacement) -> ToolLine:
    """Return the line of a tool from where a full configuration puts it.

    Raises:
        UnknownName: A frame does not exist.
    """
    begin = world.frame_pose(tool, full)
    match to:
        case PoseTarget():
            return ToolLine(tool, begin, placed(world, full, to))
        case Displacement():
            axes = placed(world, full, PoseTarget(Pose.identity(), to.frame))
            way = rotation.rotate(axes.quaternion, np.asarray(to.vector))
            return ToolLine(tool, begin, Pose(begin.position + way, begin.quaternion))
