"""SearchStatistics: counters, log and best path over the attempts of a search."""

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from planning.domain.planner.planner_graph import PlannerGraph
from planning.domain.report.search_report import AttemptReport, RoadmapReport
from planning.search.ompl.attempt import Attempt
from planning.search.query import Query
from planning.search.verified_path import VerificationTrial, VerifiedPath

_MOST_LOGGED = 100


@dataclass
class SearchStatistics:
    """Counters, log and best path over all attempts so far.

    Attributes:
        on_best: Callback with every path that is the best so far.
        direct: A free straight line, if there is one.
        best: The best path.
        winner: Name of the planner of the best path, or "".
        last: The planner's result in the last attempt.
        graph: Graph of the planner of the best path.
        approximate: The configuration nearest to a goal that an attempt reached.
        log: One report per attempt.
        num_attempts: Attempts that were begun.
        num_solved: Attempts with a path.
        num_motions: Edges that planners checked.
        num_spent: Attempts that gave up after the allowed number of checked states.
        was_canceled: Whether a cancel ended the search.
        roadmap: Report of the roadmap query before any planner, or None.
        heard: Least length reported so far of paths that planners were still improving.
    """

    on_best: Callable[[AttemptReport], None] | None
    direct: VerifiedPath | None
    best: VerifiedPath | None = None
    winner: str = ""
    last: Attempt | None = None
    graph: PlannerGraph | None = None
    approximate: dict[str, Any] | None = None
    log: list[AttemptReport] = field(default_factory=list)
    num_attempts: int = 0
    num_solved: int = 0
    num_motions: int = 0
    num_spent: int = 0
    was_canceled: bool = False
    roadmap: RoadmapReport | None = None
    heard: float = math.inf

    def __post_init__(self) -> None:
        """Start with the straight line as the best path."""
        self.best = self.direct

    def evidence(self, query: Query) -> dict[str, Any]:
        """Return the evidence of a failure, as plain values."""
        options = query.options
        found: dict[str, Any] = {
            "planner": ", ".join(options.planners),
            "attempts": self.num_attempts,
            "num_goals": len(query.goals),
            "num_states_checked": query.oracle.num_states,
        }
        if self.last is not None:
            found |= {"status": self.last.status, **self.last.growth}
        if self.num_spent:
            found["num_given_up"] = self.num_spent
        if options.approximate:
            found["approximate"] = self.approximate
        if self.roadmap is not None:
            found["roadmap"] = dataclasses.asdict(self.roadmap)
        return found

    def note_growth(self, growth: dict[str, Any]) -> None:
        """Keep the nearest configuration to a goal that a planner without a solution reached."""
        near = growth.get("approximate")
        if near is None:
            return
        if self.approximate is None or near["goal_distance"] < self.approximate["goal_distance"]:
            self.approximate = near

    def hear(self, tell: Callable[[AttemptReport], None], planner: str, length: float) -> None:
        """Report the length of a path that a planner still improves, if it is the best so far."""
        least = self.heard if self.best is None else min(self.heard, self.best.length)
        if length < least:
            self.heard = length
            tell(AttemptReport(planner, "improving", length, length, length, 0))

    def note(self, planner: str, trial: VerificationTrial, num_states: int) -> None:
        """Record an attempt that ended."""
        path = trial.path
        self.last = trial.last
        self.num_motions += trial.num_motions
        self.num_spent += trial.last.is_spent
        self.note_growth(dict(trial.last.growth))
        report = _report(planner, trial, num_states)
        if len(self.log) < _MOST_LOGGED:
            self.log.append(report)
        if path is None:
            return
        self.num_solved += 1
        if self.best is None or path.cost < self.best.cost:
            self.best, self.winner, self.graph = path, planner, trial.last.graph
            if self.on_best is not None:
                self.on_best(report)


def _report(planner: str, trial: VerificationTrial, num_states: int) -> AttemptReport:
    path = trial.path
    if path is None:
        outcome = "collides" if len(trial.last.waypoints) else trial.last.status
        return AttemptReport(planner, outcome, 0.0, 0.0, 0.0, num_states)
    return AttemptReport(planner, "solved", path.raw_length, path.length, path.cost, num_states)
