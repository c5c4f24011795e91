"""Strain: a load along a curve at one pace, and how it changes with both: rows of the model."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.refine.basis import weights_at
from planning.refine.load import Load, difference_quotients
from planning.refine.pace import RATE_PRICE, grid_of
from planning.refine.soft_rows import Rows

type Array = np.ndarray[Any, np.dtype[np.float64]]
type Indices = np.ndarray[Any, np.dtype[np.intp]]

# Ratios that are nearer their bounds than this are looked at.
_SEEN = 0.5
# Of what a joint can do, what holding still may take: nothing is timed that cannot be stopped.
MOST_HELD = 0.98
# How far a step may change what a row sums up, in units of its entries: b may grow by half.
_REACH = 1.5
# Of the planes about a vector, from its own [rad].
_TILTS = (0.2, 0.5)
_TINY = 1e-300
_BOTH = np.array([-1.0, 1.0])


@dataclass(frozen=True)
class GridWeights:
    """How r, r' and r'' at the points of the pace's grid depend on control points.

    Attributes:
        owners: The control points that matter, shape (n + 1, 4).
        local: Their weights, shape (3, n + 1, 4).
    """

    owners: Indices
    local: Array


@lru_cache(maxsize=8)
def grid_weights(count: int) -> GridWeights:
    """Return the weights of a number of control points."""
    n = len(grid_of(count).owners)
    found = [weights_at(count, np.arange(n + 1) / n, order) for order in range(3)]
    return GridWeights(found[0].owners, np.stack([weights.local for weights in found]))


@dataclass(frozen=True)
class Strain:
    """One load's ratios at both ends of every interval of the grid, where they are large.

    Attributes:
        places: Which points of the grid, shape (m,).
        intervals: Of which u is, shape (m,).
        now: The ratios, shape (m, rows).
        by_point: Their slopes by coordinates of control points, shape (m, rows, 4, nq).
        by_pace: By b at both ends of the interval, relative to it, shape (m, rows, 2).
        bound: Of the ratios.
        price: Of exceeding the bound by its own size, in durations.
    """

    places: Indices
    intervals: Indices
    now: Array
    by_point: Array
    by_pace: Array
    bound: float = 1.0
    price: float = RATE_PRICE

    @classmethod
    def still(
        cls, load: Load, count: int, q: Float64[np.ndarray, "n_plus_1 nq"], price: float
    ) -> "Strain":
        """Look at what the load asks for without any motion."""
        held = load.held(q)
        places = np.flatnonzero((np.abs(held) > _SEEN).any(axis=1))
        (by_q,) = difference_quotients(load.held, q[places])
        local = grid_weights(count).local[0, places, None, :, None]
        intervals = np.minimum(places, len(q) - 2)
        by_pace = np.zeros((*by_q.shape[:2], 2))
        by_point = local * by_q[:, :, None]
        return cls(places, intervals, held[places], by_point, by_pace, MOST_HELD, price)

    @classmethod
    def of(
        cls,
        load: Load,
        count: int,
        states: Float64[np.ndarray, "3 n_plus_1 nq"],
        b: Float64[np.ndarray, " n_plus_1"],
    ) -> "Strain":
        """Look at the load.

        Args:
            load: Which.
            count: How many control points there are.
            states: r, r' and r'' at the grid's points.
            b: The pace there.
        """
        n, h = len(b) - 1, grid_of(count).step
        intervals = np.repeat(np.arange(n), 2)
        places = intervals + np.tile([0, 1], n)
        u = np.diff(b) / (2 * h)
        motion = _motion(states[:, places], b[places], u[intervals])
        vectors = load.vectors(*motion)
        seen = np.flatnonzero((np.linalg.norm(vectors, axis=2) > _SEEN).any(axis=1))
        places, intervals = places[seen], intervals[seen]
        q, v, vdot = (part[seen] for part in motion)
        normals = _normals(vectors[seen])
        rows = len(seen), normals.shape[1] * normals.shape[2]
        by_q, by_v, by_vdot = (
            np.einsum("mbrd,mbdj->mbrj", normals, part).reshape(*rows, q.shape[1])
            for part in load.slopes(q, v, vdot)
        )
        now = np.einsum("mbrd,mbd->mbr", normals, vectors[seen]).reshape(rows)
        here, push = b[places, None, None], u[intervals, None, None]
        by_first, by_second = np.sqrt(here) * by_v + push * by_vdot, here * by_vdot
        _, rate, curvature = states[:, places]
        # With b its own end's v and vdot change, and with b at both ends u.
        ends = np.einsum("mrj,mj->mr", by_v, v / 2)
        ends += np.einsum("mrj,mj->mr", by_vdot, curvature * b[places, None])
        ahead = np.einsum("mrj,mj->mr", by_vdot, rate)
        around = np.stack([b[intervals], b[intervals + 1]], axis=-1) * _BOTH / (2 * h)
        by_pace = ahead[..., None] * around[:, None]
        by_pace[np.arange(len(seen)), :, places - intervals] += ends
        local = grid_weights(count).local[:, places, None, :, None]
        slopes_by_state = np.stack([by_q, by_first, by_second])[:, :, :, None]
        return cls(places, intervals, now, (local * slopes_by_state).sum(axis=0), by_pace)

    def rows(self, points: Indices, pace: Indices, side: Array) -> Rows:
        """Return the rows that a step can make bind.

        Args:
            points: Columns of the control points' coordinates, shape (k, nq).
            pace: Columns of b, shape (n + 1,).
            side: Of the box around control points, shape (nq,).
        """
        m, rows = self.now.shape
        by_point = (self.by_point * side).reshape(m, rows, 4 * len(side))
        values = np.concatenate([by_point, self.by_pace], axis=2)
        owners = grid_weights(len(points)).owners[self.places]
        around = np.stack([pace[self.intervals], pace[self.intervals + 1]], axis=-1)
        columns = np.concatenate([points[owners].reshape(m, 4 * points.shape[1]), around], axis=1)
        columns = np.broadcast_to(columns[:, None], values.shape)
        bounds = self.bound * _BOTH[:, None, None]
        found = Rows.between(columns, values, self.now, bounds, self.price)
        return found.taken(found.least > -_REACH * np.abs(found.values).sum(axis=1))


def _motion(states: Array, b: Array, u: Array) -> tuple[Array, Array, Array]:
    """Return q, v and vdot along a curve."""
    q, rate, curvature = states
    return q, rate * np.sqrt(b)[:, None], curvature * b[:, None] + rate * u[:, None]


def _normals(vectors: Float64[np.ndarray, "m balls dims"]) -> Float64[np.ndarray, "m balls k dims"]:
    """Return outward normals of planes that touch the unit ball near where vectors point.

    One says how a vector's length changes; those around it keep a step from going far along the
    plane of the first, where it would leave the ball.
    """
    if vectors.shape[2] == 1:
        return np.ones((*vectors.shape, 1))
    ahead = vectors / np.maximum(np.linalg.norm(vectors, axis=2, keepdims=True), _TINY)
    least = np.eye(3)[np.abs(ahead).argmin(axis=2)]
    side = np.cross(ahead, least)
    side /= np.linalg.norm(side, axis=2, keepdims=True)
    up = np.cross(ahead, side)
    around = np.stack([side, up, -side, -up], axis=2)
    tilted = [np.cos(angle) * ahead[:, :, None] + np.sin(angle) * around for angle in _TILTS]
    return np.concatenate([ahead[:, :, None], *tilted], axis=2)
