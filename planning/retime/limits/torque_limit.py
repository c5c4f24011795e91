"""TorqueLimit: limits of the joints' torques and forces along a path.

Along r(s) with x = sdot^2 and u = sddot, tau = a u + b x + c (Bobrow, Dubowsky, Gibson, IJRR 1985):
a = M r', b = M r'' + C(r, r') r', c the static load (gravity). A motion that takes k times as long
takes c + (tau - c) / k^2: gravity does not slow down with it.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache
from itertools import product
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.curves.curve import Curve, JointSpline, TimedTrajectory
from planning.domain.robot.joints import JointGroup
from planning.errors import RetimingFailed
from planning.retime.cells import cut_at, even_edges, num_parts
from planning.retime.limits.path_limit import HEADROOM, PathUtilization
from planning.retime.polynomials import norms
from planning.retime.smooth_pieces import evaluate_polynomials, path_derivatives
from planning.retime.toppra.path_rows import CellSamples
from planning.world.mechanics.dynamics import GroupDynamics

# Reserve on cells, above the audit's, for peaks between the evaluated parameters of a cell.
_CELL_RESERVE = 2 * HEADROOM
# Smallest share of the limit that gravity must leave for motion.
_MIN_MOTION_SHARE = 1e-3
# Step of the audit: two samples per this length (joint-space length).
_SAMPLE_SPACING = 0.1
# Largest speed-up of a damped motion by the audit, in 1 / k, and number of bisections for it.
_MAX_SPEEDUP, _BISECTIONS = 2.0, 50
# Smallest divisor; what is divided is zero there.
_TINY = 1e-300


@dataclass(frozen=True)
class TorqueLimit:
    """Torque or force limits of all blocks.

    Attributes:
        group: The joint group.
        dynamics: Inverse dynamics of the group.
        efforts: Limits by block [N m or N], infinite where there is none, shape (num_blocks,).
    """

    group: JointGroup
    dynamics: GroupDynamics
    efforts: Float64[np.ndarray, " num_blocks"]

    @property
    def name(self) -> str:
        """Kind of limit."""
        return "torque"

    @property
    def is_uniform(self) -> bool:
        """False: gravity torques vary along a line."""
        return False

    def discontinuities(self, smooth_piece: JointSpline) -> Float64[np.ndarray, " m"]:  # noqa: ARG002  (none ever)
        """Return no cuts: torques jump only at breaks of the path."""
        return np.zeros(0)

    def path_velocity_bounds(self, cells: JointSpline) -> Float64[np.ndarray, "cells 2"]:
        """Return no bounds on x: the rows contain them."""
        return np.full((cells.num_pieces, 2), np.inf)

    def rows(self, cells: JointSpline) -> tuple[Array, Array]:
        """Return a and b of a u + b x <= 1 on every cell, each shape (cells, rows).

        For a block of several coordinates the ball is replaced by an inscribed polyhedron.

        Raises:
            RetimingFailed: Gravity alone is too much somewhere.
        """
        samples = CellSamples.of(cells)
        q = _positions(cells, samples.pieces, samples.local)
        path_efforts = self.dynamics.path_efforts(q, *samples.derivatives)
        parameters = cells.breaks[samples.pieces] + samples.local
        a, b = [np.zeros((len(q), 0))], [np.zeros((len(q), 0))]
        for name, indices, limit in self._limited:
            static_torques = path_efforts.static[:, indices]
            _validate_static_torques(
                name,
                norms(static_torques),
                limit * (1 - _CELL_RESERVE - _MIN_MOTION_SHARE),
                parameters,
            )
            normals, face_distance = _directions(len(indices))
            remaining = np.maximum(
                face_distance * (1 - _CELL_RESERVE) * limit - static_torques @ normals.T,
                _MIN_MOTION_SHARE * limit,
            )
            a.append(path_efforts.by_path_acceleration[:, indices] @ normals.T / remaining)
            b.append(path_efforts.by_squared_velocity[:, indices] @ normals.T / remaining)
        return samples.rows_by_cell(np.concatenate(a, axis=1), np.concatenate(b, axis=1))

    def utilizations(self, trajectory: TimedTrajectory) -> tuple[PathUtilization, ...]:
        """Return the utilization of each limit by a motion, sampled in small steps.

        Raises:
            RetimingFailed: Gravity alone is too much somewhere.
        """
        steps = cut_at(
            trajectory, even_edges(trajectory.breaks, num_parts(trajectory, _SAMPLE_SPACING))
        )
        pieces = np.tile(np.arange(steps.num_pieces), 3)
        local = (np.array([[0.0], [0.5], [1.0]]) * np.diff(steps.breaks)).ravel()
        q = _positions(steps, pieces, local)
        v, vdot = path_derivatives(steps, pieces, local)
        static_torques = self.dynamics.efforts(q, np.zeros_like(v), np.zeros_like(v))
        damping_torques = self.dynamics.damping * v
        dynamic_torques = self.dynamics.efforts(q, v, vdot) - static_torques - damping_torques
        fractions = _with_midpoints((steps.breaks[pieces] + local) / trajectory.duration)
        parts = [
            _with_midpoints(part) for part in (static_torques, damping_torques, dynamic_torques)
        ]
        utilizations: list[PathUtilization] = []
        for name, indices, limit in self._limited:
            static, damping, dynamic = (part[:, indices] for part in parts)
            bound = limit * (1 - HEADROOM)
            _validate_static_torques(name, norms(static), bound, fractions)
            time_scaling = _required_time_scaling(static, damping, dynamic, bound)
            fraction_at = _fraction_function(static, damping, dynamic, limit)
            utilizations.append(PathUtilization(name, time_scaling, fraction_at))
        return tuple(utilizations)

    def sampled_utilization(
        self, curve: Curve, times: Float64[np.ndarray, " m"]
    ) -> Mapping[str, Array]:
        """Return torque over limit at instants of a motion, by block."""
        efforts = self.dynamics.efforts(
            curve.positions(times), curve.velocities(times), curve.accelerations(times)
        )
        return {name: norms(efforts[:, indices]) / limit for name, indices, limit in self._limited}

    def relaxed(self, where: str, factor: float) -> "TorqueLimit":
        """Return the limits with that of one block multiplied by a factor."""
        efforts = np.array(self.efforts)
        efforts[[name == where for name, _ in self.group.blocks]] *= factor
        return replace(self, efforts=efforts)

    @property
    def _limited(self) -> list[tuple[str, list[int], float]]:
        """Name, coordinates and limit of every limited block."""
        return [
            (name, list(indices), float(limit))
            for (name, indices), limit in zip(self.group.blocks, self.efforts, strict=True)
            if np.isfinite(limit)
        ]


def _positions(curve: Curve, pieces: Any, local: Array) -> Array:
    """Return q on given pieces, also where two of them meet."""
    return curve.manifold.plus(
        curve.bases[pieces], evaluate_polynomials(curve.coefficients[pieces], local)
    )


def _with_midpoints(values: Array) -> Array:
    """Return values at beginnings, middles and ends of steps, and between them, by parabolas."""
    count = len(values) // 3
    begin, middle, end = values[:count], values[count : 2 * count], values[2 * count :]
    early, late = (
        0.375 * first + 0.75 * middle - 0.125 * last for first, last in ((begin, end), (end, begin))
    )
    return np.concatenate([begin, middle, end, early, late])


def _required_time_scaling(static: Array, damping: Array, dynamic: Array, bound: float) -> float:
    """Return a time scaling k from which |static + damping / k + dynamic / k^2| <= bound holds.

    The bound holds at every instant for k or more. Without damping k is the smallest: the positive
    root y = 1 / k^2 of |static + y dynamic| = bound, in a form without cancellation. With damping
    the torque is not monotonic in k; the quadratic in z = 1 / k keeps the bound on all of [0, z] if
    its Bernstein coefficients there do.
    """
    if not damping.any():
        square, along = (np.einsum("ij,ij->i", part, dynamic) for part in (dynamic, static))
        reserve = bound**2 - np.einsum("ij,ij->i", static, static)
        root = np.sqrt(along**2 + square * reserve)
        by_reserve, by_root = (along + root) / reserve, square / np.maximum(root - along, _TINY)
        return float(np.sqrt(np.where(along > 0, by_reserve, by_root).max(initial=0.0)))
    low, high = 0.0, _MAX_SPEEDUP
    for _ in range(_BISECTIONS):
        z = (low + high) / 2
        middle, end = static + z / 2 * damping, static + z * damping + z**2 * dynamic
        is_within_bound = max(norms(middle).max(), norms(end).max()) <= bound
        low, high = (z, high) if is_within_bound else (low, z)
    return 1 / low


def _fraction_function(
    static: Array, damping: Array, dynamic: Array, limit: float
) -> Callable[[float], float]:
    def fraction(time_scaling: float) -> float:
        return (
            float(norms(static + damping / time_scaling + dynamic / time_scaling**2).max()) / limit
        )

    return fraction


def _validate_static_torques(name: str, torques: Array, bound: float, fractions: Array) -> None:
    worst = int(np.argmax(torques))
    if torques[worst] > bound:
        message = (
            f"the static torque of {name} exceeds its effort limit: {torques[worst]:.4g} N m or N "
            f"at fraction {fractions[worst]:.3f} of the path, limit {bound:.4g} after reserves"
        )
        evidence = {
            "limit": "torque",
            "where": name,
            "torque": float(torques[worst]),
            "bound": bound,
            "at": float(fractions[worst]),
        }
        raise RetimingFailed(message, evidence)


@cache
def _directions(dimensions: int) -> tuple[Array, float]:
    """Return unit normals of a polyhedron, a row each, and the distance of its faces to its centre.

    Its corners are within the unit ball: of dimension 1 both ends, of 2 a polygon of 24 sides, of 3
    the normals of a cube's faces, edges and corners.
    """
    if dimensions == 1:
        return np.array([[1.0], [-1.0]]), 1.0
    if dimensions == 2:
        angles = np.arange(24) * np.pi / 12
        return np.stack([np.cos(angles), np.sin(angles)], axis=1), float(np.cos(np.pi / 24))
    signs = np.array(list(product((-1.0, 0.0, 1.0), repeat=3)))
    normals = signs[np.abs(signs).any(axis=1)]
    # The direction equally far from a face's normal, an edge's and a corner's.
    farthest = np.array([1.0, np.sqrt(2) - 1, np.sqrt(3) - np.sqrt(2)])
    return normals / norms(normals)[:, None], float(1 / np.linalg.norm(farthest))
