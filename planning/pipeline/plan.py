"""plan(): the stages in order. Read this first.

    scene -> goals (batched IK, lines) -> search (OMPL) -> refine (sequential convex programs)
          -> retime (toppra or ruckig) -> certify (Drake, fresh context) -> MotionPlan

The stages do not know each other. What a stage cannot do better it leaves alone: several candidate
motions are timed, the quickest one that the certifier proves is delivered, and if none is proven
the search is asked again, for more distance and with a finer eye. Straight lines (`parts`) belong
to the goals: what the search finds leads to where they begin.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from planning.domain.goals.goal import LineGoal
from planning.domain.goals.goal_configurations import GoalConfigurations
from planning.domain.goals.line import LinearMove
from planning.domain.report.motion_plan import MotionPlan, Progress, StageReports, ignore_progress
from planning.domain.request.attempt_pool import AttemptPool
from planning.domain.request.deadline import Deadline
from planning.domain.request.problem import PlanningProblem
from planning.domain.request.stopwatch import Stopwatch
from planning.errors import ProblemInvalid
from planning.goals.find_goals import GoalQuery, find_goals
from planning.goals.lines.line_goal import follow_lines
from planning.goals.start import validate_start
from planning.pipeline.constrained_search import compile_constraints, filter_goals
from planning.pipeline.context import PlanContext, StageProgress
from planning.pipeline.prove import certify_lines, certify_search
from planning.pipeline.region_guide import validate_regions
from planning.pipeline.segments import at_end_of, tool_of
from planning.pipeline.timing_options import validate_timing
from planning.refine.constraints.clearance_objective import require_wish
from planning.roadmaps.load_or_build import load_or_build, validate_search
from planning.roadmaps.roadmap_cache import RoadmapStore
from planning.roadmaps.roadmap_context import RoadmapContext
from planning.search.space_options import resolve_space
from planning.world.loading.positions import require_positions
from planning.world.world import World

# Of the time, what building a roadmap may take.
_ROADMAP_SHARE = 0.6


def plan(
    problem: PlanningProblem,
    world: World,
    *,
    deadline: Deadline,
    on_progress: Callable[[Progress], None] = ignore_progress,
    roadmaps: RoadmapStore | None = None,
    pool: AttemptPool | None = None,
) -> MotionPlan:
    """Plan a certified motion.

    The same problem in the same scene gives the same bytes, as long as the deadline cuts nothing;
    what it cuts is in `MotionPlan.cut_short`. Work that a plan can do without (refinement, the
    explanation of the duration) is cut before the plan is lost.

    Args:
        problem: Group, start, goal, options, seed.
        world: The scene, loaded.
        deadline: When to give up, if the problem's allowed time, which begins now, does not end
            before; also asked whether anybody still wants the answer.
        on_progress: Told of every stage.
        roadmaps: Where a roadmap is looked for, and left if it had to be built, if the problem asks
            for one; what is found there changes no byte.
        pool: Makes several attempts of the search at once; that changes no byte either.

    Raises:
        InputError: The problem names what does not exist, or its numbers do not fit.
        PlanningFailure: There is no motion to give; code, stage and evidence say why, and `timings`
            how long the stages took.
    """
    report = StageProgress(on_progress)
    watch = Stopwatch(deadline.clock, report.begin)
    with watch.timing_failures():
        group = resolve_space(world.group(problem.group), problem.search.spaces)
        given = world.positions(group) if problem.start is None else problem.start
        given = require_positions(group, given, "start")
        margins = world.margins(problem.margin)
        if problem.search.allowed_planning_time <= 0:
            message = "search.allowed_planning_time must be positive"
            raise ProblemInvalid(message, {"field": "search.allowed_planning_time"})
        deadline = deadline.limited(problem.search.allowed_planning_time).cutting(watch.note_cut)
        require_wish(problem.refine)
        validate_regions(problem, world, group)
        validate_search(problem)
        report(Progress("goals", 0.02, "looking for goal configurations"))
        with watch.stage("goals"):
            start, clipped = validate_start(world, group, given, margins)
            problem = replace(problem, retime=validate_timing(world, group, problem.retime, start))
            rules = compile_constraints(world, group, problem.constraints, start)
            query = GoalQuery(group, problem.goal, start, margins, problem.ik, rules=rules)
            goals, lines = _goals(world, query, problem.seed, deadline.share(0.5))
            if rules is not None:
                goals = filter_goals(world, query, goals, problem.seed, deadline.share(0.5))
                rules = rules.leaving_room(start, goals.entries)
        roadmap = None
        if problem.search.roadmap is not None:
            report(Progress("roadmap", 0.1, "looking for the roadmap"))
            with watch.stage("roadmap"):
                share = deadline.share(_ROADMAP_SHARE)
                ground = RoadmapContext.from_problem(problem, world, start, rules)
                roadmap = load_or_build(ground, roadmaps, share, watch)
        limits = world.limits(group) if rules is None else rules.limits(world.limits(group))
        task = PlanContext(
            world,
            problem,
            group,
            limits,
            margins,
            start,
            goals,
            lines,
            deadline,
            report,
            watch,
            rules,
            roadmap,
            pool,
        )
        proven = certify_lines(task) if lines else certify_search(task)
        motion = proven.motion
        return MotionPlan(
            group=group,
            start=start,
            start_clipped=clipped,
            goal_configuration=motion.goal_configuration,
            goal_index=goals.target_indices[proven.goal_row],
            path=motion.path,
            trajectory=motion.trajectory,
            certificate=proven.certificate,
            stages=StageReports(goals, proven.search, proven.refine, motion.report, proven.certify),
            timings=watch.seconds,
            cut_short=watch.cut_short,
            graph=proven.graph,
            parts=motion.described(world, tool_of(group, problem.goal)),
        )


def _goals(
    world: World, query: GoalQuery, seed: int, deadline: Deadline
) -> tuple[GoalConfigurations, tuple[LinearMove, ...]]:
    """Return goal configurations, and the lines that lead to the only one if lines are the goal."""
    if isinstance(query.goal, LineGoal):
        lines = follow_lines(world, query, query.goal, deadline)
        return at_end_of(lines), lines
    return find_goals(world, query, np.random.default_rng(seed), deadline), ()
