"""PlanContext: what the stages of a plan work on; StageProgress: which stage is at work."""

from collections.abc import Callable
from dataclasses import dataclass

from planning.domain.goals.goal_configurations import GoalConfigurations
from planning.domain.goals.linear_moves import LinearMove
from planning.domain.planner.roadmap import Roadmap
from planning.domain.report.motion_plan import Progress
from planning.domain.report.search_report import AttemptReport
from planning.domain.request.attempt_pool import AttemptPool
from planning.domain.request.deadline import Deadline
from planning.domain.request.problem import PlanningProblem
from planning.domain.request.stopwatch import Stopwatch
from planning.domain.robot.joints import JointGroup, JointLimits
from planning.pipeline.candidates import refine_and_proof_deadlines
from planning.retime.limits.path_limit import PathLimit
from planning.world.collision.margins import PairMargins
from planning.world.constraints.path_constraints import PathConstraints
from planning.world.world import Array, World

# Progress of a plan that searches, as a share of the whole.
SEARCH_FRACTION = 0.15
# The same in stages that report nothing but that they begin.
_STAGE_FRACTIONS = {"refine": 0.5, "retime": 0.6, "certify": 0.8, "explain": 0.95}


class StageProgress:
    """Passes progress on, and reports stages that begin without a report of their own."""

    def __init__(self, on_progress: Callable[[Progress], None]) -> None:
        """Pass progress on to `on_progress`."""
        self._on_progress = on_progress
        self._stage = ""

    def __call__(self, progress: Progress) -> None:
        """Pass progress on."""
        self._stage = progress.stage
        self._on_progress(progress)

    def begin(self, stage: str) -> None:
        """Report that a stage begins, unless it is at work already."""
        if stage != self._stage:
            self(Progress(stage, _STAGE_FRACTIONS.get(stage, SEARCH_FRACTION)))


@dataclass(frozen=True, kw_only=True)
class PlanContext:
    """A problem whose input is checked, whose defaults are filled in and whose goals are found.

    Attributes:
        world: The scene, loaded.
        problem: As it was given, with its timing options resolved.
        group: Whose joints move.
        limits: Theirs, tightened by the path constraints.
        margins: Distances to keep.
        start: Inside its limits, shape (nq,).
        start_clipped: What was added to the given start to be so, shape (nq,).
        goals: Where the motion may end.
        lines: Lines to the only goal, if lines are the goal; else none.
        path_limits: What limits motions besides their joints, made once for all that are timed.
        deadline: Of the whole plan.
        report_progress: Receives the progress.
        watch: Adds up the time of every stage.
        constraints: The path constraints, or None.
        roadmap: A graph that the search looks into before it runs a planner, or None.
        pool: Makes several attempts of the search at once, or None.
    """

    world: World
    problem: PlanningProblem
    group: JointGroup
    limits: JointLimits
    margins: PairMargins
    start: Array
    start_clipped: Array
    goals: GoalConfigurations
    lines: tuple[LinearMove, ...]
    path_limits: tuple[PathLimit, ...]
    deadline: Deadline
    report_progress: Callable[[Progress], None]
    watch: Stopwatch
    constraints: PathConstraints | None
    roadmap: Roadmap | None = None
    pool: AttemptPool | None = None

    @property
    def refine_deadline(self) -> Deadline:
        """When refinement and explanation end: at a cancel that wants the best so far, too."""
        return refine_and_proof_deadlines(self.problem, self.deadline)[0]

    @property
    def proof_deadline(self) -> Deadline:
        """When timing and certification end: not at a cancel that wants the best so far."""
        return refine_and_proof_deadlines(self.problem, self.deadline)[1]

    def report_best(self, attempt: AttemptReport) -> None:
        """Report the best path so far."""
        detail = f"{attempt.planner} found a path of length {attempt.length:.3f}, the best so far"
        self.report_progress(Progress("search", SEARCH_FRACTION, detail, attempt.length))
