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
from planning.goals.ik.height_constraint import keep_above
from planning.goals.targets.ball_target import BallTarget
from planning.goals.targets.region_target import RegionTarget
from planning.goals.targets.tool_target import ToolTarget
from planning.world.collision.half_spaces import half_space_pairs_of
from planning.world.world import World

type Target = ToolTarget | RegionTarget | BallTarget
# Adds the cost of the distance to a goal to a program, expanded about a configuration q, (nq,).
type Pull = Callable[[GroupProgram, Array], None]

_MAJOR_ITERATIONS = 60
_MAX_ROUNDS = 6
# Distance beyond their margin within which pairs are constrained from the next round on [m].
_NEAR = 0.02
# Extra margin, larger than the solver's tolerance; and the largest margin violation that counts as
# such an inaccuracy [m].
_SLACK, _SMALL = 1e-5, 1e-3
# Step size below which the iteration has converged [rad or m].
_SETTLED = 1e-6
# Largest angle up to which the weight of the cosine cost is matched to the squared angle [rad].
_LARGEST_ANGLE = 3.0


def moved_along(target: Target, reached: Pose) -> Pose:
    """Return X_WG of a target after the displacement of its closest pose onto X_WT."""
    if not target.position_tolerance.any() and not target.rotation_tolerance.any():
        return reached
    return reached @ target.closest(reached).inverse @ target.pose


def pulled(
    world: World,
    query: GoalQuery,
    pull: Pull,
    q: Float64[np.ndarray, " nq"],
    *,
    is_apart: bool = True,
    deadline: Deadline | None = None,
) -> Float64[np.ndarray, " nq"]:
    """Minimize a goal cost from q by sequential quadratic programming (SNOPT), in rounds.

    Each round adds the body pairs that are near. Joint limits always hold. Not promised: a local
    minimum, or a feasible configuration; the caller has to check the result.

    Args:
        world: Loaded scene.
        query: Goal query; of its path constraints only those with an equivalent in Drake count.
        pull: Adds the cost.
        q: Initial guess.
        is_apart: Whether body pairs have to keep their margins.
        deadline: Time limit, after which no further round begins; None for none.
    """
    limits = world.limits(query.group)
    pairs: dict[tuple[Any, Any], float] = {}
    slack = _SLACK
    for _ in range(_MAX_ROUNDS):
        known = len(pairs)
        near, depth = _near_pairs(world, query, q) if is_apart else ({}, -np.inf)
        pairs.update(near)
        # A small margin violation that the solver left is added to the slack of the next round.
        slack += depth + _SLACK if 0 < depth < _SMALL else 0.0
        program = GroupProgram(world, query.group, _MAJOR_ITERATIONS)
        pull(program, q)
        if query.rules is not None:
            add_constraints(program, world, query.rules)
        _keep_apart(program, world, {pair: margin + slack for pair, margin in pairs.items()})
        moved = np.clip(program.solve(q), limits.lower, limits.upper)
        step = float(np.abs(moved - q).max())
        q = moved
        if step < _SETTLED and len(pairs) == known and depth <= 0:
            break
        if deadline is not None and deadline.is_over:
            break
    return q


def to_pose(world: World, query: GoalQuery, target: Target) -> Pull:
    """Return the cost of the pose metric between a tool frame and its closest pose in tolerance.

    Drake's cost of a rotation is c (1 - cos theta); with c = 2 w^2 theta / sin theta at the present
    theta it has the slope of (w theta)^2 there, so both have the same minima on convergence.
    """
    metric = query.options.pose_metric
    frame, origin = world.drake.frame(target.frame), world.drake.plant.world_frame()

    def pull(program: GroupProgram, q: Array) -> None:
        reached = world.frame_pose(target.frame, world.embed(query.group, q))
        wanted = target.closest(reached)
        x_wg = RigidTransform(wanted.matrix)
        weight = metric.translation**2 * np.eye(3)
        program.ik.AddPositionCost(origin, x_wg.translation(), frame, np.zeros(3), weight)
        theta = min(reached.distance(wanted)[1], _LARGEST_ANGLE)
        slope = 2 * metric.rotation**2 / float(np.sinc(theta / np.pi))
        program.ik.AddOrientationCost(origin, x_wg.rotation(), frame, RotationMatrix(), slope)

    return pull


def _keep_apart(program: GroupProgram, world: World, least: dict[tuple[Any, Any], float]) -> None:
    """Add minimum-distance constraints [m] for pairs of geometries."""
    rows = half_space_pairs_of(world.drake).index
    is_known = program.show(least)
    for pair, distance in least.items():
        if pair not in rows and is_known(pair):
            program.ik.AddDistanceConstraint(pair, distance, np.inf)
    heights = {rows[pair]: distance for pair, distance in least.items() if pair in rows}
    if heights:
        keep_above(program, world.drake, heights)


def _near_pairs(
    world: World, query: GoalQuery, q: Array
) -> tuple[dict[tuple[Any, Any], float], float]:
    """Return the margins [m] of geometry pairs near at q, and the largest margin violation [m]."""
    margins = query.margins
    probe = world.distance_probe(margins)
    found = probe.geometries_within(world.embed(query.group, q), margins.largest + _NEAR)
    lacks = [margins.of(*bodies) - distance for _, bodies, distance in found]
    near = {
        pair: margins.of(*bodies)
        for (pair, bodies, distance), lack in zip(found, lacks, strict=True)
        if lack > -_NEAR and np.isfinite(distance)
    }
    return near, max(lacks, default=-np.inf)
