"""Parts: a free motion and straight lines, timed each by itself from rest to rest.

start --free--> beginning of the approach --approach--> goal --retreat--> end
start --line--> first pose --line--> second pose ...
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from planning.domain.curves.cubic import cubic_through
from planning.domain.curves.curve import JointSpline, TimedTrajectory
from planning.domain.curves.path import JointPath
from planning.domain.goals.funnel import Funnel
from planning.domain.goals.goal import Goal, LineGoal, PoseGoal, RegionGoal
from planning.domain.goals.goal_configurations import GoalConfigurations
from planning.domain.goals.linear_moves import GoalMoves, LinearMove
from planning.domain.report.search_report import SearchReport
from planning.domain.report.stage_reports import RefineReport, RetimeReport
from planning.domain.request.deadline import Deadline
from planning.domain.request.problem import PlanningProblem
from planning.domain.robot.joints import JointGroup
from planning.pipeline.candidates import Candidate
from planning.retime.limits.path_limit import PathLimit
from planning.retime.retimer import retime
from planning.world.world import Array, World

type PartKind = Literal["free", "approach", "retreat", "line"]

# Of motions that nobody refines.
NOT_REFINED = RefineReport("none", improved=False, reason="lines are followed as they are")


@dataclass(frozen=True)
class MotionSegment:
    """One timed part of a motion.

    Attributes:
        kind: What it is for.
        path: Its waypoints.
        curve: What it follows.
        trajectory: From rest to rest, beginning at time 0.
        move: The line that it follows, if it does.
        report: How it was timed.
    """

    kind: PartKind
    path: JointPath
    curve: JointSpline
    trajectory: TimedTrajectory
    move: LinearMove | None
    report: RetimeReport


def tool_frame(group: JointGroup, goal: Goal) -> str:
    """Return the tool frame that a goal speaks of, or the group's default, or "" for none."""
    frame = goal.frame if isinstance(goal, PoseGoal | RegionGoal | LineGoal) else ""
    return frame or next(iter(group.tool_frames), "")


def end_of_moves(lines: Sequence[LinearMove]) -> GoalConfigurations:
    """Return the goal configuration that lines lead to, one after another."""
    end = lines[-1].positions[-1:]
    return GoalConfigurations(
        end, (len(lines) - 1,), Funnel(1, 1, 1, 1, 1, num_with_linear_moves=1)
    )


def empty_search_report(path: JointPath) -> SearchReport:
    """Return the report on a path that nobody searched for."""
    return SearchReport(
        planner="none",
        attempts=0,
        solved=0,
        num_states_checked=0,
        num_motions_checked=0,
        raw_length=path.length,
        length=path.length,
        num_waypoints=len(path.waypoints),
        resolution=0.0,
        padding=0.0,
        direct=True,
    )


def end_configurations(goals: GoalConfigurations) -> Array:
    """Return where a motion to each goal configuration ends, shape (n, nq)."""
    retreats = [moves.retreat for moves in goals.moves if moves.retreat is not None]
    return (
        np.stack([retreat.positions[-1] for retreat in retreats]) if retreats else goals.positions
    )


def approach_moves(goal_moves: GoalMoves) -> list[tuple[PartKind, LinearMove]]:
    """Return the legs of a goal in the order in which they are followed."""
    moves: list[tuple[PartKind, LinearMove]] = []
    if goal_moves.approach is not None:
        moves.append(("approach", goal_moves.approach))
    if goal_moves.retreat is not None:
        moves.append(("retreat", goal_moves.retreat))
    return moves


def line_moves(moves: Sequence[LinearMove]) -> list[tuple[PartKind, LinearMove]]:
    """Return the legs of a line goal, named as such."""
    return [("line", move) for move in moves]


def without_duration(problem: PlanningProblem) -> PlanningProblem:
    """Return a problem that leaves the duration open: it is asked of all parts together."""
    return replace(problem, retime=replace(problem.retime, duration=None))


def retime_moves(  # noqa: PLR0913, PLR0917  (a question in full)
    world: World,
    group: JointGroup,
    moves: Sequence[tuple[PartKind, LinearMove]],
    problem: PlanningProblem,
    begin: Array,
    path_limits: Sequence[PathLimit],
    deadline: Deadline,
) -> tuple[MotionSegment, ...]:
    """Time legs one after another, each along a smooth curve through its waypoints.

    Args:
        world: The scene.
        group: What moves.
        moves: What they are for, and the legs.
        problem: Its options say how.
        begin: Where the first one begins, shape (nq,); whole turns of joints go on from here.
        path_limits: What the problem limits besides the joints.
        deadline: When to give up.

    Raises:
        RetimingFailed: A leg cannot be timed.
        DeadlineExceeded: Time ran out.
        Canceled: The end was asked for.
    """
    limits, segments = world.limits(group), list[MotionSegment]()
    for kind, move in moves:
        rows = np.concatenate([begin[None], move.positions])
        positions = JointPath(group, rows).continuous.waypoints[1:]
        curve = cubic_through(group.joints, move.fractions, positions)
        options = without_duration(problem).retime
        trajectory, report = retime(curve, limits, options, path_limits, deadline)
        count = max(problem.search.approach_states, len(positions))
        waypoints = curve.manifold.normalized(curve.positions(np.linspace(0.0, 1.0, count)))
        segments.append(
            MotionSegment(kind, JointPath(group, waypoints), curve, trajectory, move, report)
        )
        begin = positions[-1]
    return tuple(segments)


def free_segment(path: JointPath, candidate: Candidate) -> MotionSegment:
    """Return a candidate for the free way as a part."""
    return MotionSegment(
        "free", path, candidate.curve, candidate.trajectory, None, candidate.retime
    )
