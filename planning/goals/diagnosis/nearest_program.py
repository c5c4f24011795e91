"""Drake's program for what is nearest to a goal: joint limits kept, bodies kept apart."""

from collections.abc import Callable
from typing import Any

import numpy as np
from jaxtyping import Float64
from pydrake.math import RigidTransform, RotationMatrix

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

type Array = np.ndarray[Any, np.dtype[np.float64]]
type Target = ToolTarget | RegionTarget | BallTarget
# Adds to a program what draws it to a goal from where it is, q of shape (nq,).
type Pull = Callable[[GroupProgram, Array], None]

_MAJOR_ITERATIONS = 60
_MAX_ROUNDS = 6
# Pairs nearer than their margin and this are constrained from the next round on [m].
_NEAR = 0.02
# Demanded beyond the margins, so that what the solver may miss does no harm; and how deep a
# collision may be to be that [m].
_SLACK, _SMALL = 1e-5, 1e-3
# A step smaller than this is the last one [rad or m].
_SETTLED = 1e-6
# Where the angle's cost is no longer like the cosine's, its weight grows no further [rad].
_LARGEST_ANGLE = 3.0


def moved_along(target: Target, reached: Pose) -> Pose:
    """Return X_WG of a target that is moved as far as its closest pose is from X_WT."""
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
    """Return where sequential quadratic programming (SNOPT) leads q on its way to a goal.

    A local minimum of the distance if all goes well; whoever asks checks what it is. Bodies are
    kept apart unless `is_apart` is False; limits are always kept, and rules that a program can be
    told. After the deadline there are no more rounds.
    """
    limits = world.limits(query.group)
    pairs: dict[tuple[Any, Any], float] = {}
    slack = _SLACK
    for _ in range(_MAX_ROUNDS):
        known = len(pairs)
        near, depth = _near_pairs(world, query, q) if is_apart else ({}, -np.inf)
        pairs.update(near)
        # What the solver leaves is made up for, once it is little.
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
    """Return the pull of a tool frame to the pose within tolerance that is closest to where it is.

    Drake's cost of a rotation is c (1 - cos theta); with c = 2 w^2 theta / sin theta at the present
    theta it has the slope of (w theta)^2 there, so both have the same minima once settled.
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
    """Keep pairs of geometries at least so far apart [m]."""
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
    """Return the margins of the pairs of geometries that are near at q, and the largest lack."""
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
