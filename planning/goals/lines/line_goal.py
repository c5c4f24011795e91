"""Line goals: linear moves through the goal's targets, or the reason why a line is blocked."""

from planning.domain.goals.goal import LineGoal
from planning.domain.goals.linear_moves import LinearMove, ToolLine
from planning.domain.request.deadline import Deadline
from planning.errors import LineBlocked
from planning.goals.goal_query import GoalQuery
from planning.goals.lines.line_stop import describe_stop, stop_evidence, traced
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
    fineness = TraceResolution(goal.max_shift, goal.max_turn)
    tracer = LineTracer(world, query.group, tool, query.margins, fineness)
    q, full = query.start, world.embed(query.group, query.start)
    at = world.frame_pose(tool, full)
    legs: list[LinearMove] = []
    for i, target in enumerate(goal.targets):
        line = ToolLine(tool, at, line_end(world, full, at, target))
        course = tracer.trace([line], q[None], deadline)[0]
        trace = traced(world, query.group, query.margins, tracer.kinematics, course)
        if trace.stop is not None:
            evidence = {
                "line": i,
                "fraction": trace.fraction,
                "length": trace.length,
                "stopped_by": stop_evidence(trace.stop, query.margins),
            }
            message = f"line {i + 1} of {len(goal.targets)} is blocked: {describe_stop(trace.stop)}"
            raise LineBlocked(message, evidence)
        legs.append(trace.leg)
        q, at = trace.positions[-1], line.end
    return tuple(legs)
