"""LoadEvaluation: loads along one curve, as rows for the path velocity and for the convex model."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.refine.constraints.load import MOST_HELD, Load
from planning.refine.constraints.rate_bounds import RateBounds
from planning.refine.curves.curve_samples import CurveSamples, grid_weights
from planning.refine.curves.path_velocity import (
    NormalizedDerivatives,
    grid_of,
    minimum_time_path_velocity,
)
from planning.refine.model.load_linearization import LoadLinearization
from planning.refine.model.path_velocity_rows import PathVelocityConstraints

# Penalty of static load beyond its largest value, per limit and grid point [s].
_EXCESS_PRICE = 10.0


@dataclass(frozen=True)
class LoadEvaluation:
    """Loads along one curve.

    Attributes:
        count: Number of control points.
        loads: At least one.
        states: r, r' and r'' at the ends of parts of the grid's intervals, by the number of these
            parts, shape (3, n parts + 1, nq) each.
        pace_rows: Constraints of all loads on the path velocity.
        excess: Static load beyond `MOST_HELD`, summed over the samples.
    """

    count: int
    loads: tuple[Load, ...]
    states: Mapping[int, Array]
    pace_rows: PathVelocityConstraints
    excess: float

    @classmethod
    def of(cls, points: Float64[np.ndarray, "k nq"], loads: tuple[Load, ...]) -> "LoadEvaluation":
        """Evaluate the loads of the curve with these control points."""
        states = {load.parts: _states(points, load.parts) for load in loads}
        step = grid_of(len(points)).step
        found = [
            PathVelocityConstraints.of(step, *load.pace_rows(*states[load.parts]), load.parts)
            for load in loads
        ]
        excess = sum(_excess(load.held(states[load.parts][0])) for load in loads)
        return cls(len(points), loads, states, PathVelocityConstraints.joined(found), excess)

    @property
    def cost(self) -> float:
        """Penalty of that excess [s]."""
        return _EXCESS_PRICE * self.excess

    def strains(
        self, b: Float64[np.ndarray, " n_plus_1"], duration: float
    ) -> tuple[LoadLinearization, ...]:
        """Return the linearizations of loads at a path velocity b, and those of static loads."""
        moments = {
            parts: CurveSamples.of(self.count, states, b, parts)
            for parts, states in self.states.items()
        }
        price = _EXCESS_PRICE * MOST_HELD / duration
        moving = (LoadLinearization.of(load, moments[load.parts]) for load in self.loads)
        still = (LoadLinearization.still(load, moments[load.parts], price) for load in self.loads)
        return (*moving, *still)


def _states(points: Float64[np.ndarray, "k nq"], parts: int) -> Array:
    weights = grid_weights(len(points), parts)
    return np.einsum("onk,nkj->onj", weights.local, points[weights.owners])


def _excess(held: Float64[np.ndarray, "m k"]) -> float:
    return float(np.maximum(np.abs(held) - MOST_HELD, 0.0).sum())


def path_velocity_along(
    points: Float64[np.ndarray, "k nq"], bounds: RateBounds
) -> tuple[NormalizedDerivatives, Float64[np.ndarray, " n_plus_1"], LoadEvaluation | None]:
    """Return a curve's derivatives, its minimum-time path velocity, and its loads if any."""
    grid = grid_of(len(points))
    rates = NormalizedDerivatives.of(grid, points, bounds)
    if not bounds.loads:
        return rates, minimum_time_path_velocity(grid, rates), None
    felt = LoadEvaluation.of(points, bounds.loads)
    return rates, minimum_time_path_velocity(grid, rates, felt.pace_rows), felt
