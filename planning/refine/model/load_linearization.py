"""LoadLinearization: a load along one curve at one path velocity, linearized in both."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array, Flags, Indices
from planning.refine.constraints.load import MOST_HELD, Load, difference_quotients
from planning.refine.curves.curve_samples import CurveSamples
from planning.refine.model.path_velocity_rows import RATE_PENALTY
from planning.refine.model.penalty_qp import PenaltyRows

# Load ratios below this have no row.
_SEEN = 0.5
# The same for static loads, which change with the curve alone.
_HELD_SEEN = 0.75
# Largest change of a row's sum by a step, in units of its entries: b may grow by half.
_REACH = 1.5
# Angles between the normals of tangent planes and the vector itself [rad].
_TILTS = (0.2, 0.5)
# A tangent plane bounds a ball on one side; a scalar is bounded on both.
_ABOVE, _EITHER = (1.0,), (1.0, -1.0)


@dataclass(frozen=True)
class LoadLinearization:
    """Large ratios of one load at samples on every interval of the grid, with derivatives.

    Attributes:
        places: Indices of the samples, shape (m,).
        owners: Indices of the control points with nonzero weight there, shape (m, 4).
        intervals: Index of each sample's interval, which has its u, shape (m,).
        now: Load ratios, shape (m, rows).
        by_point: Their derivatives by coordinates of control points, shape (m, rows, 4, nq).
        by_pace: By b at both ends of the interval, times b, shape (m, rows, 2).
        is_told: Mask of the rows to use, without duplicates, shape (m, rows).
        sides: Signs with a bound: above, or above and below.
        bound: Of the ratios.
        price: Penalty of exceeding the bound by its own size, in durations.
    """

    places: Indices
    owners: Indices
    intervals: Indices
    now: Array
    by_point: Array
    by_pace: Array
    is_told: Flags
    sides: tuple[float, ...]
    bound: float = 1.0
    price: float = RATE_PENALTY

    @classmethod
    def of(cls, load: Load, moments: CurveSamples) -> "LoadLinearization":
        """Linearize the load of a motion."""
        vectors = load.vectors(*moments.motion)
        seen = np.flatnonzero((np.linalg.norm(vectors, axis=2) > _SEEN).any(axis=1))
        vectors, moments = vectors[seen], moments.taken(seen)
        normals = _normals(vectors)
        rows = len(seen), normals.shape[1] * normals.shape[2]
        by_q, by_v, by_vdot = (
            np.einsum("mbrd,mbdj->mbrj", normals, part).reshape(*rows, part.shape[-1])
            for part in load.slopes(*moments.motion)
        )
        return cls(
            moments.places,
            moments.owners,
            moments.intervals,
            np.einsum("mbrd,mbd->mbr", normals, vectors).reshape(rows),
            moments.by_point(by_q, by_v, by_vdot),
            moments.by_pace(by_v, by_vdot),
            # Rows that do not depend on u are equal on both sides of a grid point.
            by_vdot.any(axis=2) | (moments.shares < 1)[:, None],
            _EITHER if vectors.shape[2] == 1 else _ABOVE,
        )

    @classmethod
    def still(cls, load: Load, moments: CurveSamples, price: float) -> "LoadLinearization":
        """Linearize the static load."""
        moments = moments.taken(np.flatnonzero(moments.shares == 1))
        held = load.held(moments.states[0])
        seen = np.flatnonzero((np.abs(held) > _HELD_SEEN).any(axis=1))
        moments = moments.taken(seen)
        (by_q,) = difference_quotients(load.held, moments.states[0])
        none = np.zeros_like(by_q)
        by_point, by_pace = moments.by_point(by_q, none, none), moments.by_pace(none, none)
        ends = moments.places, moments.owners, moments.intervals
        told = np.ones(by_q.shape[:2], dtype=bool)
        return cls(*ends, held[seen], by_point, by_pace, told, _EITHER, MOST_HELD, price)

    def rows(self, points: Indices, pace: Indices, side: Array) -> PenaltyRows:
        """Return the rows that can bind within a step.

        Args:
            points: Columns of the control points' coordinates, shape (k, nq).
            pace: Columns of b, shape (n + 1,).
            side: Half of the box's sides around control points, shape (nq,).
        """
        m, rows = self.now.shape
        by_point = (self.by_point * side).reshape(m, rows, 4 * len(side))
        values = np.concatenate([by_point, self.by_pace], axis=2)[self.is_told]
        around = np.stack([pace[self.intervals], pace[self.intervals + 1]], axis=-1)
        owned = points[self.owners].reshape(m, 4 * points.shape[1])
        columns = np.repeat(
            np.concatenate([owned, around], axis=1), self.is_told.sum(axis=1), axis=0
        )
        now = self.now[self.is_told]
        reach = _REACH * np.abs(values).sum(axis=1) / self.bound
        found: list[PenaltyRows] = []
        for sign in self.sides:
            least = sign * now / self.bound - 1
            near = least > -reach
            wanted = -sign * values[near] / self.bound
            found.append(PenaltyRows(columns[near], wanted, least[near], self.price))
        return PenaltyRows.stacked(found)


def _normals(vectors: Float64[np.ndarray, "m balls dims"]) -> Float64[np.ndarray, "m balls k dims"]:
    """Return outward normals of planes tangent to the unit ball near the vectors' directions.

    The first is along the vector and linearizes its length; those around it keep a step from moving
    far along the first plane, where it would leave the ball.
    """
    if vectors.shape[2] == 1:
        return np.ones((*vectors.shape, 1))
    length = np.linalg.norm(vectors, axis=2, keepdims=True)
    ahead = np.where(length > 0, vectors, np.eye(3)[0]) / np.where(length > 0, length, 1.0)
    least = np.eye(3)[np.abs(ahead).argmin(axis=2)]
    side = np.cross(ahead, least)
    side /= np.linalg.norm(side, axis=2, keepdims=True)
    up = np.cross(ahead, side)
    around = np.stack([side, up, -side, -up], axis=2)
    tilted = [np.cos(angle) * ahead[:, :, None] + np.sin(angle) * around for angle in _TILTS]
    return np.concatenate([ahead[:, :, None], *tilted], axis=2)
