"""Resolution of a problem: checks of its input, defaults, start and goal configurations."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from planning.domain.arrays import Array
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
from planning.goals.start_validation import resolve_start, validate_start
from planning.pipeline.constrained_search import compile_constraints, filter_goals
from planning.pipeline.context import PlanContext
from planning.pipeline.gcs_planner import validate_regions
from planning.pipeline.segments import end_of_moves
from planning.pipeline.timing.timing_options import resolve_retiming
from planning.refine.validate_options import validate_refinement
from planning.retime.limits.request_limits import path_limits
from planning.roadmaps.load_or_build import load_or_build, validate_roadmap_options
from planning.roadmaps.roadmap_cache import RoadmapStore
from planning.roadmaps.roadmap_context import RoadmapContext
from planning.search.space_options import resolve_space
from planning.world.collision.margins import PairMargins
from planning.world.world import World

# Share of the time that building a roadmap may take.
_ROADMAP_TIME_FRACTION = 0.6


@dataclass(frozen=True, kw_only=True)
class ResolvedProblem:
    """Valid problem in its world; its start and goals are not checked yet.

    Attributes:
        world: Loaded scene.
        problem: The given problem.
        group: Joint group that moves, with the joint spaces of the search options.
        requested_start: Start, given or from the scene's state, shape (nq,).
        margins: Required distance of every body pair [m].
        deadline: Deadline of the whole plan.
        report_progress: Callback for the progress.
        watch: Stopwatch of the stages.
        pool: Pool of processes for concurrent search attempts; None for none.
    """

    world: World
    problem: PlanningProblem
    group: JointGroup
    requested_start: Array
    margins: PairMargins
    deadline: Deadline
    report_progress: Callable[[Progress], None]
    watch: Stopwatch
    pool: AttemptPool | None


def resolve(
    problem: PlanningProblem,
    world: World,
    deadline: Deadline,
    report_progress: Callable[[Progress], None],
    watch: Stopwatch,
    pool: AttemptPool | None,
) -> ResolvedProblem:
    """Return a problem with its defaults filled in, after checks of its input.

    Raises:
        InputError: The problem has an unknown name or invalid numbers.
    """
    group = resolve_space(world.group(problem.group), problem.search.spaces)
    requested_start = resolve_start(world, group, problem.start)
    margins = world.margins(problem.margin)
    if problem.search.allowed_planning_time <= 0:
        message = "search.allowed_planning_time must be positive"
        raise ProblemInvalid(message, {"field": "search.allowed_planning_time"})
    validate_refinement(problem.refine, group, problem.goal, problem.retime.duration)
    validate_regions(problem, world, group)
    validate_roadmap_options(problem)
    return ResolvedProblem(
        world=world,
        problem=problem,
        group=group,
        requested_start=requested_start,
        margins=margins,
        deadline=deadline.limited(problem.search.allowed_planning_time).with_on_expiry(
            watch.record_cut
        ),
        report_progress=report_progress,
        watch=watch,
        pool=pool,
    )


def find_goals(resolved: ResolvedProblem) -> PlanContext:
    """Return the context of the later stages: start, goal configurations and path constraints.

    Raises:
        InputError: Timing options or path constraints are invalid.
        PlanningFailure: The start or all goal configurations are infeasible.
    """
    world, group, problem = resolved.world, resolved.group, resolved.problem
    margins, deadline = resolved.margins, resolved.deadline
    resolved.report_progress(Progress("goals", 0.02, "looking for goal configurations"))
    with resolved.watch.stage("goals"):
        start, clipped = validate_start(world, group, resolved.requested_start, margins)
        timing = resolve_retiming(world, group, problem.retime, start)
        if timing is not problem.retime:
            problem = replace(problem, retime=timing)
        constraints = compile_constraints(world, group, problem.constraints, start)
        query = GoalQuery(group, problem.goal, start, margins, problem.ik, constraints=constraints)
        goals, lines = _find_configurations(world, query, problem.seed, deadline.at_fraction(0.5))
        if constraints is not None:
            goals = filter_goals(world, query, goals, problem.seed, deadline.at_fraction(0.5))
            constraints = constraints.tightened(start, goals.entries)
    limits = world.limits(group)
    return PlanContext(
        world=world,
        problem=problem,
        group=group,
        limits=limits if constraints is None else constraints.limits(limits),
        margins=margins,
        start=start,
        start_clipped=clipped,
        goals=goals,
        lines=lines,
        path_limits=path_limits(world, group, problem.retime),
        deadline=deadline,
        report_progress=resolved.report_progress,
        watch=resolved.watch,
        constraints=constraints,
        pool=resolved.pool,
    )


def with_roadmap(context: PlanContext, roadmaps: RoadmapStore | None) -> PlanContext:
    """Return a context with its roadmap, loaded or else built, if the problem requests one."""
    if context.problem.search.roadmap is None:
        return context
    context.report_progress(Progress("roadmap", 0.1, "looking for the roadmap"))
    with context.watch.stage("roadmap"):
        build_deadline = context.deadline.at_fraction(_ROADMAP_TIME_FRACTION)
        roadmap_context = RoadmapContext.from_problem(
            context.problem, context.world, context.start, context.constraints
        )
        return replace(
            context, roadmap=load_or_build(roadmap_context, roadmaps, build_deadline, context.watch)
        )


def _find_configurations(
    world: World, query: GoalQuery, seed: int, deadline: Deadline
) -> tuple[GoalConfigurations, tuple[LinearMove, ...]]:
    """Return the goal configurations, and the linear moves of a line goal, else none."""
    if isinstance(query.goal, LineGoal):
        lines = follow_lines(world, query, query.goal, deadline)
        return end_of_moves(lines), lines
    return goals_stage.find_goals(world, query, np.random.default_rng(seed), deadline), ()
