"""SearchStatistics: counters, log and best path over the attempts of a search."""

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from planning.domain.arrays import Array
from planning.domain.planner.planner_graph import PlannerGraph
from planning.domain.report.best_path import BestPath
from planning.domain.report.search_report import AttemptReport, RoadmapReport
from planning.search.ompl.run_planner import Attempt
from planning.search.query import Query
from planning.search.verified_path import VerificationTrial, VerifiedPath

_MAX_LOGGED_ATTEMPTS = 100


@dataclass
class SearchStatistics:
    """Counters, log and best path over all attempts so far.

    Attributes:
        on_best: Callback with every path that is the best so far.
        straight_line: A free straight line, if there is one.
        best: The best path.
        best_planner: Name of the planner of the best path, or "".
        last_attempt: The planner's result in the last attempt.
        graph: Graph of the planner of the best path.
        nearest_approximation: The configuration nearest to a goal that an attempt reached.
        log: One report per attempt.
        num_attempts: Attempts that were begun.
        num_solved: Attempts with a path.
        num_motions: Edges that planners checked.
        num_given_up: Attempts that gave up after the allowed number of checked states.
        was_canceled: Whether a cancel ended the search.
        roadmap: Report of the roadmap query before any planner, or None.
        shortest_reported: Least length reported so far of paths that planners were still improving.
    """

    on_best: Callable[[BestPath], None] | None
    straight_line: VerifiedPath | None
    best: VerifiedPath | None = None
    best_planner: str = ""
    last_attempt: Attempt | None = None
    graph: PlannerGraph | None = None
    nearest_approximation: dict[str, Any] | None = None
    log: list[AttemptReport] = field(default_factory=list)
    num_attempts: int = 0
    num_solved: int = 0
    num_motions: int = 0
    num_given_up: int = 0
    was_canceled: bool = False
    roadmap: RoadmapReport | None = None
    shortest_reported: float = math.inf

    def __post_init__(self) -> None:
        """Use the straight line, if there is one, as the best path so far."""
        self.best = self.straight_line

    def evidence(self, query: Query) -> dict[str, Any]:
        """Return the evidence of a failure, as plain values."""
        options = query.options
        evidence: dict[str, Any] = {
            "planner": ", ".join(options.planners),
            "attempts": self.num_attempts,
            "num_goals": len(query.goals),
            "num_states_checked": query.oracle.num_states,
        }
        if self.last_attempt is not None:
            evidence |= {"status": self.last_attempt.status, **self.last_attempt.failure_evidence}
        if self.num_given_up:
            evidence["num_given_up"] = self.num_given_up
        if options.approximate:
            evidence["approximate"] = self.nearest_approximation
        if self.roadmap is not None:
            evidence["roadmap"] = dataclasses.asdict(self.roadmap)
        return evidence

    def record_failure_evidence(self, evidence: dict[str, Any]) -> None:
        """Keep the nearest configuration to a goal that a planner without a solution reached."""
        approximation = evidence.get("approximate")
        if approximation is None:
            return
        if (
            self.nearest_approximation is None
            or approximation["goal_distance"] < self.nearest_approximation["goal_distance"]
        ):
            self.nearest_approximation = approximation

    def report_improvement(
        self, report: Callable[[BestPath], None], planner: str, length: float, waypoints: Array
    ) -> None:
        """Report a path that a planner still improves, if it is the best so far."""
        shortest = (
            self.shortest_reported
            if self.best is None
            else min(self.shortest_reported, self.best.length)
        )
        if length < shortest:
            self.shortest_reported = length
            attempt = AttemptReport(planner, "improving", length, length, length, 0)
            report(BestPath(attempt, waypoints))

    def record(self, planner: str, trial: VerificationTrial, num_states: int) -> None:
        """Record an attempt that ended."""
        path = trial.path
        self.last_attempt = trial.attempt
        self.num_motions += trial.num_motions
        self.num_given_up += trial.attempt.has_given_up
        self.record_failure_evidence(dict(trial.attempt.failure_evidence))
        report = _report(planner, trial, num_states)
        if len(self.log) < _MAX_LOGGED_ATTEMPTS:
            self.log.append(report)
        if path is None:
            return
        self.num_solved += 1
        if self.best is None or path.cost < self.best.cost:
            self.best, self.best_planner, self.graph = path, planner, trial.attempt.graph
            if self.on_best is not None:
                self.on_best(BestPath(report, path.waypoints))


def _report(planner: str, trial: VerificationTrial, num_states: int) -> AttemptReport:
    path = trial.path
    if path is None:
        outcome = "collides" if len(trial.attempt.waypoints) else trial.attempt.status
        return AttemptReport(planner, outcome, 0.0, 0.0, 0.0, num_states)
    return AttemptReport(planner, "solved", path.raw_length, path.length, path.cost, num_states)
