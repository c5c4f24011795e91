"""MotionSegment: a free motion or a linear move, each timed by itself from rest to rest.

start --free--> beginning of the approach --approach--> goal --retreat--> end
start --line--> first pose --line--> second pose ...
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from planning.domain.arrays import Array
from planning.domain.curves.cubic import cubic_through
from planning.domain.curves.curve import JointSpline, TimedTrajectory
from planning.domain.curves.path import JointPath
from planning.domain.goals.funnel import Funnel
from planning.domain.goals.goal import Goal, LineGoal, PoseGoal, RegionGoal, RelativeGoal
from planning.domain.goals.goal_configurations import GoalConfigurations
from planning.domain.goals.linear_moves import GoalMoves, LinearMove
from planning.domain.report.search_report import SearchReport
from planning.domain.report.stage_reports import RefineReport, RetimeReport
from planning.domain.request.deadline import Deadline
from planning.domain.request.problem import PlanningProblem
from planning.domain.robot.joints import JointGroup
from planning.pipeline.timing.candidate_timing import CandidateMotion
from planning.retime.limits.path_limit import PathLimit
from planning.retime.retimer import retime
from planning.world.world import World

type PartKind = Literal["free", "approach", "retreat", "line"]

# Report of motions along lines, which are not refined.
NOT_REFINED = RefineReport("none", improved=False, reason="lines are followed as they are")


@dataclass(frozen=True)
class MotionSegment:
    """Timed segment of a motion.

    Attributes:
        kind: "free", "approach", "retreat" or "line".
        path: Waypoints of the segment.
        curve: Geometric curve that the segment follows.
        trajectory: Trajectory from rest to rest, beginning at time 0.
        move: Linear move that the segment follows; None for a free segment.
        report: Report of the retiming.
    """

    kind: PartKind
    path: JointPath
    curve: JointSpline
    trajectory: TimedTrajectory
    move: LinearMove | None
    report: RetimeReport


def tool_frame(group: JointGroup, goal: Goal) -> str:
    """Return the tool frame of a goal, or else the group's default, or "" if there is none."""
    has_frame = isinstance(goal, PoseGoal | RegionGoal | LineGoal | RelativeGoal)
    frame = goal.frame if has_frame else ""
    return frame or next(iter(group.tool_frames), "")


def end_of_moves(lines: Sequence[LinearMove]) -> GoalConfigurations:
    """Return the end configuration of successive linear moves as the only goal configuration."""
    end = lines[-1].positions[-1:]
    return GoalConfigurations(
        end, (len(lines) - 1,), Funnel(1, 1, 1, 1, 1, num_with_linear_moves=1)
    )


def empty_search_report(path: JointPath) -> SearchReport:
    """Return the search report of a path that needed no search."""
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
    """Return the last configuration of a motion to each goal configuration, shape (n, nq)."""
    retreats = [moves.retreat for moves in goals.moves if moves.retreat is not None]
    return (
        np.stack([retreat.positions[-1] for retreat in retreats]) if retreats else goals.positions
    )


def approach_moves(goal_moves: GoalMoves) -> list[tuple[PartKind, LinearMove]]:
    """Return the approach and the retreat of a goal, in this order, with their kinds."""
    moves: list[tuple[PartKind, LinearMove]] = []
    if goal_moves.approach is not None:
        moves.append(("approach", goal_moves.approach))
    if goal_moves.retreat is not None:
        moves.append(("retreat", goal_moves.retreat))
    return moves


def line_moves(moves: Sequence[LinearMove]) -> list[tuple[PartKind, LinearMove]]:
    """Return the linear moves of a line goal with their kind."""
    return [("line", move) for move in moves]


def without_duration(problem: PlanningProblem) -> PlanningProblem:
    """Return a problem without its duration, which applies to all segments together."""
    return replace(problem, retime=replace(problem.retime, duration=None))


def retime_moves(  # noqa: PLR0913, PLR0917  (all inputs of a stage)
    world: World,
    group: JointGroup,
    moves: Sequence[tuple[PartKind, LinearMove]],
    problem: PlanningProblem,
    begin: Array,
    path_limits: Sequence[PathLimit],
    deadline: Deadline,
) -> tuple[MotionSegment, ...]:
    """Retime linear moves one after another, each along a cubic spline through its waypoints.

    Args:
        world: Loaded scene.
        group: Joint group that moves.
        moves: Kinds and linear moves.
        problem: Problem with the options of the retiming.
        begin: Configuration at the beginning of the first move, shape (nq,); full turns of joints
            continue from here.
        path_limits: Limits of the problem besides those of joints.
        deadline: Time limit.

    Raises:
        RetimingFailed: A linear move cannot be timed.
        DeadlineExceeded: Time ran out.
        Canceled: Cancellation was requested.
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


def free_segment(path: JointPath, candidate: CandidateMotion) -> MotionSegment:
    """Return the free segment of a candidate motion along a path."""
    return MotionSegment(
        "free", path, candidate.curve, candidate.trajectory, None, candidate.retime
    )
