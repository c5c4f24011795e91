"""LineTracer: traces straight tool lines (MoveL) from given configurations, many at once."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array, Flags, Indices
from planning.domain.goals.linear_moves import MAX_SHIFT, MAX_TURN, ToolLine
from planning.domain.request.deadline import Deadline
from planning.domain.robot.joints import JointGroup
from planning.domain.robot.manifold import Manifold
from planning.goals.lines.line_steps import LineSteps
from planning.goals.lines.trace_state import FINEST, CheckedStep, TraceState, TraceStop
from planning.goals.start import ROUNDING
from planning.world.collision.margins import PairMargins
from planning.world.mechanics.tool_kinematics import ToolKinematics
from planning.world.world import World

# Largest tool rotation in one step [rad].
_LARGEST_TURN = 0.3
# Largest joint-space length between two collision checks [rad or m].
_LOOK = 0.02
# Velocity coordinates of a rigid body; a group with more is redundant.
_RIGID = 6


@dataclass(frozen=True)
class TraceResolution:
    """Resolution of line tracing.

    Attributes:
        max_shift: Largest distance of the tool from the line between waypoints [m].
        max_turn: Largest rotation error of the tool between waypoints [rad].
        max_step: Largest tool translation between waypoints [m].
        end: Accuracy of the place where a limit or a collision ends a line, as a share of the
            line. Whether a line reaches its end does not depend on it.
    """

    max_shift: float = MAX_SHIFT
    max_turn: float = MAX_TURN
    max_step: float = 0.05
    end: float = FINEST


class LineTracer:
    """Tracer of straight lines of one tool frame of one group.

    Attributes:
        kinematics: Kinematics of the tool frame.
    """

    def __init__(
        self,
        world: World,
        group: JointGroup,
        frame: str,
        margins: PairMargins,
        fineness: TraceResolution,
    ) -> None:
        """Prepare for a frame, margins and a resolution, independently of the lines.

        Raises:
            UnknownName: There is no such frame.
        """
        self.kinematics = ToolKinematics(world, group, frame)
        self._manifold = Manifold(group.joints)
        self._limits = world.limits(group)
        self._oracle = world.collision_oracle(group, margins)
        self._fineness = fineness

    def trace(
        self,
        lines: Sequence[ToolLine],
        starts: Float64[np.ndarray, "m nq"],
        deadline: Deadline,
    ) -> list[TraceState]:
        """Trace each line from a start configuration as far as it is feasible.

        Collisions are checked at samples of the steps, not proven absent between them.

        Args:
            lines: Lines of the tool frame.
            starts: Start configurations, each with the tool at the beginning of its line.
            deadline: Time limit.

        Raises:
            DeadlineExceeded: Time ran out.
            Canceled: Cancellation was requested.
        """
        courses = [
            TraceState(line, self._longest(line), [q], self._fineness.end)
            for line, q in zip(lines, starts, strict=True)
        ]
        if not courses:
            return courses
        self._look_at_starts(courses, starts)
        steps = LineSteps(self.kinematics, self._manifold, lines)
        while rows := [i for i, course in enumerate(courses) if not course.is_over]:
            deadline.check("line")
            for row, step in zip(rows, self._judged(steps, rows, courses), strict=True):
                courses[row].take(step)
        return courses

    def _longest(self, line: ToolLine) -> float:
        turn = float(np.linalg.norm(line.turn))
        share = max(line.length / self._fineness.max_step, turn / _LARGEST_TURN, 1.0)
        return 1.0 / share

    def _look_at_starts(self, courses: list[TraceState], starts: Array) -> None:
        free = self._oracle.are_free(np.ascontiguousarray(starts))
        for course, q, outside, is_free in zip(
            courses, starts, self._are_outside(starts), free, strict=True
        ):
            if outside or not is_free:
                course.halt = TraceStop.LIMIT if outside else TraceStop.COLLISION
                course.beyond = q

    def _judged(
        self, steps: LineSteps, rows: list[int], courses: list[TraceState]
    ) -> list[CheckedStep]:
        """Return the next step of each of some lines, checked."""
        index = np.array(rows, dtype=np.int64)
        q = np.stack([courses[row].waypoints[-1] for row in rows])
        near = np.array([courses[row].at for row in rows])
        far = np.array([courses[row].next for row in rows])
        reached, halts, beyond = self._within_limits(steps, index, q, (near, far))
        moves = self._manifold.minus(reached, q)
        shift, turn = steps.strays(index, q, moves, far - near)
        strays = (shift > self._fineness.max_shift) | (turn > self._fineness.max_turn)
        halts[strays & (halts == TraceStop.NONE)] = TraceStop.STUCK
        self._look(q, moves, halts, beyond)
        return [
            CheckedStep(
                float(far[k]),
                reached[k],
                TraceStop(halts[k]),
                float(shift[k]),
                float(turn[k]),
                beyond[k],
            )
            for k in range(len(rows))
        ]

    def _within_limits(
        self, steps: LineSteps, rows: Indices, q: Array, spans: tuple[Array, Array]
    ) -> tuple[Array, Indices, Array]:
        """Return the ends of steps, the reasons against them, and configurations beyond limits.

        In a redundant group, coordinates that would leave their limits are locked.
        """
        locked = np.zeros((len(rows), self._manifold.num_velocities), dtype=bool)
        reached, right = steps.step(rows, q, spans, locked)
        beyond = np.array(reached)
        outside = right & self._are_outside(reached)
        halts = np.where(
            right, np.where(outside, TraceStop.LIMIT, TraceStop.NONE), TraceStop.STUCK
        ).astype(np.int64)
        if self._manifold.is_flat and locked.shape[1] > _RIGID:
            for _ in range(locked.shape[1] - _RIGID):
                again = np.flatnonzero(halts == TraceStop.LIMIT)
                if not len(again):
                    break
                locked[again] |= self._coordinates_outside(reached[again])
                span = spans[0][again], spans[1][again]
                reached[again], right = steps.step(rows[again], q[again], span, locked[again])
                halts[again[right & ~self._are_outside(reached[again])]] = TraceStop.NONE
        reached = np.clip(
            reached,
            self._limits.lower,
            self._limits.upper,
            where=(halts == TraceStop.NONE)[:, None],
            out=reached,
        )
        return reached, halts, beyond

    def _look(self, q: Array, moves: Array, halts: Indices, beyond: Array) -> None:
        """Check the steps that are feasible so far for collisions, at samples."""
        rows = np.flatnonzero(halts == TraceStop.NONE)
        lengths = np.linalg.norm(moves[rows], axis=1)
        counts = np.maximum(1, np.ceil(lengths / _LOOK)).astype(np.int64)
        if not len(rows):
            return
        fractions = np.concatenate([np.arange(1, n + 1) / n for n in counts])
        owners = np.repeat(rows, counts)
        looked_at = self._manifold.plus(q[owners], fractions[:, None] * moves[owners])
        for k in np.flatnonzero(~self._oracle.are_free(looked_at))[::-1]:
            halts[owners[k]], beyond[owners[k]] = TraceStop.COLLISION, looked_at[k]

    def _coordinates_outside(self, q: Array) -> Flags:
        low, high = self._limits.lower, self._limits.upper
        return (q < low - ROUNDING) | (q > high + ROUNDING)

    def _are_outside(self, q: Array) -> Flags:
        return self._coordinates_outside(q).any(axis=1)
