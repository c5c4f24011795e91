"""Felt: what loads do along one curve, as rows of the pace's program and of the model's."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.refine.bounds import Bounds
from planning.refine.load import MOST_HELD, Load
from planning.refine.moments import Moments, grid_weights
from planning.refine.pace import PaceRows, Rates, fastest_pace, grid_of
from planning.refine.strain import Strain

type Array = np.ndarray[Any, np.dtype[np.float64]]

# What each limit of torque costs, beyond what may be spent on standing still, at every grid point
# [s].
_EXCESS_PRICE = 10.0


@dataclass(frozen=True)
class Felt:
    """What loads do along a curve.

    Attributes:
        count: Of the control points.
        loads: One at least.
        states: r, r' and r'' at the points of the pace's grid, shape (3, n + 1, nq).
        pace_rows: Of all loads.
        excess: What standing still at the grid's points asks for beyond `MOST_HELD`, summed up.
    """

    count: int
    loads: tuple[Load, ...]
    states: Array
    pace_rows: PaceRows
    excess: float

    @classmethod
    def of(cls, points: Float64[np.ndarray, "k nq"], loads: tuple[Load, ...]) -> "Felt":
        """Look at the curve with these control points."""
        weights = grid_weights(len(points))
        states = np.einsum("onk,nkj->onj", weights.local, points[weights.owners])
        found = [load.pace_rows(*states) for load in loads]
        ahead, bend = (np.concatenate(parts, axis=1) for parts in zip(*found, strict=True))
        held = np.concatenate([load.held(states[0]) for load in loads], axis=1)
        excess = float(np.maximum(np.abs(held) - MOST_HELD, 0.0).sum())
        return cls(len(points), loads, states, PaceRows(ahead, bend), excess)

    @property
    def cost(self) -> float:
        """What that excess costs [s]."""
        return _EXCESS_PRICE * self.excess

    def strains(self, b: Float64[np.ndarray, " n_plus_1"], duration: float) -> tuple[Strain, ...]:
        """Return the strains at a pace that takes so long, and those without motion."""
        moments = Moments.of(self.count, self.states, b)
        price = _EXCESS_PRICE * MOST_HELD / duration
        moving = (Strain.of(load, moments) for load in self.loads)
        still = (Strain.still(load, moments, price) for load in self.loads)
        return (*moving, *still)


def pace_along(
    points: Float64[np.ndarray, "k nq"], bounds: Bounds
) -> tuple[Rates, Float64[np.ndarray, " n_plus_1"], Felt | None]:
    """Return a curve's rates, its fastest pace, and what loads do along it, if there are any."""
    grid = grid_of(len(points))
    rates = Rates.of(grid, points, bounds)
    if not bounds.loads:
        return rates, fastest_pace(grid, rates), None
    felt = Felt.of(points, bounds.loads)
    return rates, fastest_pace(grid, rates, felt.pace_rows), felt
