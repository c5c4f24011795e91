"""GcsPath: shortest polyline from a start to a goal inside regions, by graph of convex sets (GCS).

Marcucci et al. (2023), "Motion planning around obstacles with convex optimization", as implemented
by Drake: a path visits regions that overlap, and has one straight piece in each. The choice of the
regions is a shortest-path problem whose convex relaxation is rounded; the polyline through the
chosen regions is then optimal.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64
from pydrake.common import Parallelism
from pydrake.geometry.optimization import GraphOfConvexSetsOptions, HPolyhedron, Point  # pyright: ignore[reportMissingModuleSource]
from pydrake.planning import GcsTrajectoryOptimization

from planning.domain.arrays import Array
from planning.domain.planner.regions import Regions
from planning.regions.corridor import Corridor, corridor

# Waypoints that differ by less are duplicates [rad or m].
_SAME = 1e-6


@dataclass(frozen=True)
class GcsPath:
    """Polyline inside regions, or the reason why there is none.

    Attributes:
        waypoints: Vertices from the start to a goal, shape (n, nq); n = 0 without a path.
        goal_row: Row of the goal that is reached, or -1.
        rows: Rows of the regions in the program.
        reason: Reason why there is no path, or "".
    """

    waypoints: Array
    goal_row: int
    rows: tuple[int, ...]
    reason: str = ""


def shortest_inside(
    regions: Regions,
    start: Float64[np.ndarray, " nq"],
    goals: Float64[np.ndarray, "n nq"],
    *,
    max_regions: int,
    max_rounded_paths: int,
) -> GcsPath:
    """Return the shortest path of the rounded relaxation, or the reason why there is none.

    The same arguments give the same bytes. Not promised: the shortest path of all; only regions of
    the corridor are considered, and rounding may miss the optimum.

    Args:
        regions: Regions and their portals.
        start: Start configuration, shape (nq,).
        goals: Goal configurations, shape (n, nq).
        max_regions: Largest number of regions in one program.
        max_rounded_paths: Number of paths sampled from the relaxation and compared.
    """
    if not regions.containing(start):
        return _none("the start is outside of all regions")
    inside = [(row, q) for row, q in enumerate(goals) if regions.containing(q)]
    if not inside:
        return _none("every goal is outside of all regions")
    where = corridor(regions, start, inside, max_regions)
    if where is None:
        return _none("the regions of the start and of the goals are not connected")
    waypoints = _solve(regions, where, (start, goals[list(where.goals)]), max_rounded_paths)
    if waypoints is None:
        return GcsPath(np.empty((0, len(start))), -1, where.rows, "the solver found no path")
    row = min(where.goals, key=lambda goal: float(np.linalg.norm(goals[goal] - waypoints[-1])))
    return GcsPath(_tidied(waypoints, start, goals[row]), row, where.rows)


def _none(reason: str) -> GcsPath:
    return GcsPath(np.empty((0, 0)), -1, (), reason)


def _solve(
    regions: Regions, where: Corridor, ends: tuple[Array, Array], max_rounded_paths: int
) -> Array | None:
    """Return the vertices of the path, shape (n, nq)."""
    start, goals = ends
    program = GcsTrajectoryOptimization(len(start))
    sets = [HPolyhedron(regions.regions[i].normals, regions.regions[i].offsets) for i in where.rows]
    both_ways = [*where.pairs, *((j, i) for i, j in where.pairs)]
    inside = program.AddRegions(sets, both_ways, 1, 0.0, 1.0, "inside")
    source = program.AddRegions([Point(start)], [], 0, 0.0, 0.0, "source")
    target = program.AddRegions([Point(goal) for goal in goals], [], 0, 0.0, 0.0, "target")
    near = [(0, place) for place in _holding(regions, where, start)]
    far = [(place, k) for k, goal in enumerate(goals) for place in _holding(regions, where, goal)]
    program.AddEdges(source, inside, None, near)
    program.AddEdges(inside, target, None, far)
    inside.AddPathLengthCost(1.0)
    options = GraphOfConvexSetsOptions()
    options.max_rounded_paths = max_rounded_paths
    options.parallelism = Parallelism(1)
    found: tuple[Any, Any] = program.SolvePath(source, target, options)
    trajectory, solution = found
    if not solution.is_success():
        return None
    count = trajectory.get_number_of_segments()
    pieces = [trajectory.segment(k).control_points() for k in range(count)]
    return np.concatenate([np.asarray(piece).T for piece in pieces])


def _holding(regions: Regions, where: Corridor, q: Array) -> list[int]:
    rows = set(regions.containing(q))
    return [place for place, row in enumerate(where.rows) if row in rows]


def _tidied(waypoints: Array, start: Array, goal: Array) -> Array:
    """Return the path with the exact start and goal and without duplicate waypoints."""
    inner = [q for q in waypoints if min(np.abs(q - start).max(), np.abs(q - goal).max()) > _SAME]
    kept = [start]
    kept += [q for q, before in zip(inner, [start, *inner], strict=False) if _differ(q, before)]
    return np.stack([*kept, goal])


def _differ(q: Array, other: Array) -> bool:
    return bool(np.abs(q - other).max() > _SAME)
