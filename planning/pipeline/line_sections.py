"""Line sections of a motion: straight tool lines of its segments, from the motion itself."""

from collections.abc import Sequence

import numpy as np

from planning.domain.curves.curve import TimedTrajectory
from planning.domain.goals.goal import LineGoal
from planning.domain.goals.linear_moves import (
    MAX_POSITION_DEVIATION,
    MAX_ROTATION_DEVIATION,
    LineSection,
    ToolLine,
)
from planning.domain.report.motion_plan import PlanPart
from planning.domain.request.problem import PlanningProblem
from planning.domain.robot.joints import JointGroup
from planning.pipeline.segments import tool_frame
from planning.world.world import World


def line_sections(
    world: World,
    group: JointGroup,
    problem: PlanningProblem,
    motion: TimedTrajectory,
    parts: Sequence[PlanPart],
) -> tuple[LineSection, ...]:
    """Return the lines of the straight segments, between the tool poses at their ends.

    Args:
        world: Loaded scene.
        group: Joint group that moves.
        problem: Problem whose goal has the tool frame and the largest deviations from its lines.
        motion: The whole motion.
        parts: Segments of the motion.
    """
    goal, frame = problem.goal, tool_frame(group, problem.goal)
    max_shift, max_turn = MAX_POSITION_DEVIATION, MAX_ROTATION_DEVIATION
    if isinstance(goal, LineGoal):
        max_shift, max_turn = goal.max_position_deviation, goal.max_rotation_deviation
    sections: list[LineSection] = []
    for part in parts:
        if part.kind != "free":
            ends = world.embed(group, motion.positions(np.array([part.begin, part.end])))
            begin, end = (world.frame_pose(frame, q) for q in ends)
            line = ToolLine(frame, begin, end)
            sections.append(LineSection(line, part.begin, part.end, max_shift, max_turn))
    return tuple(sections)
