"""AttemptSchedule: the attempts of a round, by number; who makes them, and where, changes nothing.

Each has its planner and its seed, and none knows of another. So they may be made in any order, here
or by a pool in other processes: they are noted in the order of their numbers. Handing out work
takes time as well, so the first one is made here, and only what takes long is handed out.
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

# If an attempt takes less, the others are made here too [s].
_WORTH_IT = 0.03


@dataclass(frozen=True, eq=False)
class AttemptResult(Value):
    """An attempt, and what it took.

    Attributes:
        planner: OMPL's name.
        trial: What came of it.
        num_states: Configurations that were checked.
        num_fine: Edges that were checked finely.
        seconds: How long it took.
        parts: How long its parts took, if it was made elsewhere.
        was_cut: Whether a deadline cut it there.
    """

    planner: str
    trial: VerificationTrial
    num_states: int
    num_fine: int
    seconds: float
    parts: Mapping[str, float] = field(default_factory=dict)
    was_cut: bool = False


class AttemptSchedule:
    """The attempts of one round."""

    def __init__(
        self,
        query: Query,
        closeness: CheckResolution,
        seeds: list[np.random.SeedSequence],
        tally: SearchStatistics,
    ) -> None:
        """Plan an attempt for every seed, the planners in turn."""
        self._query = query
        self._closeness = closeness
        self._seeds = seeds
        self._tally = tally
        self._elsewhere: dict[int, AttemptResult | WayproofError] = {}
        self._next = 0

    def play(self, pool: AttemptPool | None) -> None:
        """Make all attempts and note them in the tally, what the pool does not do here.

        Raises:
            Canceled: Somebody asked for the end; what was made by then is noted.
            DeadlineExceeded: The time has run out; the same.
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
        """Let the pool make those that are left."""
        first = self._next
        count = len(self._seeds) - first

        def make(piece: int) -> AttemptResult:
            return self._make_elsewhere(first + piece)

        with closing(pool.each(make, count, self._query.deadline)) as arrivals:
            for piece, outcome in arrivals:
                self._elsewhere[first + piece] = outcome
                self._advance()

    def _advance(self) -> None:
        """Note the next attempts as far as they were made elsewhere."""
        while self._next in self._elsewhere:
            outcome = self._elsewhere.pop(self._next)
            self._next += 1
            self._note(outcome)

    def _make_next(self) -> float:
        """Make the next attempt here, note it, and return how long it took [s]."""
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
        """Return an attempt made in another process: a cancel is for the first one to see."""
        cuts: list[int] = []
        deadline = self._query.deadline.uncancelable.cutting(lambda: cuts.append(k))
        watch = Stopwatch(deadline.clock)
        query = replace(self._query, deadline=deadline, on_better=None, watch=watch)
        with query.oracle.until(query.deadline):
            made = self._made(k, query)
        return replace(made, parts=watch.parts, was_cut=bool(cuts))

    def _note(self, outcome: AttemptResult | WayproofError) -> None:
        """Note an attempt that was made elsewhere.

        Raises:
            WayproofError: It ended by one.
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
