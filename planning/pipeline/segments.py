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
        leg: The line that it follows, if it does.
        report: How it was timed.
    """

    kind: PartKind
    path: JointPath
    curve: JointSpline
    trajectory: TimedTrajectory
    leg: LinearMove | None
    report: RetimeReport


def tool_of(group: JointGroup, goal: Goal) -> str:
    """Return the tool frame that a goal speaks of, or the group's default, or "" for none."""
    named = goal.frame if isinstance(goal, PoseGoal | RegionGoal | LineGoal) else ""
    return named or next(iter(group.tool_frames), "")


def at_end_of(lines: Sequence[LinearMove]) -> GoalConfigurations:
    """Return the goal configuration that lines lead to, one after another."""
    end = lines[-1].positions[-1:]
    return GoalConfigurations(end, (len(lines) - 1,), Funnel(1, 1, 1, 1, 1, approach_ok=1))


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


def ends_of(goals: GoalConfigurations) -> Array:
    """Return where a motion to each goal configuration ends, shape (n, nq)."""
    retreats = [legs.retreat for legs in goals.legs if legs.retreat is not None]
    return np.stack([leg.positions[-1] for leg in retreats]) if retreats else goals.positions


def approach_segments(legs: GoalMoves) -> list[tuple[PartKind, LinearMove]]:
    """Return the legs of a goal in the order in which they are followed."""
    named: list[tuple[PartKind, LinearMove]] = []
    if legs.approach is not None:
        named.append(("approach", legs.approach))
    if legs.retreat is not None:
        named.append(("retreat", legs.retreat))
    return named


def named_lines(legs: Sequence[LinearMove]) -> list[tuple[PartKind, LinearMove]]:
    """Return the legs of a line goal, named as such."""
    return [("line", leg) for leg in legs]


def without_duration(problem: PlanningProblem) -> PlanningProblem:
    """Return a problem that leaves the duration open: it is asked of all parts together."""
    return replace(problem, retime=replace(problem.retime, duration=None))


def timed_legs(  # noqa: PLR0913, PLR0917  (a question in full)
    world: World,
    group: JointGroup,
    legs: Sequence[tuple[PartKind, LinearMove]],
    problem: PlanningProblem,
    begin: Array,
    path_limits: Sequence[PathLimit],
    deadline: Deadline,
) -> tuple[MotionSegment, ...]:
    """Time legs one after another, each along a smooth curve through its waypoints.

    Args:
        world: The scene.
        group: What moves.
        legs: What they are for, and the legs.
        problem: Its options say how.
        begin: Where the first one begins, shape (nq,); whole turns of joints go on from here.
        path_limits: What the problem limits besides the joints.
        deadline: When to give up.

    Raises:
        RetimingFailed: A leg cannot be timed.
        DeadlineExceeded: Time ran out.
        Canceled: The end was asked for.
    """
    limits, parts = world.limits(group), list[MotionSegment]()
    for kind, leg in legs:
        rows = np.concatenate([begin[None], leg.positions])
        positions = JointPath(group, rows).continuous.waypoints[1:]
        curve = cubic_through(group.joints, leg.fractions, positions)
        options = without_duration(problem).retime
        trajectory, report = retime(curve, limits, options, path_limits, deadline)
        count = max(problem.search.approach_states, len(positions))
        waypoints = curve.manifold.normalized(curve.positions(np.linspace(0.0, 1.0, count)))
        parts.append(
            MotionSegment(kind, JointPath(group, waypoints), curve, trajectory, leg, report)
        )
        begin = positions[-1]
    return tuple(parts)


def free_segment(path: JointPath, candidate: Candidate) -> MotionSegment:
    """Return a candidate for the free way as a part."""
    return MotionSegment(
        "free", path, candidate.curve, candidate.trajectory, None, candidate.retime
    )
