"""Line goals: linear moves through the goal's targets, or the reason why a line is blocked."""

from planning.domain.goals.goal import LineGoal
from planning.domain.goals.linear_moves import LinearMove, ToolLine
from planning.domain.request.deadline import Deadline
from planning.errors import LineBlocked
from planning.goals.goal_query import GoalQuery
from planning.goals.lines.line_stop import describe_stop, make_line_trace, stop_evidence
from planning.goals.lines.line_tracer import LineTracer, TraceResolution
from planning.goals.targets.tool_target import line_end
from planning.world.world import World


def follow_lines(
    world: World, query: GoalQuery, goal: LineGoal, deadline: Deadline
) -> tuple[LinearMove, ...]:
    """Return a linear move to each of the goal's targets, each from the end of the one before.

    Raises:
        LineBlocked: A line cannot be followed to its end.
        UnknownName: A frame does not exist.
        DeadlineExceeded: Time ran out.
        Canceled: Cancellation was requested.
    """
    tool = goal.frame or query.group.tool_frames[0]
    resolution = TraceResolution(goal.max_position_deviation, goal.max_rotation_deviation)
    tracer = LineTracer(world, query.group, tool, query.margins, resolution)
    q, full = query.start, world.embed(query.group, query.start)
    tool_pose = world.frame_pose(tool, full)
    moves: list[LinearMove] = []
    for i, target in enumerate(goal.targets):
        line = ToolLine(tool, tool_pose, line_end(world, full, tool_pose, target))
        trace_state = tracer.trace([line], q[None], deadline)[0]
        trace = make_line_trace(world, query.group, query.margins, tracer.kinematics, trace_state)
        if trace.stop is not None:
            evidence = {
                "line": i,
                "fraction": trace.fraction,
                "length": trace.length,
                "stopped_by": stop_evidence(trace.stop, query.margins),
            }
            message = f"line {i + 1} of {len(goal.targets)} is blocked: {describe_stop(trace.stop)}"
            raise LineBlocked(message, evidence)
        moves.append(trace.linear_move)
        q, tool_pose = trace.positions[-1], line.end
    return tuple(moves)
