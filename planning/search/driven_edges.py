"""DrivenEdges: edges of a group with a car in it, which are drives and no straight lines."""

from collections.abc import Callable
from typing import Any, override

import numpy as np
from jaxtyping import Bool, Float64

from planning.domain.motion_samples import fraction_batches, steps_of
from planning.search.drives import Drives
from planning.search.edges import EdgeChecker
from planning.search.oracle import WatchedOracle

type Array = np.ndarray[Any, np.dtype[np.float64]]

# What a bound may be passed by [m]; the certifier forgives more.
_DUST = 1e-9


class DrivenEdges(EdgeChecker):
    """Checks drives against an oracle, and against the bounds of x and y.

    Bounds hold on the whole way: an arc goes farthest where it heads along an axis, so these
    places are looked at. Of obstacles nothing is promised between two samples.
    """

    def __init__(
        self,
        drives: Drives,
        oracle: WatchedOracle,
        resolution: float,
        norm: Callable[[Array], Array],
        bounds: tuple[Float64[np.ndarray, " nq"], Float64[np.ndarray, " nq"]],
    ) -> None:
        """Make a checker that has checked nothing yet; `bounds` are those of q."""
        super().__init__(drives.manifold, oracle, resolution, norm)
        self._drives = drives
        self._oracle = oracle
        place = slice(drives.iq, drives.iq + 2)
        self._lower, self._upper = bounds[0][place], bounds[1][place]

    @override
    def way(self, q0: Float64[np.ndarray, " nq"], q1: Float64[np.ndarray, " nq"]) -> Array:
        """Return the waypoints of the drive, shape (k, nq)."""
        return self._drives.way(q0, q1)

    @override
    def is_free(self, q0: Float64[np.ndarray, " nq"], q1: Float64[np.ndarray, " nq"]) -> bool:
        """Return whether all samples of the drive are free, q1's included, q0's not."""
        self.num_motions += 1
        way = self.way(q0, q1)
        if not self._stays_inside(way):
            return False
        samples = self._samples(way)
        count = len(samples)
        for fractions in fraction_batches(count):
            rows = np.rint(fractions * count).astype(int) - 1
            if not self._oracle.are_free(samples[rows]).all():
                return False
        return True

    @override
    def is_whole_edge_free(self, q0: list[float], q1: list[float]) -> bool:
        """Return whether all samples of the drive are free, both ends included."""
        begin = np.array(q0)
        return self._oracle.is_free(begin) and self.is_free(begin, np.array(q1))

    @override
    def are_free(
        self, q0s: Float64[np.ndarray, "m nq"], q1s: Float64[np.ndarray, "m nq"]
    ) -> Bool[np.ndarray, " m"]:
        """Return the same as `is_free` for each pair of rows."""
        return np.array([self.is_free(q0, q1) for q0, q1 in zip(q0s, q1s, strict=True)], dtype=bool)

    @override
    def lengths(
        self, q0s: Float64[np.ndarray, "*#m nq"], q1s: Float64[np.ndarray, "*#m nq"]
    ) -> Float64[np.ndarray, "*m"]:
        """Return the measures of the drives between rows, by `norm`."""
        q0s, q1s = np.broadcast_arrays(q0s, q1s)
        nq = q0s.shape[-1]
        tangents = self._drives.tangents(q0s.reshape(-1, nq), q1s.reshape(-1, nq))
        return self.norm(tangents).sum(axis=1).reshape(q0s.shape[:-1])

    def at_a_glance(
        self, q0s: Float64[np.ndarray, "m nq"], q1s: Float64[np.ndarray, "m nq"]
    ) -> tuple[Float64[np.ndarray, " m"], Bool[np.ndarray, " m"]]:
        """Return the measures of the drives between rows, and which of them seem to be free.

        Those are looked at in the middle and at the end of every arc and line of theirs.
        """
        tangents = self._drives.tangents(q0s, q1s)
        looks: list[Array] = []
        q = q0s
        for half in np.repeat(tangents, 2, axis=1).transpose(1, 0, 2) / 2:
            q = self.manifold.plus(q, half)
            looks.append(q)
        qs = np.concatenate(looks)
        spots = qs[:, self._drives.iq : self._drives.iq + 2]
        free = ((spots >= self._lower - _DUST) & (spots <= self._upper + _DUST)).all(axis=1)
        free[free] = self._oracle.are_free(qs[free])
        return self.norm(tangents).sum(axis=1), free.reshape(len(looks), -1).all(axis=0)

    def _samples(self, way: Array) -> Array:
        """Return configurations on a drive that are near enough to one another, but its first."""
        deltas = self.manifold.minus(way[1:], way[:-1])
        steps = steps_of(deltas, self.resolution)
        edge = np.repeat(np.arange(len(steps)), steps)
        place = np.arange(len(edge)) - np.repeat(np.cumsum(steps) - steps, steps) + 1
        return self.manifold.plus(way[edge], (place / steps[edge])[:, None] * deltas[edge])

    def _stays_inside(self, way: Array) -> bool:
        deltas = self.manifold.minus(way[1:], way[:-1])
        yaw, turn = way[:-1, self._drives.iq + 2], deltas[:, self._drives.iv + 2]
        first = np.ceil(np.minimum(yaw, yaw + turn) / (np.pi / 2))
        is_arc = np.abs(turn) > _DUST
        safe = np.where(is_arc, turn, 1.0)
        places = [way]
        # An arc of less than half a turn heads along an axis twice at most.
        for k in (first, first + 1):
            share = (k * np.pi / 2 - yaw) / safe
            rows = np.flatnonzero(is_arc & (share >= 0) & (share <= 1))
            places.append(self.manifold.plus(way[rows], share[rows, None] * deltas[rows]))
        spots = np.concatenate(places)[:, self._drives.iq : self._drives.iq + 2]
        return bool(((spots >= self._lower - _DUST) & (spots <= self._upper + _DUST)).all())
