"""Active constraints at the feasible pose nearest to an unreachable pose goal."""

from collections.abc import Callable
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.goals.goal_configurations import Bounds
from planning.domain.goals.linear_moves import ToolLine
from planning.domain.request.deadline import Deadline
from planning.domain.robot.manifold import Manifold
from planning.goals.diagnosis.nearest_program import Target
from planning.goals.diagnosis.pose_perturbations import step_to
from planning.goals.feasibility import Feasibility
from planning.goals.goal_query import GoalQuery
from planning.goals.lines.approach_feasibility import ApproachFeasibility, approach_feasibility
from planning.world.mechanics.tool_kinematics import ToolKinematics
from planning.world.world import World

# Distance from its bound within which a pair or a joint is active [m, rad].
_AT_BOUND = 1e-4
# Steps towards the goal, as shares of the line; the last one arrives.
_SHARES = 10 ** np.linspace(-4.0, 0.0, 17)
_NUM_NEWTON = 4


def bounds_at(
    world: World, query: GoalQuery, q: Float64[np.ndarray, " nq"], is_kept_off: Callable[[], bool]
) -> Bounds:
    """Return the active constraints at q: body pairs at their margins, joints at their limits.

    Args:
        world: Loaded scene.
        query: Goal query.
        q: Configuration.
        is_kept_off: Returns whether q would be nearer to the goal without collision constraints;
            if not, body pairs at their margins do not count as active.
    """
    pairs = _touching(world, query, q)
    joints = _names(query, _at_limits(world, query, q))
    return Bounds(joints, pairs if pairs and is_kept_off() else ())


def barrier(
    world: World,
    query: GoalQuery,
    target: Target,
    q: Float64[np.ndarray, " nq"],
    deadline: Deadline,
) -> Bounds:
    """Return the constraints that the first infeasible step from q towards a target violates.

    At a minimum of the distance the line to the target is blocked at once. The steps follow the
    straight line of the tool by minimum-norm joint motions, beyond joint limits too.

    Args:
        world: Loaded scene.
        query: Goal query.
        target: Target that q is near.
        q: Nearest feasible configuration.
        deadline: Time limit of the line checks; after it `bounds_at` q is returned.
    """
    reached = world.frame_pose(target.frame, world.embed(query.group, q))
    rows = _steps(world, query, q, ToolLine(target.frame, reached, target.closest(reached)))
    lines = approach_feasibility(world, query, [target], deadline)
    is_open = Feasibility(world, query).are_met(rows)
    if lines is not None:
        is_open[is_open] = lines.are_free(
            rows[is_open], np.zeros(int(is_open.sum()), dtype=np.int64)
        )
    barred = np.flatnonzero(~is_open)
    if not len(barred) or deadline.is_over:
        return bounds_at(world, query, q, lambda: True)
    return _against(world, query, lines, rows[barred[0]])


def _steps(world: World, query: GoalQuery, q: Array, line: ToolLine) -> Array:
    """Return configurations with the tool at the shares `_SHARES` of a line, by Newton's method."""
    manifold = Manifold(query.group.joints)
    kinematics = ToolKinematics(world, query.group, line.frame)
    rows: list[Array] = []
    for share in _SHARES:
        row = q
        for _ in range(_NUM_NEWTON):
            row = manifold.plus(row, step_to(kinematics, row, line.pose(float(share))))
        rows.append(manifold.normalized(row))
    return np.stack(rows)


def _against(world: World, query: GoalQuery, lines: ApproachFeasibility | None, q: Array) -> Bounds:
    """Return the constraints that a configuration violates, or else those that block its lines."""
    broken = [] if query.rules is None else query.rules.violations(q)
    pairs = tuple(pair.bodies for pair in world.violations(query.group, q, query.margins))
    own = {entry.get("joint", "") for entry in broken}
    limits = world.limits(query.group)
    joints = _names(query, (q < limits.lower) | (q > limits.upper))
    bounds = Bounds(
        joints=tuple(name for name in joints if name not in own),
        pairs=pairs,
        constraints=tuple(entry["constraint"] for entry in broken),
    )
    if bounds != Bounds() or lines is None:
        return bounds
    return lines.bounds_of(q, 0)


def _touching(world: World, query: GoalQuery, q: Array) -> tuple[tuple[str, str], ...]:
    """Return the body pairs that are at their margins."""
    margins = query.margins
    probe = world.distance_probe(margins)
    full = world.embed(query.group, q)
    near = probe.pairs_within(full, margins.largest + _AT_BOUND)
    return tuple(
        pair.bodies for pair in near if pair.distance < margins.of(*pair.bodies) + _AT_BOUND
    )


def _at_limits(world: World, query: GoalQuery, q: Array) -> Any:
    limits = world.limits(query.group)
    return np.minimum(q - limits.lower, limits.upper - q) < _AT_BOUND


def _names(query: GoalQuery, flags: Any) -> tuple[str, ...]:
    return tuple(np.array(query.group.position_names)[flags].tolist())
