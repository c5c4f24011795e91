"""Portals (overlaps of two regions) and the removal of redundant faces."""

from collections.abc import Sequence

import numpy as np
from pydrake.geometry.optimization import HPolyhedron  # pyright: ignore[reportMissingModuleSource]
from pydrake.solvers import ClpSolver, MathematicalProgram

from planning.domain.planner.regions import Portal, Region

# Smallest radius of a ball in the intersection that counts as an overlap [rad or m].
_MIN_OVERLAP_RADIUS = 1e-3


def without_redundant_faces(region: Region) -> Region:
    """Return the region without its redundant faces."""
    polyhedron = HPolyhedron(region.normals, region.offsets)
    irredundant = sorted(set(range(len(region.offsets))) - polyhedron.FindRedundant())
    return Region(
        region.normals[irredundant], region.offsets[irredundant], region.center, region.num_free
    )


def portals_of(regions: Sequence[Region], newest: int) -> tuple[Portal, ...]:
    """Return the portals between the region of row `newest` and all regions before it."""
    found = (_portal(regions, row, newest) for row in range(newest))
    return tuple(portal for portal in found if portal is not None)


def _portal(regions: Sequence[Region], first: int, second: int) -> Portal | None:
    """Return the Chebyshev center and radius of the intersection, by linear programming.

    None if the radius is at most `_MIN_OVERLAP_RADIUS`.
    """
    pair = regions[first], regions[second]
    normals = np.concatenate([region.normals for region in pair])
    offsets = np.concatenate([region.offsets for region in pair])
    program = MathematicalProgram()
    q = program.NewContinuousVariables(normals.shape[1])
    radius = program.NewContinuousVariables(1)
    rows = np.column_stack([normals, np.ones(len(normals))])
    unbounded = np.full(len(offsets), -np.inf)
    program.AddLinearConstraint(rows, unbounded, offsets, np.concatenate([q, radius]))
    program.AddLinearCost(np.array([-1.0]), 0.0, radius)
    solution = ClpSolver().Solve(program)
    if not solution.is_success():
        return None
    size = float(solution.GetSolution(radius)[0])
    return (
        Portal((first, second), solution.GetSolution(q), size)
        if size > _MIN_OVERLAP_RADIUS
        else None
    )
