"""ApproachChecker: filter of goal configurations by a free approach and a free retreat.

Both lines are traced from the goal configuration outwards, so they stay in its IK branch.
"""

from collections import defaultdict
from collections.abc import Sequence

import numpy as np
from jaxtyping import Bool, Float64, Int64

from planning.domain.arrays import Array, Flags, Indices
from planning.domain.geometry import rotation
from planning.domain.geometry.pose import Pose
from planning.domain.goals.funnel import Funnel, LinearMoveTally
from planning.domain.goals.goal import Goal, GoalWithLinearMoves, PoseGoal, RegionGoal
from planning.domain.goals.goal_configurations import GoalConfigurations
from planning.domain.goals.line_trace import LinearMoveStop, LineStop, LineTrace
from planning.domain.goals.linear_moves import GoalMoves, LinearMove, ToolLine
from planning.domain.request.deadline import Deadline
from planning.domain.robot.joints import JointLimits
from planning.goals.diagnosis.nearest_program import Target
from planning.goals.goal_query import GoalQuery
from planning.goals.joint_metric import JointMetric
from planning.goals.lines.line_stop import make_line_trace
from planning.goals.lines.line_tracer import LineTracer, TraceResolution
from planning.goals.lines.trace_state import TraceState
from planning.goals.ranking import nearest_first
from planning.goals.start_validation import ROUNDING
from planning.world.world import World

# Largest number of blocked lines analyzed for the report.
_MAX_ANALYZED = 64


class ApproachChecker:
    """Check of goal configurations: their approach and retreat lines can be traced to their ends.

    Attributes:
        targets: Targets of the goal, in world.
        blocked_lines: Blocked lines: name ("approach" or "retreat"), index of the target, trace
            state.
    """

    def __init__(
        self,
        world: World,
        query: GoalQuery,
        goal: GoalWithLinearMoves,
        targets: Sequence[Target],
        deadline: Deadline,
        resolution: TraceResolution | None = None,
    ) -> None:
        """Prepare for a goal.

        Args:
            world: Loaded scene.
            query: Goal query: group, margins and path constraints.
            goal: Goal with an approach or a retreat.
            targets: Targets of the goal, in world.
            deadline: Time limit of the traces.
            resolution: Resolution of the traces; None for the default.
        """
        self._world, self._query, self._deadline = world, query, deadline
        self.targets = targets
        self._axes = np.array([target.pose.quaternion for target in targets])
        self._vectors = {"approach": goal.approach, "retreat": goal.retreat}
        self._frame = targets[0].frame
        trace_resolution = resolution or TraceResolution()
        self._tracer = LineTracer(world, query.group, self._frame, query.margins, trace_resolution)
        self._moves: dict[bytes, GoalMoves] = {}
        self._traces: list[tuple[str, LineTrace]] = []
        self.blocked_lines: list[tuple[str, int, TraceState]] = []

    def check(
        self, rows: Float64[np.ndarray, "n nq"], targets: Int64[np.ndarray, " n"]
    ) -> Bool[np.ndarray, " n"]:
        """Return whether each configuration has all requested lines; store their linear moves.

        Args:
            rows: Goal configurations.
            targets: Index of the target that each configuration reaches.

        Raises:
            DeadlineExceeded: Time ran out.
            Canceled: Cancellation was requested.
        """
        is_free = np.ones(len(rows), dtype=bool)
        moves_by_name: dict[str, dict[int, LinearMove]] = {}
        for name, vector in self._vectors.items():
            if vector is not None:
                moves_by_name[name] = self._free_moves(name, rows, targets, is_free)
                is_free[[i for i in range(len(rows)) if i not in moves_by_name[name]]] = False
        for i in np.flatnonzero(is_free).tolist():
            approach = moves_by_name["approach"][i].reverse if "approach" in moves_by_name else None
            retreat = moves_by_name["retreat"][i] if "retreat" in moves_by_name else None
            self._moves[rows[i].tobytes()] = GoalMoves(approach, retreat)
        return is_free

    def moves_of(
        self, checked: Float64[np.ndarray, "n nq"], rows: Float64[np.ndarray, "n nq"]
    ) -> list[GoalMoves]:
        """Return the linear moves of rows that equal admitted ones up to full turns of joints."""
        return [
            _shifted(self._moves[q.tobytes()], row - q)
            for q, row in zip(checked, rows, strict=True)
        ]

    def moves_satisfy_constraints(
        self, rows: Float64[np.ndarray, "n nq"]
    ) -> Bool[np.ndarray, " n"]:
        """Return whether all lines of each admitted row satisfy the query's path constraints."""
        constraints = self._query.constraints
        is_satisfied = np.ones(len(rows), dtype=bool)
        if constraints is not None:
            for i, moves in enumerate(self.moves_of(rows, rows)):
                is_satisfied[i] = all(
                    constraints.are_satisfied(move.positions).all() for move in moves.all
                )
        return is_satisfied

    def stop_of(self, q: Float64[np.ndarray, " nq"], target: int) -> LinearMoveStop | None:
        """Return the stop of the first blocked line of a configuration; None if none is blocked."""
        for name, vector in self._vectors.items():
            if vector is not None:
                (trace_state,) = self.trace(name, q[None], np.array([target]))
                stop = self._line_trace(trace_state).stop
                if stop is not None:
                    return LinearMoveStop(name, stop)
        return None

    @property
    def blocking_pairs(self) -> list[tuple[str, str]]:
        """Pair of colliding bodies of each line that a collision stopped."""
        stops = [trace.stop for _, trace in self._analyzed_lines()]
        return [stop.pair.bodies for stop in stops if stop is not None and stop.pair is not None]

    @property
    def blocked_by(self) -> tuple[LinearMoveTally, ...]:
        """Tally of the stops of the analyzed lines by reason and place, most frequent first."""
        fractions: dict[tuple[str, str, str], list[float]] = defaultdict(list)
        for name, trace in self._analyzed_lines():
            if trace.stop is not None:
                key = name, trace.stop.reason, _stop_location(trace.stop)
                fractions[key].append(trace.fraction)
        tallies = [
            LinearMoveTally(*key, len(found), max(found)) for key, found in fractions.items()
        ]
        return tuple(sorted(tallies, key=lambda t: (-t.count, t.move, t.reason, t.where)))

    def trace(
        self, name: str, rows: Float64[np.ndarray, "n nq"], targets: Int64[np.ndarray, " n"]
    ) -> list[TraceState]:
        """Return the trace of each configuration along its "approach" or "retreat" line."""
        tool_poses = self._tracer.kinematics.poses(rows)
        displacements = rotation.rotate(self._axes[targets], np.asarray(self._vectors[name])[None])
        lines = [
            ToolLine(self._frame, Pose(p, a), Pose(p + out, a))
            for R_WT, p, out in zip(*tool_poses, displacements, strict=True)
            for a in [rotation.from_matrix(R_WT)]
        ]
        return self._tracer.trace(lines, rows, self._deadline)

    def _analyzed_lines(self) -> list[tuple[str, LineTrace]]:
        """Return the traces of the first blocked lines; each is analyzed once and cached."""
        for name, _, trace_state in self.blocked_lines[len(self._traces) : _MAX_ANALYZED]:
            self._traces.append((name, self._line_trace(trace_state)))
        return self._traces

    def _line_trace(self, trace_state: TraceState) -> LineTrace:
        group, margins = self._query.group, self._query.margins
        return make_line_trace(self._world, group, margins, self._tracer.kinematics, trace_state)

    def _free_moves(
        self, name: str, rows: Array, targets: Indices, is_free: Flags
    ) -> dict[int, LinearMove]:
        """Return the outward linear moves of the good rows whose line is free, by row."""
        indices = np.flatnonzero(is_free)
        trace_states = self.trace(name, rows[indices], targets[indices])
        for target, trace_state in zip(targets[indices], trace_states, strict=True):
            if trace_state.stop:
                self.blocked_lines.append((name, int(target), trace_state))
        return {
            int(i): LinearMove(state.line, np.array(state.fractions), np.stack(state.waypoints))
            for i, state in zip(indices, trace_states, strict=True)
            if not state.stop
        }


def approach_checker(
    world: World, query: GoalQuery, targets: Sequence[Target], deadline: Deadline
) -> ApproachChecker | None:
    """Return the approach checker of a goal; None if it has neither approach nor retreat."""
    goal = goal_with_approach(query.goal)
    return None if goal is None else ApproachChecker(world, query, goal, targets, deadline)


def goal_with_approach(goal: Goal) -> GoalWithLinearMoves | None:
    """Return the goal if it has an approach or a retreat, else None."""
    if not isinstance(goal, PoseGoal | RegionGoal):
        return None
    return None if goal.approach is None and goal.retreat is None else goal


def with_moves(
    query: GoalQuery,
    limits: JointLimits,
    solutions: tuple[Float64[np.ndarray, "n nq"], Int64[np.ndarray, " n"], list[GoalMoves]],
    funnel: Funnel,
) -> GoalConfigurations:
    """Return the configurations whose linear moves are within limits, nearest entry first.

    The entry is the configuration at the beginning of the approach.

    Args:
        query: Goal query.
        limits: Joint limits of the group; full turns may have moved a line beyond them.
        solutions: Configurations, the indices of their targets, and their linear moves.
        funnel: Funnel of the search, for the report.
    """
    rows, targets, moves = solutions
    inside = [i for i in range(len(rows)) if _is_within_limits(limits, moves[i])]
    all_configurations = GoalConfigurations(
        rows[inside],
        tuple(int(i) for i in targets[inside]),
        funnel,
        tuple(moves[i] for i in inside),
    )
    count, index = query.options.max_configurations, np.arange(len(inside))
    metric = JointMetric.from_names(query.group, query.options.joint_weights)
    _, order = nearest_first(metric, query.start, all_configurations.entries, index, count)
    return GoalConfigurations(
        all_configurations.positions[list(order)],
        tuple(all_configurations.target_indices[i] for i in order),
        funnel,
        tuple(all_configurations.moves[i] for i in order),
    )


def _is_within_limits(limits: JointLimits, moves: GoalMoves) -> bool:
    return all(
        bool((move.positions >= limits.lower - ROUNDING).all())
        and bool((move.positions <= limits.upper + ROUNDING).all())
        for move in moves.all
    )


def _shifted(moves: GoalMoves, shift: Array) -> GoalMoves:
    if not shift.any():
        return moves
    approach = None if moves.approach is None else moves.approach.shifted(shift)
    return GoalMoves(approach, None if moves.retreat is None else moves.retreat.shifted(shift))


def _stop_location(stop: LineStop) -> str:
    return stop.joint if stop.pair is None else "-".join(stop.pair.bodies)
