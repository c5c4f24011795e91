"""plan(): the stages in order. Read this first.

    scene -> goals (batched IK, lines) -> search (OMPL) -> refine (sequential convex programs)
          -> retime (toppra or ruckig) -> certify (Drake, fresh context) -> MotionPlan

The stages do not know each other. What a stage cannot do better it leaves alone: several candidate
motions are timed, the quickest one that the certifier proves is delivered, and if none is proven
the search is asked again, for more distance and with a finer eye. Straight lines (`parts`) belong
to the goals: what the search finds leads to where they begin.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from planning.candidates import candidates, deadlines
from planning.certify.certifier import CertifyRequest, certify
from planning.certify.refusal import not_certified
from planning.clearances import clearances
from planning.domain.certificate import Certificate
from planning.domain.deadline import Deadline
from planning.domain.goal import LineGoal
from planning.domain.joints import JointGroup, JointLimits
from planning.domain.line import Leg
from planning.domain.plan import MotionPlan, Progress, StageReports
from planning.domain.planner_graph import PlannerGraph
from planning.domain.problem import PlanningProblem
from planning.domain.report import (
    AttemptReport,
    CertifyReport,
    GoalConfigurations,
    RefineReport,
    SearchReport,
)
from planning.errors import DeadlineExceeded, NoPathFound, ProblemInvalid
from planning.goals.line_goal import follow_lines
from planning.goals.sampler import GoalQuery, find_goals
from planning.goals.start import admit_start
from planning.paddings import endpoint_padding
from planning.parts import (
    NOT_REFINED,
    Motion,
    at_end_of,
    ends_of,
    free_part,
    freely_timed,
    named_legs,
    named_lines,
    no_search,
    timed_legs,
    tool_of,
)
from planning.ruled import admit_rules, kept_goals, search_ruled
from planning.search.solver import SearchResult, SearchTask, search
from planning.stopwatch import Stopwatch
from planning.world.margins import PairMargins
from planning.world.positions import require_positions
from planning.world.rules.path_rules import PathRules
from planning.world.world import Array, World

# How often the search is asked again, each time with half the resolution, before we give up.
_MAX_ROUNDS = 4
# Share of the time for a search that keeps more distance than is demanded.
_PADDED_SHARE = 0.6
# How far a plan is that searches, of the whole.
_SEARCHING = 0.15


def ignore_progress(_: Progress) -> None:
    """Do nothing with it."""


@dataclass(frozen=True)
class _Task:
    """What every step needs."""

    world: World
    problem: PlanningProblem
    group: JointGroup
    limits: JointLimits
    margins: PairMargins
    start: Array
    goals: GoalConfigurations
    lines: tuple[Leg, ...]
    deadline: Deadline
    report: Callable[[Progress], None]
    watch: Stopwatch
    rules: PathRules | None

    def tell_best(self, attempt: AttemptReport) -> None:
        """Report the best path so far."""
        detail = f"{attempt.planner} found a path of length {attempt.length:.3f}, the best so far"
        self.report(Progress("search", _SEARCHING, detail, attempt.length))


@dataclass(frozen=True)
class _Proven:
    """A motion that is certified, and what was done for it."""

    goal_row: int
    motion: Motion
    search: SearchReport
    refine: RefineReport
    certificate: Certificate
    certify: CertifyReport
    graph: PlannerGraph | None = None


def plan(
    problem: PlanningProblem,
    world: World,
    *,
    deadline: Deadline,
    on_progress: Callable[[Progress], None] = ignore_progress,
) -> MotionPlan:
    """Plan a certified motion.

    The same problem in the same scene gives the same bytes, as long as the deadline cuts nothing.

    Args:
        problem: Group, start, goal, options, seed.
        world: The scene, loaded.
        deadline: When to give up; also asked whether anybody still wants the answer.
        on_progress: Told of every stage.

    Raises:
        InputError: The problem names what does not exist, or its numbers do not fit.
        PlanningFailure: There is no motion to give; code, stage and evidence say why.
    """
    watch = Stopwatch(deadline.clock)
    group = world.group(problem.group)
    given = world.positions(group) if problem.start is None else problem.start
    given = require_positions(group, given, "start")
    margins = world.margins(problem.margin)
    if problem.search.allowed_planning_time <= 0:
        message = "search.allowed_planning_time must be positive"
        raise ProblemInvalid(message, {"field": "search.allowed_planning_time"})
    on_progress(Progress("goals", 0.02, "looking for goal configurations"))
    with watch.stage("goals"):
        start, clipped = admit_start(world, group, given, margins)
        rules = admit_rules(world, group, problem.constraints, start)
        query = GoalQuery(group, problem.goal, start, margins, problem.ik)
        goals, lines = _goals(world, query, problem.seed, deadline.share(0.5))
        if rules is not None:
            goals = kept_goals(rules, goals)
            rules = rules.leaving_room(start, goals.entries)
    limits = world.limits(group) if rules is None else rules.limits(world.limits(group))
    task = _Task(
        world,
        problem,
        group,
        limits,
        margins,
        start,
        goals,
        lines,
        deadline,
        on_progress,
        watch,
        rules,
    )
    proven = _prove_lines(task) if lines else _prove_one(task)
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
        graph=proven.graph,
        parts=motion.described(world, tool_of(group, problem.goal)),
    )


def _goals(
    world: World, query: GoalQuery, seed: int, deadline: Deadline
) -> tuple[GoalConfigurations, tuple[Leg, ...]]:
    """Return goal configurations, and the lines that lead to the only one if lines are the goal."""
    if isinstance(query.goal, LineGoal):
        lines = follow_lines(world, query, query.goal, deadline)
        return at_end_of(lines), lines
    return find_goals(world, query, np.random.default_rng(seed), deadline), ()


def _prove_lines(task: _Task) -> _Proven:
    """Time and certify lines; there is nothing to search."""
    task.report(Progress("retime", 0.5, "timing the lines"))
    with task.watch.stage("retime"):
        motion = Motion(
            timed_legs(task.world, task.group, named_lines(task.lines), task.problem, task.start)
        ).lasting(task.problem.retime)
    task.report(Progress("certify", 0.8, "certifying the lines"))
    with task.watch.stage("certify"):
        certificate, report = _certify(task, motion)
    if not certificate.proven:
        raise not_certified(certificate, ["the lines themselves"])
    return _Proven(0, motion, no_search(motion.path), NOT_REFINED, certificate, report)


def _prove_one(task: _Task) -> _Proven:
    """Search, refine, retime and certify until a motion is proven."""
    refused: list[str] = []
    failed: Certificate | None = None
    for round_ in range(_MAX_ROUNDS):
        if round_ and task.deadline.is_over:
            break
        task.report(Progress("search", _SEARCHING, f"searching, round {round_ + 1}"))
        with task.watch.stage("search"):
            found = _search(task, round_)
        with task.watch.stage("retime"):
            legs = named_legs(task.goals.legs[found.goal_row]) if task.goals.legs else []
            end = found.path.waypoints[-1]
            tail = timed_legs(task.world, task.group, legs, task.problem, end)
        task.report(Progress("refine", 0.5, "refining and timing"))
        problem = freely_timed(task.problem) if tail else task.problem
        for candidate in candidates(
            task.world, found.path, problem, task.margins, task.deadline, task.watch
        ):
            task.report(Progress("certify", 0.8, f"certifying the {candidate.name}"))
            with task.watch.stage("certify"):
                motion = Motion((free_part(found.path, candidate), *tail))
                motion = motion.lasting(task.problem.retime)
                certificate, report = _certify(task, motion)
            if certificate.proven:
                seen = CertifyReport(
                    report.intervals, report.distance_queries, len(refused) + 1, tuple(refused)
                )
                return _Proven(
                    found.goal_row,
                    motion,
                    found.report,
                    candidate.refine,
                    certificate,
                    seen,
                    found.graph,
                )
            failed = certificate
            worst = ", ".join(f"{check.name} {check.where}" for check in certificate.failed)
            refused.append(f"round {round_ + 1}, {candidate.name}: {worst}")
    task.deadline.check("certify")
    raise not_certified(failed, refused)


def _search(task: _Task, round_: int) -> SearchResult:
    """Search with some distance to spare; without, if there is no path that way."""
    padding = endpoint_padding(
        task.world, task.group, task.start, task.goals.entries, task.problem.margin
    )
    if padding * (round_ + 1) > 0:
        try:
            return _search_padded(task, round_, padding, task.deadline.share(_PADDED_SHARE))
        except (NoPathFound, DeadlineExceeded):
            task.deadline.check("search")
    return _search_padded(task, round_, 0.0, task.deadline)


def _search_padded(task: _Task, round_: int, padding: float, deadline: Deadline) -> SearchResult:
    margins = task.world.margins(task.problem.margin, padding)
    oracle = task.world.collision_oracle(task.group, margins)
    entries = task.goals.entries
    rows = np.flatnonzero(oracle.are_free(entries))
    request = SearchTask(
        start=task.start,
        goals=entries[rows],
        options=task.problem.search,
        resolution=task.problem.search.resolution / 2**round_,
        padding=padding,
        seed=task.problem.seed + round_,
        clearances=clearances(task.world, task.group),
        on_best=task.tell_best,
    )
    if task.rules is None:
        found = search(task.group, task.limits, oracle, request, deadline, watch=task.watch)
    else:
        found = search_ruled(task.rules, task.limits, oracle, request, deadline, task.watch)
    return replace(found, path=found.path.continuous, goal_row=int(rows[found.goal_row]))


def _certify(task: _Task, motion: Motion) -> tuple[Certificate, CertifyReport]:
    goal = task.problem.goal
    allowed = (goal.max_shift, goal.max_turn) if isinstance(goal, LineGoal) else ()
    request = CertifyRequest(
        group=task.group,
        trajectory=motion.trajectory,
        state=task.world.state,
        start=task.start,
        goals=ends_of(task.goals),
        limits=task.limits.scaled(
            task.problem.retime.velocity_scale, task.problem.retime.acceleration_scale
        ),
        margins=task.margins,
        jerk=task.problem.retime.method == "ruckig",
        constraints=task.problem.constraints,
        lines=motion.sections(*allowed),
    )
    return certify(task.world.drake, request, deadlines(task.problem, task.deadline)[1])
