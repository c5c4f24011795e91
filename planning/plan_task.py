"""PlanTask: what every step of a plan needs."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

from planning.domain.deadline import Deadline
from planning.domain.goal_configurations import GoalConfigurations
from planning.domain.joints import JointGroup, JointLimits
from planning.domain.line import Leg
from planning.domain.plan import Progress
from planning.domain.pool import AttemptPool
from planning.domain.problem import PlanningProblem
from planning.domain.roadmap import Roadmap
from planning.domain.search_report import AttemptReport
from planning.retime.path_limit import PathLimit
from planning.retime.path_limits import path_limits
from planning.stopwatch import Stopwatch
from planning.world.margins import PairMargins
from planning.world.rules.path_rules import PathRules
from planning.world.world import Array, World

# How far a plan is that searches, of the whole.
SEARCHING = 0.15


@dataclass(frozen=True)
class PlanTask:
    """What every step needs.

    Attributes:
        world: The scene.
        problem: As it was given.
        group: Whose joints move.
        limits: Theirs, tightened by the path constraints.
        margins: Distances to keep.
        start: Inside its limits, shape (nq,).
        goals: Where the motion may end.
        lines: What leads to the only goal, if lines are the goal.
        deadline: Of the whole plan.
        report: Told of every step.
        watch: Adds up the time of every stage.
        rules: The path constraints, or None.
        roadmap: Where the search looks before it asks a planner, or None.
        pool: Makes attempts of the search at once, or None.
    """

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
    roadmap: Roadmap | None = None
    pool: AttemptPool | None = None

    @cached_property
    def path_limits(self) -> tuple[PathLimit, ...]:
        """What limits motions besides their joints, built once for all that are timed."""
        return path_limits(self.world, self.group, self.problem.retime)

    def tell_best(self, attempt: AttemptReport) -> None:
        """Report the best path so far."""
        detail = f"{attempt.planner} found a path of length {attempt.length:.3f}, the best so far"
        self.report(Progress("search", SEARCHING, detail, attempt.length))
