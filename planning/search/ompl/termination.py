"""TerminationCondition: when a running planner shall end, by counts and never by the clock.

Planners that only look for a path end with it. Those that improve it (RRTstar and its kin, BITstar,
AORRTC, PRMstar) would use up any time that they are given, and what they deliver would depend on
how fast the machine is. They get as much work again as their first solution took, and no less than
a fixed least; work is counted in checked states and in questions to this condition.

OMPL hands a solution over when the planner ends, and not if an error ends it. So from the first
solution on, what the planner asks is answered although it is to end, which it hears when it asks
next.
"""

import math
from collections.abc import Callable
from typing import Any

from planning.domain.request.deadline import Deadline
from planning.search.collision_oracle import WatchedOracle

_LEAST_STATES = 4_000
_LEAST_QUESTIONS = 20_000
# A planner that may check so many states may ask so many times as often whether to end.
_QUESTIONS_PER_STATE = 10
# Of the time that is left with the first solution, what improving it may take.
_IMPROVING_SHARE = 0.7
# Between two reports of a better solution [s].
_QUIET = 0.25


class TerminationCondition:
    """OMPL's termination condition; the deadline cuts all.

    Attributes:
        questions: How often the planner asked.
        is_spent: Whether it was ended because it had checked as many states as it may.
    """

    def __init__(
        self,
        planner: Any,
        oracle: WatchedOracle,
        deadline: Deadline,
        patience: Deadline,
        most_states: float = math.inf,
        on_better: Callable[[float], None] | None = None,
    ) -> None:
        """Watch a planner's best cost, if it tells one, and the oracle's counter.

        Args:
            planner: OMPL's.
            oracle: What it asks.
            deadline: Cuts all.
            patience: Until when the oracle answers a planner that has a solution.
            most_states: How many states it may check until it has a solution.
            on_better: Told the best cost, now and then, once there is one.
        """
        self.questions = 0
        self.is_spent = False
        self._most_states = oracle.num_states + most_states
        self._most_questions = _QUESTIONS_PER_STATE * most_states
        self._best_cost = getattr(planner, "bestCost", None)
        self._oracle = oracle
        self._deadline = deadline
        self._patience = patience
        self._on_better = on_better
        self._told, self._next_told = math.inf, -math.inf
        self._states_before = oracle.num_states
        self._last_states = math.inf
        self._last_questions = math.inf

    def __call__(self) -> bool:
        """Return whether to end."""
        self.questions += 1
        if self._deadline.is_over:
            return True
        if math.isinf(self._last_questions) and self._has_spent_all():
            self.is_spent = True
            return True
        if self._best_cost is None:
            return False
        if math.isinf(self._last_questions):
            if math.isfinite(self._best_cost().value()):
                self.note_solution()
                self.keep_solution()
            return False
        if self._on_better is not None:
            self._tell_better(self._best_cost().value(), self._on_better)
        return (
            self._oracle.num_states >= self._last_states or self.questions >= self._last_questions
        )

    def let_go(self) -> None:
        """Forget the planner; one that keeps its condition would else live for ever with it."""
        self._best_cost = None

    def note_solution(self) -> None:
        """Set the amount of work that may still be spent on improving the first solution.

        If there is less time than that, some of it is left for what is done with the solution.
        """
        self._deadline = self._deadline.share(_IMPROVING_SHARE)
        spent = self._oracle.num_states - self._states_before
        self._last_states = self._oracle.num_states + max(spent, _LEAST_STATES)
        self._last_questions = self.questions + max(self.questions, _LEAST_QUESTIONS)

    def keep_solution(self) -> None:
        """Let no error end the planner before it has handed its solution over."""
        self._oracle.heed(self._patience)

    def _tell_better(self, cost: float, tell: Callable[[float], None]) -> None:
        if cost < self._told and self._deadline.clock() >= self._next_told:
            self._told, self._next_told = cost, self._deadline.clock() + _QUIET
            tell(cost)

    def _has_spent_all(self) -> bool:
        has_checked = self._oracle.num_states >= self._most_states
        return has_checked or self.questions >= self._most_questions
