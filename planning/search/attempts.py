"""AttemptSchedule: planning attempts of one round, run here or in other processes, same result.

Each attempt has its own planner and seed and is independent of the others. So attempts may run in
any order, in this process or in a pool of others; their results are recorded in the order of their
numbers. To use the pool takes time too, so attempts run here until one takes long; only then the
rest go to the pool.
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
_WORTH_IT = 0.03


@dataclass(frozen=True, eq=False)
class AttemptResult(Value):
    """Result of one attempt, with its cost in time and checks.

    Attributes:
        planner: OMPL's name of the planner.
        trial: The verified path, or the reason why there is none.
        num_states: Configurations that were checked.
        num_fine: Edges that were checked at the fine resolution.
        seconds: Duration of the attempt [s].
        parts: Durations of its stages [s] by name, if it ran in another process.
        was_cut: Whether a deadline cut it short in that process.
    """

    planner: str
    trial: VerificationTrial
    num_states: int
    num_fine: int
    seconds: float
    parts: Mapping[str, float] = field(default_factory=dict)
    was_cut: bool = False


class AttemptSchedule:
    """Attempts of one round, in the order of their numbers."""

    def __init__(
        self,
        query: Query,
        closeness: CheckResolution,
        seeds: list[np.random.SeedSequence],
        tally: SearchStatistics,
    ) -> None:
        """Plan one attempt for every seed; planners take turns."""
        self._query = query
        self._closeness = closeness
        self._seeds = seeds
        self._tally = tally
        self._elsewhere: dict[int, AttemptResult | WayproofError] = {}
        self._next = 0

    def play(self, pool: AttemptPool | None) -> None:
        """Run all attempts, in the pool or here, and record them in the search statistics.

        Raises:
            Canceled: The request was canceled; attempts that ended before that are recorded.
            DeadlineExceeded: The time has run out; attempts that ended before that are recorded.
        """
        try:
            while self._next < len(self._seeds):
                if self._next in self._elsewhere:
                    self._advance()
                elif self._make_next() >= _WORTH_IT and pool is not None:
                    self._send(pool)
                    pool = None
        except (Canceled, DeadlineExceeded):
            for _, outcome in sorted(self._elsewhere.items()):
                if isinstance(outcome, AttemptResult):
                    self._note(outcome)
            raise

    def _send(self, pool: AttemptPool) -> None:
        """Run the remaining attempts in the pool."""
        first = self._next
        count = len(self._seeds) - first

        def make(piece: int) -> AttemptResult:
            return self._make_elsewhere(first + piece)

        with closing(pool.each(make, count, self._query.deadline)) as arrivals:
            for piece, outcome in arrivals:
                self._elsewhere[first + piece] = outcome
                self._advance()

    def _advance(self) -> None:
        """Record the next attempts whose results have come from the pool."""
        while self._next in self._elsewhere:
            outcome = self._elsewhere.pop(self._next)
            self._next += 1
            self._note(outcome)

    def _make_next(self) -> float:
        """Run the next attempt here, record it, and return its duration [s]."""
        tally, query, k = self._tally, self._query, self._next
        self._next += 1
        tally.num_attempts += 1
        if len(self._seeds) == 1:
            made = self._made(k, query)
        else:
            with query.watch.note(f"attempt_{tally.num_attempts}"):
                made = self._made(k, query)
        tally.note(made.planner, made.trial, made.num_states)
        return made.seconds

    def _make_elsewhere(self, k: int) -> AttemptResult:
        """Return an attempt made in another process, which only the deadline ends, not a cancel."""
        cuts: list[int] = []
        deadline = self._query.deadline.uncancelable.cutting(lambda: cuts.append(k))
        watch = Stopwatch(deadline.clock)
        query = replace(self._query, deadline=deadline, on_better=None, watch=watch)
        with query.oracle.until(query.deadline):
            made = self._made(k, query)
        return replace(made, parts=watch.parts, was_cut=bool(cuts))

    def _note(self, outcome: AttemptResult | WayproofError) -> None:
        """Record an attempt that ran in another process.

        Raises:
            WayproofError: The attempt ended with this error.
        """
        tally, query = self._tally, self._query
        tally.num_attempts += 1
        if isinstance(outcome, DeadlineExceeded) or (
            isinstance(outcome, AttemptResult) and outcome.was_cut
        ):
            query.deadline.on_cut()
        if isinstance(outcome, WayproofError):
            raise outcome
        query.watch.add(f"attempt_{tally.num_attempts}", outcome.seconds)
        for name, seconds in outcome.parts.items():
            query.watch.add(name, seconds)
        query.oracle.num_states += outcome.num_states
        self._closeness.fine.num_motions += outcome.num_fine
        tally.note(outcome.planner, outcome.trial, outcome.num_states)

    def _made(self, k: int, query: Query) -> AttemptResult:
        names = query.options.planners
        name, parameters = names[k % len(names)], query.parameters
        if len(names) > 1:
            parameters = own_parameters(name, parameters)
        clock, fine = query.deadline.clock, self._closeness.fine
        began, states, edges = clock(), query.oracle.num_states, fine.num_motions
        own = replace(query, planner=name, parameters=parameters)
        trial = verified_attempt(own, self._closeness, self._seeds[k])
        return AttemptResult(
            planner=name,
            trial=trial,
            num_states=query.oracle.num_states - states,
            num_fine=fine.num_motions - edges,
            seconds=clock() - began,
        )
