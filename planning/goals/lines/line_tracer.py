"""LineTracer: traces straight tool lines (MoveL) from given configurations, many at once."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array, Flags, Indices
from planning.domain.goals.linear_moves import (
    MAX_POSITION_DEVIATION,
    MAX_ROTATION_DEVIATION,
    ToolLine,
)
from planning.domain.request.deadline import Deadline
from planning.domain.robot.joints import JointGroup
from planning.domain.robot.manifold import Manifold
from planning.goals.lines.line_steps import LineSteps
from planning.goals.lines.trace_state import BISECTION_TOLERANCE, CheckedStep, TraceState, TraceStop
from planning.goals.start_validation import ROUNDING
from planning.world.collision.margins import PairMargins
from planning.world.mechanics.tool_kinematics import ToolKinematics
from planning.world.world import World

# Largest tool rotation in one step [rad].
_MAX_TURN_PER_STEP = 0.3
# Largest joint-space length between two collision checks [rad or m].
_COLLISION_CHECK_SPACING = 0.02
# Velocity coordinates of a rigid body; a group with more is redundant.
_RIGID_BODY_DOFS = 6


@dataclass(frozen=True)
class TraceResolution:
    """Resolution of line tracing.

    Attributes:
        max_shift: Largest distance of the tool from the line between waypoints [m].
        max_turn: Largest rotation error of the tool between waypoints [rad].
        max_step: Largest tool translation between waypoints [m].
        bisection_tolerance: Accuracy of the place where a limit or a collision ends a line, as a
            share of the line. Whether a line reaches its end does not depend on it.
    """

    max_shift: float = MAX_POSITION_DEVIATION
    max_turn: float = MAX_ROTATION_DEVIATION
    max_step: float = 0.05
    bisection_tolerance: float = BISECTION_TOLERANCE


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
        resolution: TraceResolution,
    ) -> None:
        """Prepare for a frame, margins and a resolution, independently of the lines.

        Raises:
            UnknownName: There is no such frame.
        """
        self.kinematics = ToolKinematics(world, group, frame)
        self._manifold = Manifold(group.joints)
        self._limits = world.limits(group)
        self._oracle = world.collision_oracle(group, margins)
        self._resolution = resolution

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
        trace_states = [
            TraceState(
                line, self._max_step_fraction(line), [q], self._resolution.bisection_tolerance
            )
            for line, q in zip(lines, starts, strict=True)
        ]
        if not trace_states:
            return trace_states
        self._check_starts(trace_states, starts)
        steps = LineSteps(self.kinematics, self._manifold, lines)
        while rows := [i for i, state in enumerate(trace_states) if not state.is_finished]:
            deadline.check("line")
            for row, step in zip(rows, self._checked_steps(steps, rows, trace_states), strict=True):
                trace_states[row].apply_step(step)
        return trace_states

    def _max_step_fraction(self, line: ToolLine) -> float:
        turn = float(np.linalg.norm(line.rotation_vector))
        num_steps = max(line.length / self._resolution.max_step, turn / _MAX_TURN_PER_STEP, 1.0)
        return 1.0 / num_steps

    def _check_starts(self, trace_states: list[TraceState], starts: Array) -> None:
        free = self._oracle.are_free(np.ascontiguousarray(starts))
        for trace_state, q, outside, is_free in zip(
            trace_states, starts, self._are_outside(starts), free, strict=True
        ):
            if outside or not is_free:
                trace_state.stop = TraceStop.LIMIT if outside else TraceStop.COLLISION
                trace_state.infeasible_q = q

    def _checked_steps(
        self, steps: LineSteps, rows: list[int], trace_states: list[TraceState]
    ) -> list[CheckedStep]:
        """Return the next step of each of some lines, checked."""
        index = np.array(rows, dtype=np.int64)
        q = np.stack([trace_states[row].waypoints[-1] for row in rows])
        near = np.array([trace_states[row].fraction for row in rows])
        far = np.array([trace_states[row].next_fraction for row in rows])
        next_q, stops, infeasible_q = self._step_within_limits(steps, index, q, (near, far))
        displacements = self._manifold.minus(next_q, q)
        shift, turn = steps.deviation_bounds(index, q, displacements, far - near)
        is_off_line = (shift > self._resolution.max_shift) | (turn > self._resolution.max_turn)
        stops[is_off_line & (stops == TraceStop.NONE)] = TraceStop.STUCK
        self._check_collisions(q, displacements, stops, infeasible_q)
        return [
            CheckedStep(
                float(far[k]),
                next_q[k],
                TraceStop(stops[k]),
                float(shift[k]),
                float(turn[k]),
                infeasible_q[k],
            )
            for k in range(len(rows))
        ]

    def _step_within_limits(
        self, steps: LineSteps, rows: Indices, q: Array, spans: tuple[Array, Array]
    ) -> tuple[Array, Indices, Array]:
        """Return the ends of steps, their stops, and the infeasible configurations of the stops.

        In a redundant group, coordinates that would leave their limits are locked.
        """
        locked = np.zeros((len(rows), self._manifold.num_velocities), dtype=bool)
        next_q, is_converged = steps.step(rows, q, spans, locked)
        infeasible_q = np.array(next_q)
        outside = is_converged & self._are_outside(next_q)
        stops = np.where(
            is_converged, np.where(outside, TraceStop.LIMIT, TraceStop.NONE), TraceStop.STUCK
        ).astype(np.int64)
        if self._manifold.is_flat and locked.shape[1] > _RIGID_BODY_DOFS:
            for _ in range(locked.shape[1] - _RIGID_BODY_DOFS):
                limited_rows = np.flatnonzero(stops == TraceStop.LIMIT)
                if not len(limited_rows):
                    break
                locked[limited_rows] |= self._coordinates_outside(next_q[limited_rows])
                span = spans[0][limited_rows], spans[1][limited_rows]
                next_q[limited_rows], is_converged = steps.step(
                    rows[limited_rows], q[limited_rows], span, locked[limited_rows]
                )
                is_feasible = is_converged & ~self._are_outside(next_q[limited_rows])
                stops[limited_rows[is_feasible]] = TraceStop.NONE
        accepted = (stops == TraceStop.NONE)[:, None]
        np.clip(next_q, self._limits.lower, self._limits.upper, where=accepted, out=next_q)
        return next_q, stops, infeasible_q

    def _check_collisions(
        self, q: Array, displacements: Array, stops: Indices, infeasible_q: Array
    ) -> None:
        """Check the steps that are feasible so far for collisions, at samples."""
        rows = np.flatnonzero(stops == TraceStop.NONE)
        lengths = np.linalg.norm(displacements[rows], axis=1)
        counts = np.maximum(1, np.ceil(lengths / _COLLISION_CHECK_SPACING)).astype(np.int64)
        if not len(rows):
            return
        fractions = np.concatenate([np.arange(1, n + 1) / n for n in counts])
        step_indices = np.repeat(rows, counts)
        samples = self._manifold.plus(
            q[step_indices], fractions[:, None] * displacements[step_indices]
        )
        for k in np.flatnonzero(~self._oracle.are_free(samples))[::-1]:
            stops[step_indices[k]], infeasible_q[step_indices[k]] = TraceStop.COLLISION, samples[k]

    def _coordinates_outside(self, q: Array) -> Flags:
        low, high = self._limits.lower, self._limits.upper
        return (q < low - ROUNDING) | (q > high + ROUNDING)

    def _are_outside(self, q: Array) -> Flags:
        return self._coordinates_outside(q).any(axis=1)
