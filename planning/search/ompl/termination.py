"""TerminationCondition: end of a running planner, by counts of work rather than by the clock.

Planners that search for any path end when they have one. Planners that improve it (RRTstar and
similar ones, BITstar, AORRTC, PRMstar) would use up any time, and their result would depend on the
speed of the machine. They may do as much work again as their first solution took, and no less than
a fixed minimum; work is counted in checked states and in evaluations of this condition. The
deadline still ends all.

OMPL returns a solution when the planner ends, and not if an exception ends it. So from the first
solution on, the oracle keeps answering after the deadline until the planner evaluates this
condition and ends.
"""

import math
from collections.abc import Callable
from typing import Any

from planning.domain.request.deadline import Deadline
from planning.search.collision_oracle import WatchedOracle

_MIN_IMPROVEMENT_STATES = 4_000
_MIN_IMPROVEMENT_EVALUATIONS = 20_000
# Evaluations of this condition allowed per allowed state.
_EVALUATIONS_PER_STATE = 10
# Share of the remaining time that may go into improving the first solution.
_IMPROVEMENT_TIME_FRACTION = 0.7
# Least interval between two reports of a better solution [s].
_MIN_REPORT_INTERVAL = 0.25


class TerminationCondition:
    """OMPL's termination condition; the deadline ends all planners.

    Attributes:
        num_evaluations: Number of evaluations by the planner.
        has_given_up: Whether the planner was ended after the allowed number of checked states.
    """

    def __init__(
        self,
        planner: Any,
        oracle: WatchedOracle,
        deadline: Deadline,
        completion_deadline: Deadline,
        max_checked_states: float = math.inf,
        on_improvement: Callable[[float], None] | None = None,
    ) -> None:
        """Observe a planner's best cost, if it has one, and the oracle's counter.

        Args:
            planner: OMPL's planner.
            oracle: Collision oracle of the planner.
            deadline: End of the planner.
            completion_deadline: Deadline of the oracle for a planner that has a solution.
            max_checked_states: States that it may check until it has a solution.
            on_improvement: Callback with the best cost, at intervals, once there is one.
        """
        self.num_evaluations = 0
        self.has_given_up = False
        self._max_checked_states = oracle.num_states + max_checked_states
        self._max_evaluations = _EVALUATIONS_PER_STATE * max_checked_states
        self._best_cost = getattr(planner, "bestCost", None)
        self._oracle = oracle
        self._deadline = deadline
        self._completion_deadline = completion_deadline
        self._on_improvement = on_improvement
        self._reported_cost, self._next_report_time = math.inf, -math.inf
        self._states_before = oracle.num_states
        self._improvement_max_checked_states = math.inf
        self._improvement_max_evaluations = math.inf

    def __call__(self) -> bool:
        """Return whether the planner is to end."""
        self.num_evaluations += 1
        if self._deadline.is_over:
            return True
        if math.isinf(self._improvement_max_evaluations) and self._has_reached_limits():
            self.has_given_up = True
            return True
        if self._best_cost is None:
            return False
        if math.isinf(self._improvement_max_evaluations):
            if math.isfinite(self._best_cost().value()):
                self.begin_improvement()
                self.extend_oracle_deadline()
            return False
        if self._on_improvement is not None:
            self._report_improvement(self._best_cost().value(), self._on_improvement)
        return (
            self._oracle.num_states >= self._improvement_max_checked_states
            or self.num_evaluations >= self._improvement_max_evaluations
        )

    def release_planner(self) -> None:
        """Release the planner, which may keep this condition: a reference cycle otherwise."""
        self._best_cost = self._on_improvement = None

    def begin_improvement(self) -> None:
        """Set the amount of work that may still be spent on improving the first solution.

        If less time than that remains, a share of it is kept for the processing of the solution.
        """
        self._deadline = self._deadline.at_fraction(_IMPROVEMENT_TIME_FRACTION)
        num_states_used = self._oracle.num_states - self._states_before
        self._improvement_max_checked_states = self._oracle.num_states + max(
            num_states_used, _MIN_IMPROVEMENT_STATES
        )
        self._improvement_max_evaluations = self.num_evaluations + max(
            self.num_evaluations, _MIN_IMPROVEMENT_EVALUATIONS
        )

    def extend_oracle_deadline(self) -> None:
        """Extend the oracle's deadline, so that no exception ends a planner that has a solution."""
        self._oracle.set_deadline(self._completion_deadline)

    def _report_improvement(self, cost: float, report: Callable[[float], None]) -> None:
        if cost < self._reported_cost and self._deadline.clock() >= self._next_report_time:
            self._reported_cost, self._next_report_time = (
                cost,
                self._deadline.clock() + _MIN_REPORT_INTERVAL,
            )
            report(cost)

    def _has_reached_limits(self) -> bool:
        has_checked = self._oracle.num_states >= self._max_checked_states
        return has_checked or self.num_evaluations >= self._max_evaluations
