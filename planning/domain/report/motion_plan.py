"""MotionPlan: what a solved problem gives, and Progress on the way there."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.curves.curve import TimedTrajectory
from planning.domain.curves.path import JointPath
from planning.domain.goals.goal_configurations import GoalConfigurations
from planning.domain.planner.planner_graph import PlannerGraph
from planning.domain.report.certificate import Certificate
from planning.domain.report.search_report import SearchReport
from planning.domain.report.stage_reports import CertifyReport, RefineReport, RetimeReport
from planning.domain.robot.joints import JointGroup
from planning.domain.value import Value, digest


@dataclass(frozen=True, eq=False)
class StageReports(Value):
    """One report per stage; timings are kept apart because they differ from run to run."""

    goals: GoalConfigurations
    search: SearchReport
    refine: RefineReport
    retime: RetimeReport
    certify: CertifyReport


@dataclass(frozen=True, eq=False)
class PlanPart(Value):
    """A part of a motion, from rest to rest.

    Attributes:
        kind: "free", "approach", "retreat" or "line"; all but the first are straight lines.
        begin: First instant [s].
        end: Last instant [s].
        length: Of the tool's way [m].
        num_waypoints: Of its part of the path, both ends included.
    """

    kind: str
    begin: float
    end: float
    length: float
    num_waypoints: int


@dataclass(frozen=True, eq=False)
class MotionPlan(Value):
    """A certified motion and everything that is known of it.

    Attributes:
        group: What moves.
        start: Where it starts, clipped into the limits, shape (nq,).
        start_clipped: By how much the given start was clipped (at most 1e-6), shape (nq,).
        goal_configuration: Where it reaches the goal, shape (nq,); that is the end, but for a
            retreat.
        goal_index: Which of the goal's candidates that is.
        path: The geometric path that was found.
        trajectory: The timed motion, exactly.
        certificate: The proof.
        stages: What every stage did.
        timings: Seconds per stage; not part of the digest.
        cut_short: Stages that ended early because of the clock, by their names in `timings`; not
            part of the digest. If there are any, the same problem may give other bytes another
            time; if there are none, it gives the same.
        graph: What the planner explored, if it was asked for; not part of the digest.
        parts: The free motion and the straight lines that it is made of, in order.
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
    """How far a plan is.

    Attributes:
        stage: Its name.
        fraction: Of the whole plan, 0 to 1.
        detail: For a person.
        best_length: Of the best path that the search has so far; None where it is no news.
    """

    stage: str
    fraction: float
    detail: str = ""
    best_length: float | None = None


def ignore_progress(_: Progress) -> None:
    """Do nothing with it."""
