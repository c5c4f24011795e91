"""TraceState: how far one line was followed, and which step to try next.

The step grows while all goes well and is halved where it does not. What a step runs into (a joint's
limit, an obstacle) lies between its two ends and is found by bisection.
"""

from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any

import numpy as np

from planning.domain.goals.linear_moves import ToolLine

type Array = np.ndarray[Any, np.dtype[np.float64]]

# Where a line ends is found to this share of it.
FINEST = 1e-5
_GROWTH = 1.6


class TraceStop(IntEnum):
    """What stands against a step."""

    NONE = 0
    STUCK = 1
    LIMIT = 2
    COLLISION = 3


@dataclass(frozen=True)
class CheckedStep:
    """One step of one line.

    Attributes:
        fraction: Where it ends.
        q: The configuration there, shape (nq,).
        halt: What stands against it.
        max_shift: Bound on how far the tool is off the line on the way [m].
        max_turn: And its rotation [rad].
        beyond: If it must not be: a configuration that shows it, shape (nq,).
    """

    fraction: float
    q: Array
    halt: TraceStop
    max_shift: float
    max_turn: float
    beyond: Array


@dataclass
class TraceState:
    """How one line went.

    Attributes:
        line: The line.
        longest: Largest step, as a share of the line.
        waypoints: Configurations, the first at the line's beginning.
        finest: Where limits and bodies end it is found to this share of it.
        fractions: Of the line, one for each.
        max_shift: Bound on how far the tool was off between them [m].
        max_turn: And its rotation [rad].
        halt: Why it goes no further; NONE while it goes, and if it reached the end.
        beyond: A configuration just beyond that must not be, for LIMIT and COLLISION.
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
        """The fraction that is reached."""
        return self.fractions[-1]

    @property
    def is_over(self) -> bool:
        """Whether it goes no further."""
        return self.halt is not TraceStop.NONE or self.at >= 1.0

    @property
    def next(self) -> float:
        """Where the next step shall end."""
        ahead = min(self._ahead, self.longest)
        if np.isfinite(self._wall):
            ahead = min(ahead, (self._wall - self.at) / 2)
        end = self.at + ahead
        return 1.0 if end > 1.0 - FINEST / 2 else end

    def take(self, step: CheckedStep) -> None:
        """Go there, or remember what stands against it."""
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
