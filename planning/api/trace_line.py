"""trace_line(): straight motion of a tool (MoveL), as far as it is feasible, and its stop."""

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


def trace_line(  # noqa: PLR0913  (all inputs of a request)
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
    """Trace the straight line of a tool from its pose at the start as far as it is feasible.

    The rotation is interpolated along the translation (slerp). The result is a continuous motion of
    the group; joint geodesics between its waypoints stay near the line within `fineness`.

    Not promised: collisions are checked every 0.02 rad or m of joint space, not between; and a
    redundant group follows one of its many joint motions, which may end before another would.

    Args:
        world: Loaded scene.
        group: `robot` or `robot::group`.
        to: End of the line: a pose of the tool, or a displacement from its pose at the start.
        deadline: Time limit.
        start: The group's q, shape (nq,); None for the scene's state.
        frame: Full name of the tool frame; "" for the group's default.
        margin: Required distance of bodies [m]; None for the scene's.
        fineness: Resolution of the trace: largest deviations and steps; None for the default.

    Raises:
        UnknownName: A group or frame does not exist.
        ProblemInvalid: The start does not fit the group, or a number of `fineness` is not positive.
        DeadlineExceeded: Time ran out.
        Canceled: Cancellation was requested.
    """
    joints = world.group(group)
    q = resolve_start(world, joints, start)
    resolution = fineness or TraceResolution()
    if not min(resolution.max_shift, resolution.max_turn, resolution.max_step) > 0:
        message = "fineness: max_shift, max_turn and max_step must be positive"
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
