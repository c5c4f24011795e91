"""LoadEvaluation: loads along one curve, as rows of the path velocity's program and the model's."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64

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

type Array = np.ndarray[Any, np.dtype[np.float64]]

# What each limit of torque costs, beyond what may be spent on standing still, at every grid point
# [s].
_EXCESS_PRICE = 10.0


@dataclass(frozen=True)
class LoadEvaluation:
    """What loads do along a curve.

    Attributes:
        count: Of the control points.
        loads: One at least.
        states: r, r' and r'' at the ends of parts of the grid's intervals, by the number of these
            parts, shape (3, n parts + 1, nq) each.
        pace_rows: Of all loads.
        excess: What standing still at the grid's points asks for beyond `MOST_HELD`, summed up.
    """

    count: int
    loads: tuple[Load, ...]
    states: Mapping[int, Array]
    pace_rows: PathVelocityConstraints
    excess: float

    @classmethod
    def of(cls, points: Float64[np.ndarray, "k nq"], loads: tuple[Load, ...]) -> "LoadEvaluation":
        """Look at the curve with these control points."""
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
        """What that excess costs [s]."""
        return _EXCESS_PRICE * self.excess

    def strains(
        self, b: Float64[np.ndarray, " n_plus_1"], duration: float
    ) -> tuple[LoadLinearization, ...]:
        """Return the strains at a pace that takes so long, and those without motion."""
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
    """Return a curve's rates, its fastest pace, and what loads do along it, if there are any."""
    grid = grid_of(len(points))
    rates = NormalizedDerivatives.of(grid, points, bounds)
    if not bounds.loads:
        return rates, minimum_time_path_velocity(grid, rates), None
    felt = LoadEvaluation.of(points, bounds.loads)
    return rates, minimum_time_path_velocity(grid, rates, felt.pace_rows), felt
