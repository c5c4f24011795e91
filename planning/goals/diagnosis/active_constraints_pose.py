"""Active constraints at the feasible pose nearest to an unreachable pose goal."""

from collections.abc import Callable
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.goals.goal_configurations import ActiveConstraints
from planning.domain.goals.linear_moves import ToolLine
from planning.domain.request.deadline import Deadline
from planning.domain.robot.manifold import Manifold
from planning.goals.diagnosis.nearest_program import Target
from planning.goals.diagnosis.pose_perturbations import minimum_norm_step
from planning.goals.feasibility import Feasibility
from planning.goals.goal_query import GoalQuery
from planning.goals.lines.approach_feasibility import ApproachFeasibility, approach_feasibility
from planning.world.mechanics.tool_kinematics import ToolKinematics
from planning.world.world import World

# Distance from its bound within which a pair or a joint is active [m, rad].
_ACTIVE_TOLERANCE = 1e-4
# Steps towards the goal, as shares of the line; the last one ends at the goal.
_STEP_FRACTIONS = 10 ** np.linspace(-4.0, 0.0, 17)
_NUM_NEWTON_STEPS = 4


def active_constraints_at(
    world: World,
    query: GoalQuery,
    q: Float64[np.ndarray, " nq"],
    is_blocked_by_collision: Callable[[], bool],
) -> ActiveConstraints:
    """Return the active constraints at q: body pairs at their margins, joints at their limits.

    Args:
        world: Loaded scene.
        query: Goal query.
        q: Configuration.
        is_blocked_by_collision: Returns whether q would be nearer to the goal without collision
            constraints; if not, body pairs at their margins do not count as active.
    """
    pairs = _active_pairs(world, query, q)
    joints = _position_names(query, _at_limits(world, query, q))
    return ActiveConstraints(joints, pairs if pairs and is_blocked_by_collision() else ())


def blocking_constraints(
    world: World,
    query: GoalQuery,
    target: Target,
    q: Float64[np.ndarray, " nq"],
    deadline: Deadline,
) -> ActiveConstraints:
    """Return the constraints that the first infeasible step from q towards a target violates.

    At a minimum of the distance the line to the target is blocked at once. The steps follow the
    straight line of the tool by minimum-norm joint motions, beyond joint limits too.

    Args:
        world: Loaded scene.
        query: Goal query.
        target: Target that q is near.
        q: Nearest feasible configuration.
        deadline: Time limit of the line checks; after it `active_constraints_at` q is returned.
    """
    tool_pose = world.frame_pose(target.frame, world.embed(query.group, q))
    rows = _follow_line(
        world, query, q, ToolLine(target.frame, tool_pose, target.closest(tool_pose))
    )
    approach_check = approach_feasibility(world, query, [target], deadline)
    is_feasible = Feasibility(world, query).are_feasible(rows)
    if approach_check is not None:
        is_feasible[is_feasible] = approach_check.are_free(
            rows[is_feasible], np.zeros(int(is_feasible.sum()), dtype=np.int64)
        )
    blocked_indices = np.flatnonzero(~is_feasible)
    if not len(blocked_indices) or deadline.is_over:
        return active_constraints_at(world, query, q, lambda: True)
    return _violated_constraints(world, query, approach_check, rows[blocked_indices[0]])


def _follow_line(world: World, query: GoalQuery, q: Array, line: ToolLine) -> Array:
    """Return configurations at `_STEP_FRACTIONS` of a line of the tool, by Newton's method."""
    manifold = Manifold(query.group.joints)
    kinematics = ToolKinematics(world, query.group, line.frame)
    rows: list[Array] = []
    for fraction in _STEP_FRACTIONS:
        row = q
        for _ in range(_NUM_NEWTON_STEPS):
            row = manifold.plus(row, minimum_norm_step(kinematics, row, line.pose(float(fraction))))
        rows.append(manifold.normalized(row))
    return np.stack(rows)


def _violated_constraints(
    world: World, query: GoalQuery, approach_check: ApproachFeasibility | None, q: Array
) -> ActiveConstraints:
    """Return the constraints that a configuration violates, or else those that block its lines."""
    violations = [] if query.constraints is None else query.constraints.violations(q)
    pairs = tuple(pair.bodies for pair in world.violations(query.group, q, query.margins))
    constrained_joints = {entry.get("joint", "") for entry in violations}
    limits = world.limits(query.group)
    joints = _position_names(query, (q < limits.lower) | (q > limits.upper))
    active = ActiveConstraints(
        joints=tuple(name for name in joints if name not in constrained_joints),
        pairs=pairs,
        constraints=tuple(entry["constraint"] for entry in violations),
    )
    if active != ActiveConstraints() or approach_check is None:
        return active
    return approach_check.active_constraints_at(q, 0)


def _active_pairs(world: World, query: GoalQuery, q: Array) -> tuple[tuple[str, str], ...]:
    """Return the body pairs that are at their margins."""
    margins = query.margins
    probe = world.distance_probe(margins)
    full = world.embed(query.group, q)
    near = probe.pairs_within(full, margins.largest + _ACTIVE_TOLERANCE)
    return tuple(
        pair.bodies for pair in near if pair.distance < margins.of(*pair.bodies) + _ACTIVE_TOLERANCE
    )


def _at_limits(world: World, query: GoalQuery, q: Array) -> Any:
    limits = world.limits(query.group)
    return np.minimum(q - limits.lower, limits.upper - q) < _ACTIVE_TOLERANCE


def _position_names(query: GoalQuery, flags: Any) -> tuple[str, ...]:
    return tuple(np.array(query.group.position_names)[flags].tolist())
