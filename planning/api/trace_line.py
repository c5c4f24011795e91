"""trace_line(): how far a tool can be moved in a straight line, and what stops it."""

from typing import Any

from planning.domain.goals.goal import PoseTarget
from planning.domain.goals.line_trace import LineTrace
from planning.domain.goals.linear_moves import Displacement, ToolLine
from planning.domain.request.deadline import Deadline
from planning.domain.request.stopwatch import Stopwatch
from planning.errors import ProblemInvalid
from planning.goals.lines.line_stop import make_line_trace
from planning.goals.lines.line_tracer import LineTracer, TraceResolution
from planning.goals.start_validation import resolve_start
from planning.goals.targets.tool_target import line_end
from planning.world.world import World

__all__ = ["TraceResolution", "trace_line"]


def trace_line(  # noqa: PLR0913  (a question in full)
    world: World,
    group: str,
    to: PoseTarget | Displacement,
    *,
    deadline: Deadline,
    start: Any = None,
    frame: str = "",
    margin: float | None = None,
    fineness: TraceResolution | None = None,
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
        Canceled: The end was asked for.
    """
    joints = world.group(group)
    q = resolve_start(world, joints, start)
    resolution = fineness or TraceResolution()
    if not min(resolution.max_shift, resolution.max_turn, resolution.max_step) > 0:
        message = "max_shift, max_turn and max_step of a line must be positive"
        raise ProblemInvalid(message, {"field": "fineness"})
    margins = world.margins(margin)
    tool = frame or joints.tool_frames[0]
    tracer = LineTracer(world, joints, tool, margins, resolution)
    full = world.embed(joints, q)
    begin = world.frame_pose(tool, full)
    line = ToolLine(tool, begin, line_end(world, full, begin, to))
    watch = Stopwatch(deadline.clock)
    with watch.timing_failures(), watch.stage("line"):
        trace_state = tracer.trace([line], q[None], deadline)[0]
        return make_line_trace(world, joints, margins, tracer.kinematics, trace_state)
