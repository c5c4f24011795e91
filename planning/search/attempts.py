"""AttemptSchedule: planning attempts of one round, run here or in other processes, same result.

Each attempt has its own planner and seed and is independent of the others. So attempts may run in
any order, in this process or in a pool of others; their results are recorded in the order of their
numbers. The pool has a cost too, so attempts run in this process until one takes long; only then
the rest go to the pool.
"""

from collections.abc import Mapping
from contextlib import closing
from dataclasses import dataclass, field, replace

import numpy as np

from planning.domain.request.attempt_pool import AttemptPool
from planning.domain.request.stopwatch import Stopwatch
from planning.domain.value import Value
from planning.errors import Canceled, DeadlineExceeded, WayproofError
from planning.search.ompl.planner_list import own_parameters
from planning.search.query import Query
from planning.search.statistics import SearchStatistics
from planning.search.verified_path import CheckResolution, VerificationTrial, verified_attempt

# If an attempt takes less than this, the next one runs in this process too [s].
_MIN_POOL_SECONDS = 0.03


@dataclass(frozen=True, eq=False)
class AttemptResult(Value):
    """Result of one attempt, with its cost in time and checks.

    Attributes:
        planner: OMPL's name of the planner.
        trial: The verified path, or the reason why there is none.
        num_states: Configurations that were checked.
        num_fine_edges: Edges that were checked at the fine resolution.
        seconds: Duration of the attempt [s].
        stage_seconds: Durations of its stages [s] by name, if it ran in another process.
        was_cut: Whether a deadline cut it short in that process.
    """

    planner: str
    trial: VerificationTrial
    num_states: int
    num_fine_edges: int
    seconds: float
    stage_seconds: Mapping[str, float] = field(default_factory=dict)
    was_cut: bool = False


class AttemptSchedule:
    """Attempts of one round, in the order of their numbers."""

    def __init__(
        self,
        query: Query,
        resolution: CheckResolution,
        seeds: list[np.random.SeedSequence],
        statistics: SearchStatistics,
    ) -> None:
        """Plan one attempt for every seed; planners take turns."""
        self._query = query
        self._resolution = resolution
        self._seeds = seeds
        self._statistics = statistics
        self._pool_results: dict[int, AttemptResult | WayproofError] = {}
        self._next_index = 0

    def run_all(self, pool: AttemptPool | None) -> None:
        """Run all attempts, in the pool or here, and record them in the search statistics.

        Raises:
            Canceled: The request was canceled; attempts that ended before that are recorded.
            DeadlineExceeded: The time has run out; attempts that ended before that are recorded.
        """
        try:
            while self._next_index < len(self._seeds):
                if self._next_index in self._pool_results:
                    self._record_next()
                elif self._run_next() >= _MIN_POOL_SECONDS and pool is not None:
                    self._run_in_pool(pool)
                    pool = None
        except (Canceled, DeadlineExceeded):
            for _, outcome in sorted(self._pool_results.items()):
                if isinstance(outcome, AttemptResult):
                    self._record(outcome)
            raise

    def _run_in_pool(self, pool: AttemptPool) -> None:
        """Run the remaining attempts in the pool."""
        first = self._next_index
        count = len(self._seeds) - first

        def run_task(index: int) -> AttemptResult:
            return self._run_in_child(first + index)

        with closing(pool.each(run_task, count, self._query.deadline)) as results:
            for index, outcome in results:
                self._pool_results[first + index] = outcome
                self._record_next()

    def _record_next(self) -> None:
        """Record the next attempts whose results have come from the pool."""
        while self._next_index in self._pool_results:
            outcome = self._pool_results.pop(self._next_index)
            self._next_index += 1
            self._record(outcome)

    def _run_next(self) -> float:
        """Run the next attempt here, record it, and return its duration [s]."""
        statistics, query, k = self._statistics, self._query, self._next_index
        self._next_index += 1
        statistics.num_attempts += 1
        if len(self._seeds) == 1:
            result = self._run(k, query)
        else:
            with query.watch.measure(f"attempt_{statistics.num_attempts}"):
                result = self._run(k, query)
        statistics.record(result.planner, result.trial, result.num_states)
        return result.seconds

    def _run_in_child(self, k: int) -> AttemptResult:
        """Return an attempt made in another process, which only the deadline ends, not a cancel."""
        cuts: list[int] = []
        deadline = self._query.deadline.uncancelable.with_on_expiry(lambda: cuts.append(k))
        watch = Stopwatch(deadline.clock)
        query = replace(self._query, deadline=deadline, on_improvement=None, watch=watch)
        with query.oracle.with_deadline(query.deadline):
            result = self._run(k, query)
        return replace(result, stage_seconds=watch.seconds_by_name, was_cut=bool(cuts))

    def _record(self, outcome: AttemptResult | WayproofError) -> None:
        """Record an attempt that ran in another process.

        Raises:
            WayproofError: The attempt ended with this error.
        """
        statistics, query = self._statistics, self._query
        statistics.num_attempts += 1
        if isinstance(outcome, DeadlineExceeded) or (
            isinstance(outcome, AttemptResult) and outcome.was_cut
        ):
            query.deadline.on_expiry()
        if isinstance(outcome, WayproofError):
            raise outcome
        query.watch.add(f"attempt_{statistics.num_attempts}", outcome.seconds)
        for name, seconds in outcome.stage_seconds.items():
            query.watch.add(name, seconds)
        query.oracle.num_states += outcome.num_states
        self._resolution.fine.num_motions += outcome.num_fine_edges
        statistics.record(outcome.planner, outcome.trial, outcome.num_states)

    def _run(self, k: int, query: Query) -> AttemptResult:
        names = query.options.planners
        name, attempt_query = names[k % len(names)], query
        if len(names) > 1:
            parameters = own_parameters(name, query.parameters)
            attempt_query = replace(query, planner=name, parameters=parameters)
        clock, fine = query.deadline.clock, self._resolution.fine
        began, states, edges = clock(), query.oracle.num_states, fine.num_motions
        trial = verified_attempt(attempt_query, self._resolution, self._seeds[k])
        return AttemptResult(
            planner=name,
            trial=trial,
            num_states=query.oracle.num_states - states,
            num_fine_edges=fine.num_motions - edges,
            seconds=clock() - began,
        )
