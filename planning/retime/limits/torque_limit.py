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
from planning.retime.cells import cut_at, even_edges, num_short
from planning.retime.limits.path_limit import HEADROOM, PathUtilization
from planning.retime.polynomials import norms
from planning.retime.smooth_pieces import evaluated, path_derivatives
from planning.retime.toppra.path_rows import CellPlaces
from planning.world.mechanics.dynamics import GroupDynamics

# Reserve on cells, above the audit's, for peaks between the evaluated parameters of a cell.
_SPARE = 2 * HEADROOM
# Smallest share of the limit that gravity must leave for motion.
_LEAST = 1e-3
# Step of the audit: two samples per this length (joint-space length).
_STEP = 0.1
# Largest speed-up of a damped motion by the audit, in 1 / k, and number of bisections for it.
_QUICKEST, _BISECTIONS = 2.0, 50
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

    def cuts(self, stretch: JointSpline) -> Float64[np.ndarray, " m"]:  # noqa: ARG002  (none ever)
        """Return no cuts: torques jump only at breaks of the path."""
        return np.zeros(0)

    def caps(self, cells: JointSpline) -> Float64[np.ndarray, "cells 2"]:
        """Return no bounds on x: the rows contain them."""
        return np.full((cells.num_pieces, 2), np.inf)

    def rows(self, cells: JointSpline) -> tuple[Array, Array]:
        """Return a and b of a u + b x <= 1 on every cell, each shape (cells, rows).

        For a block of several coordinates the ball is replaced by an inscribed polyhedron.

        Raises:
            RetimingFailed: Gravity alone is too much somewhere.
        """
        places = CellPlaces.of(cells)
        q = _positions(cells, places.pieces, places.local)
        found = self.dynamics.along(q, *places.derivatives)
        at = cells.breaks[places.pieces] + places.local
        ahead, bend = [np.zeros((len(q), 0))], [np.zeros((len(q), 0))]
        for name, indices, limit in self._limited:
            held = found.held[:, indices]
            _require_held(name, norms(held), limit * (1 - _SPARE - _LEAST), at)
            normals, reach = _directions(len(indices))
            room = np.maximum(reach * (1 - _SPARE) * limit - held @ normals.T, _LEAST * limit)
            ahead.append(found.ahead[:, indices] @ normals.T / room)
            bend.append(found.bend[:, indices] @ normals.T / room)
        return places.by_cell(np.concatenate(ahead, axis=1), np.concatenate(bend, axis=1))

    def uses(self, trajectory: TimedTrajectory) -> tuple[PathUtilization, ...]:
        """Return the utilization of each limit by a motion, sampled in small steps.

        Raises:
            RetimingFailed: Gravity alone is too much somewhere.
        """
        steps = cut_at(trajectory, even_edges(trajectory.breaks, num_short(trajectory, _STEP)))
        pieces = np.tile(np.arange(steps.num_pieces), 3)
        local = (np.array([[0.0], [0.5], [1.0]]) * np.diff(steps.breaks)).ravel()
        q = _positions(steps, pieces, local)
        v, vdot = path_derivatives(steps, pieces, local)
        held = self.dynamics.efforts(q, np.zeros_like(v), np.zeros_like(v))
        dragged = self.dynamics.damping * v
        pushed = self.dynamics.efforts(q, v, vdot) - held - dragged
        at = (steps.breaks[pieces] + local) / trajectory.duration
        uses: list[PathUtilization] = []
        for name, indices, limit in self._limited:
            h, d, p = (_between(part[:, indices]) for part in (held, dragged, pushed))
            bound = limit * (1 - HEADROOM)
            _require_held(name, norms(h), bound, _between(at))
            uses.append(PathUtilization(name, _factor(h, d, p, bound), _share(h, d, p, limit)))
        return tuple(uses)

    def shares(self, curve: Curve, times: Float64[np.ndarray, " m"]) -> Mapping[str, Array]:
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
    return curve.manifold.plus(curve.bases[pieces], evaluated(curve.coefficients[pieces], local))


def _between(values: Array) -> Array:
    """Return values at beginnings, middles and ends of steps, and between them, by parabolas."""
    begin, middle, end = np.split(values, 3)
    early, late = (
        0.375 * first + 0.75 * middle - 0.125 * last for first, last in ((begin, end), (end, begin))
    )
    return np.concatenate([begin, middle, end, early, late])


def _factor(held: Array, dragged: Array, pushed: Array, bound: float) -> float:
    """Return a time scaling k from which |held + dragged / k + pushed / k^2| <= bound holds.

    The bound holds at every instant for k or more. Without damping k is the smallest: the positive
    root y = 1 / k^2 of |held + y pushed| = bound, in a form without cancellation. With damping the
    torque is not monotonic in k; the quadratic in z = 1 / k keeps the bound on all of [0, z] if its
    Bernstein coefficients there do.
    """
    if not dragged.any():
        square, along = (np.einsum("ij,ij->i", part, pushed) for part in (pushed, held))
        room = bound**2 - np.einsum("ij,ij->i", held, held)
        root = np.sqrt(along**2 + square * room)
        by_room, by_root = (along + root) / room, square / np.maximum(root - along, _TINY)
        return float(np.sqrt(np.where(along > 0, by_room, by_root).max(initial=0.0)))
    low, high = 0.0, _QUICKEST
    for _ in range(_BISECTIONS):
        z = (low + high) / 2
        middle, end = held + z / 2 * dragged, held + z * dragged + z**2 * pushed
        is_kept = max(norms(middle).max(), norms(end).max()) <= bound
        low, high = (z, high) if is_kept else (low, z)
    return 1 / low


def _share(held: Array, dragged: Array, pushed: Array, limit: float) -> Callable[[float], float]:
    def share(slower: float) -> float:
        return float(norms(held + dragged / slower + pushed / slower**2).max()) / limit

    return share


def _require_held(name: str, torques: Array, bound: float, at: Array) -> None:
    worst = int(np.argmax(torques))
    if torques[worst] > bound:
        message = (
            f"{name} cannot be held still on the path: gravity takes {torques[worst]:.4g} N m or N "
            f"of it at {at[worst]:.3f} of the way, and its limit leaves {bound:.4g}"
        )
        evidence = {
            "limit": "torque",
            "where": name,
            "torque": float(torques[worst]),
            "bound": bound,
            "at": float(at[worst]),
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
