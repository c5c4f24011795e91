"""Nonlinear program (SQP) for the feasible configuration nearest to a goal, built on Drake."""

from collections.abc import Callable
from typing import Any

import numpy as np
from jaxtyping import Float64
from pydrake.math import RigidTransform, RotationMatrix

from planning.domain.arrays import Array
from planning.domain.geometry.pose import Pose
from planning.domain.request.deadline import Deadline
from planning.goals.goal_query import GoalQuery
from planning.goals.ik.constraint_program import add_constraints
from planning.goals.ik.group_program import GroupProgram
from planning.goals.ik.height_constraint import add_height_constraints
from planning.goals.targets.ball_target import BallTarget
from planning.goals.targets.region_target import RegionTarget
from planning.goals.targets.tool_target import ToolTarget
from planning.world.collision.half_spaces import half_space_pairs_of
from planning.world.world import World

type Target = ToolTarget | RegionTarget | BallTarget
# Adds the cost of the distance to a goal to a program, expanded about a configuration q, (nq,).
type AddCost = Callable[[GroupProgram, Array], None]

_MAJOR_ITERATIONS = 60
_MAX_ROUNDS = 6
# Distance beyond their margin within which pairs are constrained from the next round on [m].
_INFLUENCE_DISTANCE = 0.02
# Extra margin, larger than the solver's tolerance; and the largest margin violation that counts as
# such an inaccuracy [m].
_SLACK, _MAX_INACCURACY = 1e-5, 1e-3
# Step size below which the iteration has converged [rad or m].
_STEP_TOLERANCE = 1e-6
# Largest angle at which the weight of the cosine cost is matched to the squared angle [rad].
_LARGEST_ANGLE = 3.0


def displaced_target_pose(target: Target, tool_pose: Pose) -> Pose:
    """Return X_WG of a target after the displacement of its closest pose onto X_WT."""
    if not target.position_tolerance.any() and not target.rotation_tolerance.any():
        return tool_pose
    return tool_pose @ target.closest(tool_pose).inverse @ target.pose


def minimize_cost(
    world: World,
    query: GoalQuery,
    add_cost: AddCost,
    q: Float64[np.ndarray, " nq"],
    *,
    is_collision_constrained: bool = True,
    deadline: Deadline | None = None,
) -> Float64[np.ndarray, " nq"]:
    """Minimize a goal cost from q by sequential quadratic programming (SNOPT), in rounds.

    Each round adds the body pairs that are near. Joint limits always hold. Not promised: a local
    minimum, or a feasible configuration; the caller has to check the result.

    Args:
        world: Loaded scene.
        query: Goal query; of its path constraints only those with an equivalent in Drake count.
        add_cost: Adds the cost.
        q: Initial guess.
        is_collision_constrained: Whether body pairs have to keep their margins.
        deadline: Time limit, after which no further round begins; None for none.
    """
    limits = world.limits(query.group)
    pairs: dict[tuple[Any, Any], float] = {}
    slack = _SLACK
    for _ in range(_MAX_ROUNDS):
        num_known = len(pairs)
        near, depth = _near_pairs(world, query, q) if is_collision_constrained else ({}, -np.inf)
        pairs.update(near)
        # A small margin violation that the solver left is added to the slack of the next round.
        slack += depth + _SLACK if 0 < depth < _MAX_INACCURACY else 0.0
        program = GroupProgram(world, query.group, _MAJOR_ITERATIONS)
        add_cost(program, q)
        if query.constraints is not None:
            add_constraints(program, world, query.constraints)
        _add_distance_constraints(
            program, world, {pair: margin + slack for pair, margin in pairs.items()}
        )
        next_q = np.clip(program.solve(q), limits.lower, limits.upper)
        step = float(np.abs(next_q - q).max())
        q = next_q
        if step < _STEP_TOLERANCE and len(pairs) == num_known and depth <= 0:
            break
        if deadline is not None and deadline.is_over:
            break
    return q


def pose_distance_cost(world: World, query: GoalQuery, target: Target) -> AddCost:
    """Return the cost of the pose metric between a tool frame and its closest pose in tolerance.

    Drake's cost of a rotation is c (1 - cos theta); with c = 2 w^2 theta / sin theta at the present
    theta it has the slope of (w theta)^2 there, so both have the same minima on convergence. w is
    the rotation weight of the metric.
    """
    metric = query.options.pose_metric
    frame, origin = world.drake.frame(target.frame), world.drake.plant.world_frame()

    def add_cost(program: GroupProgram, q: Array) -> None:
        tool_pose = world.frame_pose(target.frame, world.embed(query.group, q))
        desired = target.closest(tool_pose)
        x_wg = RigidTransform(desired.matrix)
        weight = metric.translation**2 * np.eye(3)
        program.ik.AddPositionCost(origin, x_wg.translation(), frame.frame, frame.origin, weight)
        theta = min(tool_pose.distance(desired)[1], _LARGEST_ANGLE)
        c = 2 * metric.rotation**2 / float(np.sinc(theta / np.pi))
        R_FT = RotationMatrix(frame.rotation)
        program.ik.AddOrientationCost(origin, x_wg.rotation(), frame.frame, R_FT, c)

    return add_cost


def _add_distance_constraints(
    program: GroupProgram, world: World, min_distances: dict[tuple[Any, Any], float]
) -> None:
    """Add minimum-distance constraints [m] for pairs of geometries."""
    half_space_rows = half_space_pairs_of(world.drake).row_by_ids
    is_registered = program.register_geometries(min_distances)
    for pair, distance in min_distances.items():
        if pair not in half_space_rows and is_registered(pair):
            program.ik.AddDistanceConstraint(pair, distance, np.inf)
    heights = {
        half_space_rows[pair]: distance
        for pair, distance in min_distances.items()
        if pair in half_space_rows
    }
    if heights:
        add_height_constraints(program, world.drake, heights)


def _near_pairs(
    world: World, query: GoalQuery, q: Array
) -> tuple[dict[tuple[Any, Any], float], float]:
    """Return the margins [m] of geometry pairs near at q, and the largest margin violation [m]."""
    margins = query.margins
    probe = world.distance_probe(margins)
    pairs = probe.geometries_within(
        world.embed(query.group, q), margins.largest + _INFLUENCE_DISTANCE
    )
    violations = [margins.of(*bodies) - distance for _, bodies, distance in pairs]
    near = {
        pair: margins.of(*bodies)
        for (pair, bodies, distance), violation in zip(pairs, violations, strict=True)
        if violation > -_INFLUENCE_DISTANCE and np.isfinite(distance)
    }
    return near, max(violations, default=-np.inf)
