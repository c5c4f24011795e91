"""SteeringEdgeChecker: validity of edges of a group with a car, which are steering paths."""

from collections.abc import Callable
from itertools import islice
from typing import override

import numpy as np
from jaxtyping import Bool, Float64

from planning.domain.arrays import Array
from planning.domain.curves.motion_samples import fraction_batches, steps_of
from planning.search.cars.steering_paths import SteeringPath, SteeringPaths
from planning.search.collision_oracle import WatchedOracle
from planning.search.edges import EdgeChecker

# Tolerance on bounds of x and y [m]; the certifier's is larger.
_DUST = 1e-9
# Number of samples per arc or line in the coarse check of `at_a_glance`.
_LOOKS = 5


class SteeringEdgeChecker(EdgeChecker):
    """Checker of steering paths against an oracle, and against the bounds of x and y.

    Bounds are checked for the whole path: the extremes of an arc are where it heads along an axis,
    so these points are checked. Against obstacles nothing is promised between two samples.
    """

    def __init__(
        self,
        drives: SteeringPaths,
        oracle: WatchedOracle,
        resolution: float,
        norm: Callable[[Array], Array],
        bounds: tuple[Float64[np.ndarray, " nq"], Float64[np.ndarray, " nq"]],
    ) -> None:
        """Make a checker with its counter at zero; `bounds` are the lower and upper ones of q."""
        super().__init__(drives.manifold, oracle, resolution, norm)
        self._drives = drives
        self._oracle = oracle
        place = slice(drives.iq, drives.iq + 2)
        self._lower, self._upper = bounds[0][place], bounds[1][place]

    @override
    def way(self, q0: Float64[np.ndarray, " nq"], q1: Float64[np.ndarray, " nq"]) -> Array:
        """Return the waypoints of the steering path from q0 to q1, shape (k, nq)."""
        return self._drives.way(q0, q1).waypoints

    @override
    def is_free(self, q0: Float64[np.ndarray, " nq"], q1: Float64[np.ndarray, " nq"]) -> bool:
        """Return whether all samples of the steering path are free, q1's included, q0's not."""
        self.num_motions += 1
        # Most blocked motions are blocked at their end, whose check takes no steering path.
        if not self._oracle.is_free(q1):
            return False
        return self._is_clear(self._drives.way(q0, q1))

    def free_way(
        self,
        q0: Float64[np.ndarray, " nq"],
        q1: Float64[np.ndarray, " nq"],
        tangents: Float64[np.ndarray, "k nv"],
    ) -> Array | None:
        """Return the waypoints of the steering path whose segments have the given tangents.

        None if one of its samples, q1's included, q0's not, is not free.
        """
        self.num_motions += 1
        way = self._drives.along(q0, q1, tangents)
        is_free = self._oracle.is_free(q1) and self._is_clear(way)
        return way.waypoints if is_free else None

    def _is_clear(self, way: SteeringPath) -> bool:
        """Return whether all samples of a steering path between its ends are free."""
        if not self._stays_inside(way):
            return False
        samples = self._samples(way)
        count = len(samples)
        for fractions in islice(fraction_batches(count), 1, None):
            rows = np.rint(fractions * count).astype(int) - 1
            if not self._oracle.are_free(samples[rows]).all():
                return False
        return True

    @override
    def is_whole_edge_free(self, q0: list[float], q1: list[float]) -> bool:
        """Return whether all samples of the steering path are free, both ends included."""
        begin = np.array(q0)
        return self._oracle.is_free(begin) and self.is_free(begin, np.array(q1))

    @override
    def are_free(
        self, q0s: Float64[np.ndarray, "m nq"], q1s: Float64[np.ndarray, "m nq"]
    ) -> Bool[np.ndarray, " m"]:
        """Return whether each steering path is free as by `is_free`, for pairs of rows."""
        return np.array([self.is_free(q0, q1) for q0, q1 in zip(q0s, q1s, strict=True)], dtype=bool)

    @override
    def lengths(
        self, q0s: Float64[np.ndarray, "*#m nq"], q1s: Float64[np.ndarray, "*#m nq"]
    ) -> Float64[np.ndarray, "*m"]:
        """Return the lengths by `norm` of the steering paths between rows."""
        q0s, q1s = np.broadcast_arrays(q0s, q1s)
        nq = q0s.shape[-1]
        tangents = self._drives.tangents(q0s.reshape(-1, nq), q1s.reshape(-1, nq))
        return self.norm(tangents).sum(axis=1).reshape(q0s.shape[:-1])

    def at_a_glance(
        self, q0s: Float64[np.ndarray, "m nq"], q1s: Float64[np.ndarray, "m nq"]
    ) -> tuple[Float64[np.ndarray, "m k nv"], Bool[np.ndarray, " m"]]:
        """Return the tangents of the steering paths between rows, and which pass a coarse check.

        The coarse check is at `_LOOKS` samples of every arc and line.
        """
        tangents = self._drives.tangents(q0s, q1s)
        looks: list[Array] = []
        q = q0s
        for part in np.repeat(tangents, _LOOKS, axis=1).transpose(1, 0, 2) / _LOOKS:
            q = self.manifold.plus(q, part)
            looks.append(q)
        qs = np.concatenate(looks)
        free = self._are_inside(qs)
        free[free] = self._oracle.are_free(qs[free])
        return tangents, free.reshape(len(looks), -1).all(axis=0)

    def _samples(self, way: SteeringPath) -> Array:
        """Return configurations along a steering path at the resolution, without its first one."""
        steps = steps_of(way.deltas, self.resolution)
        edge = np.repeat(np.arange(len(steps)), steps)
        place = np.arange(len(edge)) - np.repeat(np.cumsum(steps) - steps, steps) + 1
        parts = (place / steps[edge])[:, None] * way.deltas[edge]
        return self.manifold.plus(way.waypoints[edge], parts)

    def _stays_inside(self, way: SteeringPath) -> bool:
        begins, deltas = way.waypoints[:-1], way.deltas
        yaw, turn = begins[:, self._drives.iq + 2], deltas[:, self._drives.iv + 2]
        spots = way.waypoints[:, self._drives.iq : self._drives.iq + 2]
        # The distance of an arc from its chord is at most its length times an eighth of its angle.
        aside = np.abs(deltas[:, self._drives.iv] * turn).max() / 8 + _DUST
        if ((spots >= self._lower + aside) & (spots <= self._upper - aside)).all():
            return True
        first = np.ceil(np.minimum(yaw, yaw + turn) / (np.pi / 2))
        is_arc = np.abs(turn) > _DUST
        safe = np.where(is_arc, turn, 1.0)
        places = [way.waypoints]
        # An arc of less than half a turn heads along an axis twice at most.
        for k in (first, first + 1):
            share = (k * np.pi / 2 - yaw) / safe
            rows = np.flatnonzero(is_arc & (share >= 0) & (share <= 1))
            places.append(self.manifold.plus(begins[rows], share[rows, None] * deltas[rows]))
        return bool(self._are_inside(np.concatenate(places)).all())

    def _are_inside(self, qs: Array) -> Bool[np.ndarray, " m"]:
        spots = qs[:, self._drives.iq : self._drives.iq + 2]
        return ((spots >= self._lower - _DUST) & (spots <= self._upper + _DUST)).all(axis=1)
