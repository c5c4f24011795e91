"""PlanContext: checked and resolved input of the later stages; StageProgress: stage reports."""

from collections.abc import Callable
from dataclasses import dataclass, replace

from planning.domain.arrays import Array
from planning.domain.goals.goal_configurations import GoalConfigurations
from planning.domain.goals.linear_moves import LinearMove
from planning.domain.planner.roadmap import Roadmap
from planning.domain.report.best_path import BestPath
from planning.domain.report.motion_plan import Progress, ignore_progress
from planning.domain.request.attempt_pool import AttemptPool
from planning.domain.request.deadline import Deadline
from planning.domain.request.problem import PlanningProblem
from planning.domain.request.stopwatch import Stopwatch
from planning.domain.robot.joints import JointGroup, JointLimits
from planning.pipeline.candidate_motions import refine_and_proof_deadlines
from planning.retime.limits.path_limit import PathLimit
from planning.world.collision.margins import PairMargins
from planning.world.constraints.path_constraints import PathConstraints
from planning.world.world import World

# Progress at the beginning of the search, as a share of the whole plan.
SEARCH_FRACTION = 0.15
# Progress at the beginning of other stages, for those that report nothing else.
_STAGE_FRACTIONS = {"refine": 0.5, "retime": 0.6, "certify": 0.8, "explain": 0.95}
# Progress at the end of every stage: where the one after it begins, at the earliest.
_STAGE_ENDS = {
    "goals": 0.1,
    "roadmap": SEARCH_FRACTION,
    "search": 0.5,
    "refine": 0.6,
    "retime": 0.8,
    "certify": 0.95,
    "explain": 0.97,
}


class StageProgress:
    """Forwards progress, and reports the beginning of stages that do not report it themselves.

    The fractions never decrease: a search that begins again after a refused motion has the progress
    that the plan had reached.
    """

    def __init__(self, on_progress: Callable[[Progress], None]) -> None:
        """Forward progress to `on_progress`."""
        self._on_progress = on_progress
        self._stage = ""
        self._fraction = 0.0

    def __call__(self, progress: Progress) -> None:
        """Forward progress, with the end of its stage."""
        if self._on_progress is ignore_progress:
            return
        self._stage = progress.stage
        self._fraction = max(self._fraction, progress.fraction)
        until = max(self._fraction, _STAGE_ENDS.get(progress.stage, 0.0))
        self._on_progress(replace(progress, fraction=self._fraction, until=until))

    def begin(self, stage: str) -> None:
        """Report that a stage begins, unless it reported progress already."""
        if stage != self._stage:
            self(Progress(stage, _STAGE_FRACTIONS.get(stage, SEARCH_FRACTION)))


@dataclass(frozen=True, kw_only=True)
class PlanContext:
    """Checked problem with all defaults filled in, and with its goal configurations.

    Attributes:
        world: Loaded scene.
        problem: The given problem with resolved timing options.
        group: Joint group that moves.
        limits: Limits of the group's joints, tightened by the path constraints.
        margins: Required distance of every body pair [m].
        start: Start configuration within its limits, shape (nq,).
        start_clipped: Change of the given start by clipping, shape (nq,).
        goals: Goal configurations.
        lines: Linear moves to the only goal configuration of a line goal; else empty.
        path_limits: Limits on motions besides those of joints, compiled once for all retimings.
        deadline: Deadline of the whole plan.
        report_progress: Callback for the progress.
        watch: Stopwatch of the stages.
        constraints: Compiled path constraints; None for none.
        roadmap: Roadmap that is queried before any planner; None for none.
        pool: Pool of processes for concurrent search attempts; None for none.
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
        """Deadline of refinement and explanation; a cancellation always ends them."""
        return refine_and_proof_deadlines(self.problem, self.deadline)[0]

    @property
    def proof_deadline(self) -> Deadline:
        """Deadline of retiming and certification; not canceled if the best so far is requested."""
        return refine_and_proof_deadlines(self.problem, self.deadline)[1]

    def report_best(self, best: BestPath) -> None:
        """Report the best path so far as progress."""
        attempt = best.attempt
        detail = f"{attempt.planner} found a path of length {attempt.length:.3f}, the best so far"
        self.report_progress(Progress("search", SEARCH_FRACTION, detail, best))
