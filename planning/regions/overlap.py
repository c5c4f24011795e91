"""Where regions overlap, and which of their faces matter."""

from collections.abc import Sequence

import numpy as np
from pydrake.geometry.optimization import HPolyhedron  # pyright: ignore[reportMissingModuleSource]
from pydrake.solvers import ClpSolver, MathematicalProgram

from planning.domain.planner.regions import Portal, Region

# Regions that share no ball of this radius do not overlap [rad or m].
_LEAST = 1e-3


def without_redundant_faces(region: Region) -> Region:
    """Return the region without the faces that say nothing."""
    whole = HPolyhedron(region.normals, region.offsets)
    said = sorted(set(range(len(region.offsets))) - whole.FindRedundant())
    return Region(region.normals[said], region.offsets[said], region.center, region.num_free)


def portals_of(regions: Sequence[Region], newest: int) -> tuple[Portal, ...]:
    """Return where the region of row `newest` overlaps those before it."""
    found = (_portal(regions, row, newest) for row in range(newest))
    return tuple(portal for portal in found if portal is not None)


def _portal(regions: Sequence[Region], first: int, second: int) -> Portal | None:
    """Return the largest ball in two regions, by a linear program (Chebyshev's center)."""
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
    return Portal((first, second), solution.GetSolution(q), size) if size > _LEAST else None
