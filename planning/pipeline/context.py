"""PlanContext: what every step of a plan needs; StageProgress: tells which step is at work."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

from planning.domain.goals.goal_configurations import GoalConfigurations
from planning.domain.goals.line import LinearMove
from planning.domain.planner.roadmap import Roadmap
from planning.domain.report.motion_plan import Progress
from planning.domain.report.search_report import AttemptReport
from planning.domain.request.attempt_pool import AttemptPool
from planning.domain.request.deadline import Deadline
from planning.domain.request.problem import PlanningProblem
from planning.domain.request.stopwatch import Stopwatch
from planning.domain.robot.joints import JointGroup, JointLimits
from planning.retime.limits.path_limit import PathLimit
from planning.retime.limits.request_limits import path_limits
from planning.world.collision.margins import PairMargins
from planning.world.constraints.path_constraints import PathConstraints
from planning.world.world import Array, World

# How far a plan is that searches, of the whole.
SEARCHING = 0.15
# And in stages that say no more of themselves than that they begin.
_FRACTIONS = {"refine": 0.5, "retime": 0.6, "certify": 0.8, "explain": 0.95}


class StageProgress:
    """Passes progress on, and tells of stages that begin without a word."""

    def __init__(self, on_progress: Callable[[Progress], None]) -> None:
        """Pass it on to `on_progress`."""
        self._on_progress = on_progress
        self._stage = ""

    def __call__(self, progress: Progress) -> None:
        """Pass progress on."""
        self._stage = progress.stage
        self._on_progress(progress)

    def begin(self, stage: str) -> None:
        """Tell of a stage that begins, if that was not told already."""
        if stage != self._stage:
            self(Progress(stage, _FRACTIONS.get(stage, SEARCHING)))


@dataclass(frozen=True)
class PlanContext:
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
    lines: tuple[LinearMove, ...]
    deadline: Deadline
    report: Callable[[Progress], None]
    watch: Stopwatch
    rules: PathConstraints | None
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
