"""TerminationCondition: end of a running planner, by counts of work rather than by the clock.

Planners that only look for a path end with it. Planners that improve it (RRTstar and similar ones,
BITstar, AORRTC, PRMstar) would use up any time, and their result would depend on the speed of the
machine. They may do as much work again as their first solution took, and no less than a fixed
minimum; work is counted in checked states and in evaluations of this condition. The deadline still
ends all.

OMPL returns a solution when the planner ends, and not if an exception ends it. So from the first
solution on, the oracle keeps answering after the deadline until the planner evaluates this
condition and ends.
"""

import math
from collections.abc import Callable
from typing import Any

from planning.domain.request.deadline import Deadline
from planning.search.collision_oracle import WatchedOracle

_LEAST_STATES = 4_000
_LEAST_QUESTIONS = 20_000
# Evaluations of this condition allowed per allowed state.
_QUESTIONS_PER_STATE = 10
# Share of the remaining time that may go into improving the first solution.
_IMPROVING_SHARE = 0.7
# Least interval between two reports of a better solution [s].
_QUIET = 0.25


class TerminationCondition:
    """OMPL's termination condition; the deadline ends all planners.

    Attributes:
        questions: Number of evaluations by the planner.
        is_spent: Whether the planner was ended after the allowed number of checked states.
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
        """Observe a planner's best cost, if it has one, and the oracle's counter.

        Args:
            planner: OMPL's planner.
            oracle: Collision oracle of the planner.
            deadline: End of the planner.
            patience: Deadline of the oracle for a planner that has a solution.
            most_states: States that it may check until it has a solution.
            on_better: Callback with the best cost, at intervals, once there is one.
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
        """Return whether the planner is to end."""
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
        """Release the planner, which may keep this condition: a reference cycle otherwise."""
        self._best_cost = None

    def note_solution(self) -> None:
        """Set the amount of work that may still be spent on improving the first solution.

        If less time than that remains, a share of it is kept for the processing of the solution.
        """
        self._deadline = self._deadline.share(_IMPROVING_SHARE)
        spent = self._oracle.num_states - self._states_before
        self._last_states = self._oracle.num_states + max(spent, _LEAST_STATES)
        self._last_questions = self.questions + max(self.questions, _LEAST_QUESTIONS)

    def keep_solution(self) -> None:
        """Extend the oracle's deadline, so that no exception ends a planner that has a solution."""
        self._oracle.heed(self._patience)

    def _tell_better(self, cost: float, tell: Callable[[float], None]) -> None:
        if cost < self._told and self._deadline.clock() >= self._next_told:
            self._told, self._next_told = cost, self._deadline.clock() + _QUIET
            tell(cost)

    def _has_spent_all(self) -> bool:
        has_checked = self._oracle.num_states >= self._most_states
        return has_checked or self.questions >= self._most_questions
