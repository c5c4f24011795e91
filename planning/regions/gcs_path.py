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
_DUPLICATE_TOLERANCE = 1e-6


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

    The same arguments give the same bytes. Not guaranteed: the shortest path of all; only regions
    of the corridor are considered, and rounding may miss the optimum.

    Args:
        regions: Regions and their portals.
        start: Start configuration, shape (nq,).
        goals: Goal configurations, shape (n, nq).
        max_regions: Largest number of regions in one program.
        max_rounded_paths: Number of paths sampled from the relaxation and compared.
    """
    if not regions.containing(start):
        return _no_path("the start is outside of all regions")
    inside = [(row, q) for row, q in enumerate(goals) if regions.containing(q)]
    if not inside:
        return _no_path("every goal is outside of all regions")
    subset = corridor(regions, start, inside, max_regions)
    if subset is None:
        return _no_path("the regions of the start and of the goals are not connected")
    waypoints = _solve(regions, subset, (start, goals[list(subset.goals)]), max_rounded_paths)
    if waypoints is None:
        return GcsPath(np.empty((0, len(start))), -1, subset.rows, "the solver found no path")
    row = min(subset.goals, key=lambda goal: float(np.linalg.norm(goals[goal] - waypoints[-1])))
    return GcsPath(_without_duplicates(waypoints, start, goals[row]), row, subset.rows)


def _no_path(reason: str) -> GcsPath:
    return GcsPath(np.empty((0, 0)), -1, (), reason)


def _solve(
    regions: Regions, subset: Corridor, ends: tuple[Array, Array], max_rounded_paths: int
) -> Array | None:
    """Return the vertices of the path, shape (n, nq)."""
    start, goals = ends
    program = GcsTrajectoryOptimization(len(start))
    sets = [
        HPolyhedron(regions.regions[i].normals, regions.regions[i].offsets) for i in subset.rows
    ]
    directed_pairs = [*subset.pairs, *((j, i) for i, j in subset.pairs)]
    inside = program.AddRegions(sets, directed_pairs, 1, 0.0, 1.0, "inside")
    source = program.AddRegions([Point(start)], [], 0, 0.0, 0.0, "source")
    target = program.AddRegions([Point(goal) for goal in goals], [], 0, 0.0, 0.0, "target")
    source_edges = [(0, index) for index in _indices_containing(regions, subset, start)]
    target_edges = [
        (index, k)
        for k, goal in enumerate(goals)
        for index in _indices_containing(regions, subset, goal)
    ]
    program.AddEdges(source, inside, None, source_edges)
    program.AddEdges(inside, target, None, target_edges)
    inside.AddPathLengthCost(1.0)
    options = GraphOfConvexSetsOptions()
    options.max_rounded_paths = max_rounded_paths
    options.parallelism = Parallelism(1)
    result: tuple[Any, Any] = program.SolvePath(source, target, options)
    trajectory, solution = result
    if not solution.is_success():
        return None
    count = trajectory.get_number_of_segments()
    pieces = [trajectory.segment(k).control_points() for k in range(count)]
    return np.concatenate([np.asarray(piece).T for piece in pieces])


def _indices_containing(regions: Regions, subset: Corridor, q: Array) -> list[int]:
    rows = set(regions.containing(q))
    return [index for index, row in enumerate(subset.rows) if row in rows]


def _without_duplicates(waypoints: Array, start: Array, goal: Array) -> Array:
    """Return the path with the exact start and goal and without duplicate waypoints."""
    inner = [
        q
        for q in waypoints
        if min(np.abs(q - start).max(), np.abs(q - goal).max()) > _DUPLICATE_TOLERANCE
    ]
    path = [start]
    path += [q for q, before in zip(inner, [start, *inner], strict=False) if _differ(q, before)]
    return np.stack([*path, goal])


def _differ(q: Array, other: Array) -> bool:
    return bool(np.abs(q - other).max() > _DUPLICATE_TOLERANCE)
