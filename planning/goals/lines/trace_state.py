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
FINEST = 1e-5
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
        halt: Reason against the step; NONE if it is feasible.
        max_shift: Bound on the tool's distance from the line during the step [m].
        max_turn: Bound on the tool's rotation error during the step [rad].
        beyond: Configuration that violates a limit or collides, for LIMIT and COLLISION, shape
            (nq,).
    """

    fraction: float
    q: Array
    halt: TraceStop
    max_shift: float
    max_turn: float
    beyond: Array


@dataclass
class TraceState:
    """Mutable state of the trace of one tool line.

    Attributes:
        line: Line to trace.
        longest: Largest step, as a share of the line.
        waypoints: Configurations so far, the first at the line's beginning.
        finest: Accuracy of the bisection for limits and collisions, as a share of the line.
        fractions: Fraction of the line at each waypoint.
        max_shift: Bound on the tool's distance from the line between waypoints [m].
        max_turn: Bound on the tool's rotation error between waypoints [rad].
        halt: Reason of the end; NONE while tracing, and at the end of the line.
        beyond: Infeasible configuration just beyond the end, for LIMIT and COLLISION.
    """

    line: ToolLine
    longest: float
    waypoints: list[Array]
    finest: float
    fractions: list[float] = field(default_factory=lambda: [0.0])
    max_shift: float = 0.0
    max_turn: float = 0.0
    halt: TraceStop = TraceStop.NONE
    beyond: Array = field(default_factory=lambda: np.zeros(0))
    _wall: float = np.inf
    _before_wall: TraceStop = TraceStop.NONE
    _ahead: float = np.inf

    @property
    def at(self) -> float:
        """Fraction of the line reached so far."""
        return self.fractions[-1]

    @property
    def is_over(self) -> bool:
        """Whether the trace has ended, at the end of the line or before it."""
        return self.halt is not TraceStop.NONE or self.at >= 1.0

    @property
    def next(self) -> float:
        """Fraction of the line at the end of the next step to try."""
        ahead = min(self._ahead, self.longest)
        if np.isfinite(self._wall):
            ahead = min(ahead, (self._wall - self.at) / 2)
        end = self.at + ahead
        return 1.0 if end > 1.0 - FINEST / 2 else end

    def take(self, step: CheckedStep) -> None:
        """Accept a feasible step, or reduce the next one after an infeasible one."""
        width = step.fraction - self.at
        match step.halt:
            case TraceStop.NONE:
                self.fractions.append(step.fraction)
                self.waypoints.append(step.q)
                self.max_shift = max(self.max_shift, step.max_shift)
                self.max_turn = max(self.max_turn, step.max_turn)
                self._ahead = _GROWTH * width
            case TraceStop.STUCK:
                self._ahead = width / 2
                if self._ahead < FINEST / 2:
                    self.halt = TraceStop.STUCK
            case TraceStop.LIMIT | TraceStop.COLLISION:
                self._wall, self._before_wall, self.beyond = step.fraction, step.halt, step.beyond
        if self._wall - self.at < self.finest:
            self.halt = self._before_wall
