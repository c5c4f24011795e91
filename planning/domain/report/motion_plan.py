"""MotionPlan: the result of a solved planning problem, and Progress while it is computed."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.curves.curve import TimedTrajectory
from planning.domain.curves.path import JointPath
from planning.domain.goals.goal_configurations import GoalConfigurations
from planning.domain.planner.planner_graph import PlannerGraph
from planning.domain.report.best_path import BestPath
from planning.domain.report.certificate import Certificate
from planning.domain.report.search_report import SearchReport
from planning.domain.report.stage_reports import CertifyReport, RefineReport, RetimeReport
from planning.domain.robot.joints import JointGroup
from planning.domain.value import Value, digest


@dataclass(frozen=True, eq=False)
class StageReports(Value):
    """Reports of all stages; timings are separate because they differ from run to run."""

    goals: GoalConfigurations
    search: SearchReport
    refine: RefineReport
    retime: RetimeReport
    certify: CertifyReport


@dataclass(frozen=True, eq=False)
class PlanPart(Value):
    """Motion segment of a plan, from rest to rest.

    Attributes:
        kind: "free", "approach", "retreat" or "line"; all but the first are straight lines.
        begin: First instant [s].
        end: Last instant [s].
        length: Length of the tool's path [m].
        num_waypoints: Of its part of the path, both ends included.
    """

    kind: str
    begin: float
    end: float
    length: float
    num_waypoints: int


@dataclass(frozen=True, eq=False)
class MotionPlan(Value):
    """Certified motion with its path, certificate and reports.

    Attributes:
        group: The group that moves.
        start: Start configuration, clipped into the limits, shape (nq,).
        start_clipped: Change of the given start by clipping (at most 1e-6), shape (nq,).
        goal_configuration: Configuration at the goal, shape (nq,); the end of the motion, unless
            a retreat follows.
        goal_index: Index of the goal's candidate that is reached.
        path: The geometric path.
        trajectory: The timed motion, exactly.
        certificate: The proof.
        stages: Report of every stage.
        timings: Seconds per stage; not part of the digest.
        cut_short: Stages that ended early because of the clock, by their names in `timings`; not
            part of the digest. If there are any, the same problem may give other bytes another
            time; if there are none, it gives the same.
        graph: The planner's graph, if it was requested; not part of the digest.
        parts: Its motion segments, the free motion and the linear moves, in order.
    """

    group: JointGroup
    start: Float64[np.ndarray, " nq"]
    start_clipped: Float64[np.ndarray, " nq"]
    goal_configuration: Float64[np.ndarray, " nq"]
    goal_index: int
    path: JointPath
    trajectory: TimedTrajectory
    certificate: Certificate
    stages: StageReports
    timings: dict[str, float]
    cut_short: tuple[str, ...] = ()
    graph: PlannerGraph | None = None
    parts: tuple[PlanPart, ...] = ()

    @property
    def digest(self) -> str:
        """sha256 over the delivered numbers: path, trajectory and certificate."""
        return digest((self.path, self.trajectory, self.certificate, self.goal_index))


@dataclass(frozen=True)
class Progress:
    """Progress of a running plan.

    Attributes:
        stage: Its name.
        fraction: Of the whole plan, 0 to 1.
        detail: For a person.
        best: The search's best path so far; None where it has not changed.
        until: Fraction at which the next stage begins; None if that is not known.
    """

    stage: str
    fraction: float
    detail: str = ""
    best: BestPath | None = None
    until: float | None = None

    @property
    def best_length(self) -> float | None:
        """Length of the search's best path so far; None where it has not changed."""
        return None if self.best is None else self.best.attempt.length


def ignore_progress(_: Progress) -> None:
    """Do nothing."""
