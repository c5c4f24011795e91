"""LoadEvaluation: loads along one curve, as rows for the path velocity and for the convex model."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.refine.constraints.load import MAX_STATIC_LOAD, Load
from planning.refine.constraints.path_load import PathLoad
from planning.refine.constraints.rate_bounds import RateBounds
from planning.refine.constraints.zone_load import ZoneLoad, ZonePathLoad
from planning.refine.curves.curve_samples import CurveSamples, grid_weights
from planning.refine.curves.native_grid import native_path_velocity
from planning.refine.curves.path_velocity import (
    NormalizedDerivatives,
    minimum_time_path_velocity,
    path_grid,
)
from planning.refine.model.load_linearization import LoadLinearization
from planning.refine.model.path_velocity_constraints import PathVelocityConstraints
from planning.refine.model.zone_linearization import zone_linearizations

# Penalty of static load beyond its largest value, per limit and grid point [s].
_STATIC_LOAD_PENALTY = 10.0


@dataclass(frozen=True)
class LoadEvaluation:
    """Loads along one curve.

    Attributes:
        num_control_points: Number of control points.
        loads: The loads, at least one.
        along: Each load along the curve, in the order of `loads`.
        states_by_num_parts: r, r' and r'' at the ends of parts of the grid's intervals, by the
            number of these parts, shape (3, n parts + 1, nq) each.
        path_velocity_constraints: Constraints of all loads on the path velocity.
        excess: Static load beyond `MAX_STATIC_LOAD`, summed over the samples.
    """

    num_control_points: int
    loads: tuple[Load, ...]
    along: tuple[PathLoad, ...]
    states_by_num_parts: Mapping[int, Array]
    path_velocity_constraints: PathVelocityConstraints
    excess: float

    @classmethod
    def of(cls, points: Float64[np.ndarray, "k nq"], loads: tuple[Load, ...]) -> "LoadEvaluation":
        """Evaluate the loads of the curve with these control points."""
        states = {load.num_parts: _sample_states(points, load.num_parts) for load in loads}
        step = path_grid(len(points)).step
        along = tuple(load.along(*states[load.num_parts]) for load in loads)
        constraints = [
            PathVelocityConstraints.of(step, *part.rows, load.num_parts)
            for load, part in zip(loads, along, strict=True)
        ]
        excess = sum(_static_load_excess(part.static_load) for part in along)
        joined = PathVelocityConstraints.joined(constraints)
        return cls(len(points), loads, along, states, joined, excess)

    @property
    def penalty(self) -> float:
        """Penalty of `excess` [s]."""
        return _STATIC_LOAD_PENALTY * self.excess

    def load_linearizations(
        self, b: Float64[np.ndarray, " n_plus_1"], duration: float
    ) -> tuple[LoadLinearization, ...]:
        """Return the linearizations of loads at a path velocity b, and those of static loads."""
        samples = {
            num_parts: CurveSamples.of(self.num_control_points, states, b, num_parts)
            for num_parts, states in self.states_by_num_parts.items()
        }
        penalty = _STATIC_LOAD_PENALTY * MAX_STATIC_LOAD / duration
        all_loads = [
            (load, part, samples[load.num_parts])
            for load, part in zip(self.loads, self.along, strict=True)
        ]
        dynamic_loads = [part for each in all_loads for part in _linearizations(*each)]
        static_loads = [LoadLinearization.of_static_load(*each, penalty) for each in all_loads]
        return (*dynamic_loads, *(each for each in static_loads if each is not None))


def _linearizations(
    load: Load, along: PathLoad, samples: CurveSamples
) -> tuple[LoadLinearization, ...]:
    if isinstance(load, ZoneLoad) and isinstance(along, ZonePathLoad):
        return zone_linearizations(load, along, samples)
    return (LoadLinearization.of(load, along, samples),)


def _sample_states(points: Float64[np.ndarray, "k nq"], num_parts: int) -> Array:
    return grid_weights(len(points), num_parts).along(points)


def _static_load_excess(static_loads: Float64[np.ndarray, "m k"]) -> float:
    if not static_loads.size:
        return 0.0
    return float(np.maximum(np.abs(static_loads) - MAX_STATIC_LOAD, 0.0).sum())


def path_velocity_along(
    points: Float64[np.ndarray, "k nq"], bounds: RateBounds
) -> tuple[Float64[np.ndarray, " n_plus_1"], LoadEvaluation | None]:
    """Return a curve's minimum-time path velocity, and its loads if any."""
    loads = LoadEvaluation.of(points, bounds.loads) if bounds.loads else None
    constraints = None if loads is None else loads.path_velocity_constraints
    path_velocity = native_path_velocity(points, bounds, constraints)
    if path_velocity is None:
        grid = path_grid(len(points))
        derivatives = NormalizedDerivatives.of(grid, points, bounds)
        path_velocity = minimum_time_path_velocity(grid, derivatives, constraints)
    return path_velocity, loads
