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
from planning.domain.goals.goal import Goal, LinedGoal, PoseGoal, RegionGoal
from planning.domain.goals.goal_configurations import GoalConfigurations
from planning.domain.goals.line_trace import LinearMoveStop, LineStop, LineTrace
from planning.domain.goals.linear_moves import GoalMoves, LinearMove, ToolLine
from planning.domain.request.deadline import Deadline
from planning.domain.robot.joints import JointLimits
from planning.goals.diagnosis.nearest_program import Target
from planning.goals.goal_query import GoalQuery
from planning.goals.joint_metric import JointMetric
from planning.goals.lines.line_stop import traced
from planning.goals.lines.line_tracer import LineTracer, TraceResolution
from planning.goals.lines.trace_state import TraceState
from planning.goals.ranking import nearest_first
from planning.goals.start import ROUNDING
from planning.world.world import World

# Largest number of blocked lines analyzed for the report.
_LOOKED_AT = 64


class ApproachChecker:
    """Check of goal configurations: their approach and retreat lines can be traced to their ends.

    Attributes:
        targets: Targets of the goal, in world.
        ended: Blocked lines: name ("approach" or "retreat"), index of the target, trace state.
    """

    def __init__(
        self,
        world: World,
        query: GoalQuery,
        goal: LinedGoal,
        targets: Sequence[Target],
        deadline: Deadline,
        fineness: TraceResolution | None = None,
    ) -> None:
        """Prepare for a goal.

        Args:
            world: Loaded scene.
            query: Goal query: group, margins and path constraints.
            goal: Goal with an approach or a retreat.
            targets: Targets of the goal, in world.
            deadline: Time limit of the traces.
            fineness: Resolution of the traces; None for the default.
        """
        self._world, self._query, self._deadline = world, query, deadline
        self.targets = targets
        self._axes = np.array([target.pose.quaternion for target in targets])
        self._ways = {"approach": goal.approach, "retreat": goal.retreat}
        self._frame = targets[0].frame
        fine = fineness or TraceResolution()
        self._tracer = LineTracer(world, query.group, self._frame, query.margins, fine)
        self._legs: dict[bytes, GoalMoves] = {}
        self._traces: list[tuple[str, LineTrace]] = []
        self.ended: list[tuple[str, int, TraceState]] = []

    def admit(
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
        good = np.ones(len(rows), dtype=bool)
        found: dict[str, dict[int, LinearMove]] = {}
        for name, way in self._ways.items():
            if way is not None:
                found[name] = self._reaching(name, rows, targets, good)
                good[[i for i in range(len(rows)) if i not in found[name]]] = False
        for i in np.flatnonzero(good).tolist():
            approach = found["approach"][i].reverse if "approach" in found else None
            retreat = found["retreat"][i] if "retreat" in found else None
            self._legs[rows[i].tobytes()] = GoalMoves(approach, retreat)
        return good

    def legs_of(
        self, admitted: Float64[np.ndarray, "n nq"], rows: Float64[np.ndarray, "n nq"]
    ) -> list[GoalMoves]:
        """Return the linear moves of rows that equal admitted ones up to full turns of joints."""
        return [
            _shifted(self._legs[q.tobytes()], row - q)
            for q, row in zip(admitted, rows, strict=True)
        ]

    def keep_rules(self, rows: Float64[np.ndarray, "n nq"]) -> Bool[np.ndarray, " n"]:
        """Return whether all lines of each admitted row satisfy the query's path constraints."""
        rules = self._query.rules
        kept = np.ones(len(rows), dtype=bool)
        if rules is not None:
            for i, legs in enumerate(self.legs_of(rows, rows)):
                kept[i] = all(rules.are_kept(leg.positions).all() for leg in legs.all)
        return kept

    def stop_of(self, q: Float64[np.ndarray, " nq"], target: int) -> LinearMoveStop | None:
        """Return the stop of the first blocked line of a configuration; None if none is blocked."""
        for name, way in self._ways.items():
            if way is not None:
                (course,) = self.reach(name, q[None], np.array([target]))
                stop = self._traced(course).stop
                if stop is not None:
                    return LinearMoveStop(name, stop)
        return None

    @property
    def blocking_pairs(self) -> list[tuple[str, str]]:
        """Pair of colliding bodies of each line that a collision stopped."""
        stops = [trace.stop for _, trace in self._looked_at()]
        return [stop.pair.bodies for stop in stops if stop is not None and stop.pair is not None]

    @property
    def blocked_by(self) -> tuple[LinearMoveTally, ...]:
        """Tally of the stops of the analyzed lines by reason and place, most frequent first."""
        fractions: dict[tuple[str, str, str], list[float]] = defaultdict(list)
        for name, trace in self._looked_at():
            if trace.stop is not None:
                key = name, trace.stop.reason, _where(trace.stop)
                fractions[key].append(trace.fraction)
        tallies = [
            LinearMoveTally(*key, len(found), max(found)) for key, found in fractions.items()
        ]
        return tuple(sorted(tallies, key=lambda t: (-t.count, t.leg, t.reason, t.where)))

    def reach(
        self, name: str, rows: Float64[np.ndarray, "n nq"], targets: Int64[np.ndarray, " n"]
    ) -> list[TraceState]:
        """Return the trace of each configuration along its "approach" or "retreat" line."""
        at = self._tracer.kinematics.poses(rows)
        outwards = rotation.rotate(self._axes[targets], np.asarray(self._ways[name])[None])
        lines = [
            ToolLine(self._frame, Pose(p, a), Pose(p + out, a))
            for R_WT, p, out in zip(*at, outwards, strict=True)
            for a in [rotation.from_matrix(R_WT)]
        ]
        return self._tracer.trace(lines, rows, self._deadline)

    def _looked_at(self) -> list[tuple[str, LineTrace]]:
        """Return the traces of the first blocked lines; each is analyzed once and cached."""
        for name, _, course in self.ended[len(self._traces) : _LOOKED_AT]:
            self._traces.append((name, self._traced(course)))
        return self._traces

    def _traced(self, course: TraceState) -> LineTrace:
        group, margins = self._query.group, self._query.margins
        return traced(self._world, group, margins, self._tracer.kinematics, course)

    def _reaching(
        self, name: str, rows: Array, targets: Indices, good: Flags
    ) -> dict[int, LinearMove]:
        """Return the outward linear moves of the good rows whose line is free, by row."""
        asked = np.flatnonzero(good)
        courses = self.reach(name, rows[asked], targets[asked])
        for target, course in zip(targets[asked], courses, strict=True):
            if course.halt:
                self.ended.append((name, int(target), course))
        return {
            int(i): LinearMove(course.line, np.array(course.fractions), np.stack(course.waypoints))
            for i, course in zip(asked, courses, strict=True)
            if not course.halt
        }


def approach_checker(
    world: World, query: GoalQuery, targets: Sequence[Target], deadline: Deadline
) -> ApproachChecker | None:
    """Return the approach checker of a goal; None if it has neither approach nor retreat."""
    goal = filter_by_approach(query.goal)
    return None if goal is None else ApproachChecker(world, query, goal, targets, deadline)


def filter_by_approach(goal: Goal) -> LinedGoal | None:
    """Return the goal if it has an approach or a retreat, else None."""
    if not isinstance(goal, PoseGoal | RegionGoal):
        return None
    return None if goal.approach is None and goal.retreat is None else goal


def with_moves(
    query: GoalQuery,
    limits: JointLimits,
    found: tuple[Float64[np.ndarray, "n nq"], Int64[np.ndarray, " n"], list[GoalMoves]],
    funnel: Funnel,
) -> GoalConfigurations:
    """Return the configurations whose linear moves are within limits, nearest entry first.

    The entry is the configuration at the beginning of the approach.

    Args:
        query: Goal query.
        limits: Joint limits of the group; full turns may have moved a line beyond them.
        found: Configurations, the indices of their targets, and their linear moves.
        funnel: Funnel of the search, for the report.
    """
    rows, targets, legs = found
    inside = [i for i in range(len(rows)) if _is_inside(limits, legs[i])]
    every = GoalConfigurations(
        rows[inside],
        tuple(int(i) for i in targets[inside]),
        funnel,
        tuple(legs[i] for i in inside),
    )
    count, index = query.options.max_configurations, np.arange(len(inside))
    metric = JointMetric.from_names(query.group, query.options.joint_weights)
    _, order = nearest_first(metric, query.start, every.entries, index, count)
    return GoalConfigurations(
        every.positions[list(order)],
        tuple(every.target_indices[i] for i in order),
        funnel,
        tuple(every.legs[i] for i in order),
    )


def _is_inside(limits: JointLimits, legs: GoalMoves) -> bool:
    return all(
        bool((leg.positions >= limits.lower - ROUNDING).all())
        and bool((leg.positions <= limits.upper + ROUNDING).all())
        for leg in legs.all
    )


def _shifted(legs: GoalMoves, shift: Array) -> GoalMoves:
    if not shift.any():
        return legs
    approach = None if legs.approach is None else legs.approach.shifted(shift)
    return GoalMoves(approach, None if legs.retreat is None else legs.retreat.shifted(shift))


def _where(stop: LineStop) -> str:
    return stop.joint if stop.pair is None else "-".join(stop.pair.bodies)
