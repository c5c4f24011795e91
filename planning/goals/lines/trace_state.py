"""TraceState: progress of tracing one tool line, with adaptive step size.

The step grows after each success and is halved after a failure to converge. The place where a
joint limit or an obstacle ends the line is found by bisection.
"""

from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np

from planning.domain.arrays import Array
from planning.domain.goals.linear_moves import ToolLine

# Accuracy of the place where a line ends, as a share of the line.
BISECTION_TOLERANCE = 1e-5
_GROWTH = 1.6


class TraceStop(IntEnum):
    """Reason against a step; STUCK: no convergence, or too large a deviation from the line."""

    NONE = 0
    STUCK = 1
    LIMIT = 2
    COLLISION = 3


@dataclass(frozen=True)
class CheckedStep:
    """Result of one attempted step along one line.

    Attributes:
        fraction: Fraction of the line at the end of the step.
        q: Configuration there, shape (nq,).
        stop: Reason against the step; NONE if it is feasible.
        max_shift: Bound on the tool's distance from the line during the step [m].
        max_turn: Bound on the tool's rotation error during the step [rad].
        infeasible_q: Configuration that violates a limit or collides, for LIMIT and COLLISION,
            shape (nq,).
    """

    fraction: float
    q: Array
    stop: TraceStop
    max_shift: float
    max_turn: float
    infeasible_q: Array


@dataclass
class TraceState:
    """Mutable state of the trace of one tool line.

    Attributes:
        line: Line to trace.
        max_step_fraction: Largest step, as a share of the line.
        waypoints: Configurations so far, the first at the line's beginning.
        bisection_tolerance: Accuracy of the bisection for limits and collisions, as a share of the
            line.
        fractions: Fraction of the line at each waypoint.
        max_shift: Bound on the tool's distance from the line between waypoints [m].
        max_turn: Bound on the tool's rotation error between waypoints [rad].
        stop: Reason of the end; NONE while tracing, and at the end of the line.
        infeasible_q: Infeasible configuration just beyond the end, for LIMIT and COLLISION.
    """

    line: ToolLine
    max_step_fraction: float
    waypoints: list[Array]
    bisection_tolerance: float
    fractions: list[float] = field(default_factory=lambda: [0.0])
    max_shift: float = 0.0
    max_turn: float = 0.0
    stop: TraceStop = TraceStop.NONE
    infeasible_q: Array = field(default_factory=lambda: np.zeros(0))
    _infeasible_fraction: float = np.inf
    _infeasible_stop: TraceStop = TraceStop.NONE
    _step_fraction: float = np.inf

    @property
    def fraction(self) -> float:
        """Fraction of the line reached so far."""
        return self.fractions[-1]

    @property
    def is_finished(self) -> bool:
        """Whether the trace has ended, at the end of the line or before it."""
        return self.stop is not TraceStop.NONE or self.fraction >= 1.0

    @property
    def next_fraction(self) -> float:
        """Fraction of the line at the end of the next step to try."""
        step_fraction = min(self._step_fraction, self.max_step_fraction)
        if np.isfinite(self._infeasible_fraction):
            step_fraction = min(step_fraction, (self._infeasible_fraction - self.fraction) / 2)
        end = self.fraction + step_fraction
        return 1.0 if end > 1.0 - BISECTION_TOLERANCE / 2 else end

    def apply_step(self, step: CheckedStep) -> None:
        """Accept a feasible step, or reduce the next one after an infeasible one."""
        width = step.fraction - self.fraction
        match step.stop:
            case TraceStop.NONE:
                self.fractions.append(step.fraction)
                self.waypoints.append(step.q)
                self.max_shift = max(self.max_shift, step.max_shift)
                self.max_turn = max(self.max_turn, step.max_turn)
                self._step_fraction = _GROWTH * width
            case TraceStop.STUCK:
                self._step_fraction = width / 2
                if self._step_fraction < BISECTION_TOLERANCE / 2:
                    self.stop = TraceStop.STUCK
            case TraceStop.LIMIT | TraceStop.COLLISION:
                self._infeasible_fraction, self._infeasible_stop = step.fraction, step.stop
                self.infeasible_q = step.infeasible_q
        if self._infeasible_fraction - self.fraction < self.bisection_tolerance:
            self.stop = self._infeasible_stop
