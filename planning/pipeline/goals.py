"""From a problem to a context: every check of its input, every default, its start and its goals."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from planning.domain.goals.goal import LineGoal
from planning.domain.goals.goal_configurations import GoalConfigurations
from planning.domain.goals.linear_moves import LinearMove
from planning.domain.report.motion_plan import Progress
from planning.domain.request.attempt_pool import AttemptPool
from planning.domain.request.deadline import Deadline
from planning.domain.request.problem import PlanningProblem
from planning.domain.request.stopwatch import Stopwatch
from planning.domain.robot.joints import JointGroup
from planning.errors import ProblemInvalid
from planning.goals import find_goals as goals_stage
from planning.goals.goal_query import GoalQuery
from planning.goals.lines.line_goal import follow_lines
from planning.goals.start import validate_start
from planning.pipeline.constrained_search import compile_constraints, filter_goals
from planning.pipeline.context import PlanContext
from planning.pipeline.region_guide import validate_regions
from planning.pipeline.segments import at_end_of
from planning.pipeline.timing_options import validate_timing
from planning.refine.constraints.clearance_objective import require_wish
from planning.retime.limits.request_limits import path_limits
from planning.roadmaps.load_or_build import load_or_build, validate_search
from planning.roadmaps.roadmap_cache import RoadmapStore
from planning.roadmaps.roadmap_context import RoadmapContext
from planning.search.space_options import resolve_space
from planning.world.collision.margins import PairMargins
from planning.world.loading.positions import require_positions
from planning.world.world import Array, World

# Share of the time that building a roadmap may take.
_ROADMAP_SHARE = 0.6


@dataclass(frozen=True, kw_only=True)
class ResolvedProblem:
    """A problem that makes sense in its world; whether it can be solved is open.

    Attributes:
        world: The scene, loaded.
        problem: As it was given.
        group: Whose joints move, with the spaces that the problem chooses for them.
        given: Start that was asked for, shape (nq,).
        margins: Distances to keep.
        deadline: Of the whole plan.
        report: Receives the progress.
        watch: Adds up the time of every stage.
        pool: Makes several attempts of the search at once, or None.
    """

    world: World
    problem: PlanningProblem
    group: JointGroup
    given: Array
    margins: PairMargins
    deadline: Deadline
    report: Callable[[Progress], None]
    watch: Stopwatch
    pool: AttemptPool | None


def resolve(
    problem: PlanningProblem,
    world: World,
    deadline: Deadline,
    report: Callable[[Progress], None],
    watch: Stopwatch,
    pool: AttemptPool | None,
) -> ResolvedProblem:
    """Return a problem with its defaults filled in.

    Raises:
        InputError: It names what does not exist, or its numbers do not fit.
    """
    group = resolve_space(world.group(problem.group), problem.search.spaces)
    given = world.positions(group) if problem.start is None else problem.start
    given = require_positions(group, given, "start")
    margins = world.margins(problem.margin)
    if problem.search.allowed_planning_time <= 0:
        message = "search.allowed_planning_time must be positive"
        raise ProblemInvalid(message, {"field": "search.allowed_planning_time"})
    require_wish(problem.refine)
    validate_regions(problem, world, group)
    validate_search(problem)
    return ResolvedProblem(
        world=world,
        problem=problem,
        group=group,
        given=given,
        margins=margins,
        deadline=deadline.limited(problem.search.allowed_planning_time).cutting(watch.note_cut),
        report=report,
        watch=watch,
        pool=pool,
    )


def find_goals(resolved: ResolvedProblem) -> PlanContext:
    """Return the context of the later stages: start, goals and path constraints.

    Raises:
        InputError: Options of the timing, or path constraints, make no sense.
        PlanningFailure: The start or all goals are impossible.
    """
    world, group, problem = resolved.world, resolved.group, resolved.problem
    margins, deadline = resolved.margins, resolved.deadline
    resolved.report(Progress("goals", 0.02, "looking for goal configurations"))
    with resolved.watch.stage("goals"):
        start, clipped = validate_start(world, group, resolved.given, margins)
        problem = replace(problem, retime=validate_timing(world, group, problem.retime, start))
        rules = compile_constraints(world, group, problem.constraints, start)
        query = GoalQuery(group, problem.goal, start, margins, problem.ik, rules=rules)
        goals, lines = _goals(world, query, problem.seed, deadline.share(0.5))
        if rules is not None:
            goals = filter_goals(world, query, goals, problem.seed, deadline.share(0.5))
            rules = rules.leaving_room(start, goals.entries)
    limits = world.limits(group)
    return PlanContext(
        world=world,
        problem=problem,
        group=group,
        limits=limits if rules is None else rules.limits(limits),
        margins=margins,
        start=start,
        start_clipped=clipped,
        goals=goals,
        lines=lines,
        path_limits=path_limits(world, group, problem.retime),
        deadline=deadline,
        report=resolved.report,
        watch=resolved.watch,
        rules=rules,
        pool=resolved.pool,
    )


def with_roadmap(context: PlanContext, roadmaps: RoadmapStore | None) -> PlanContext:
    """Return a context with its roadmap, if the problem wants one: loaded, or else built."""
    if context.problem.search.roadmap is None:
        return context
    context.report(Progress("roadmap", 0.1, "looking for the roadmap"))
    with context.watch.stage("roadmap"):
        share = context.deadline.share(_ROADMAP_SHARE)
        wanted = RoadmapContext.from_problem(
            context.problem, context.world, context.start, context.rules
        )
        return replace(context, roadmap=load_or_build(wanted, roadmaps, share, context.watch))


def _goals(
    world: World, query: GoalQuery, seed: int, deadline: Deadline
) -> tuple[GoalConfigurations, tuple[LinearMove, ...]]:
    """Return goal configurations, and the lines that lead to the only one if lines are the goal."""
    if isinstance(query.goal, LineGoal):
        lines = follow_lines(world, query, query.goal, deadline)
        return at_end_of(lines), lines
    return goals_stage.find_goals(world, query, np.random.default_rng(seed), deadline), ()
