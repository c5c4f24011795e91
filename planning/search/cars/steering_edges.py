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
_BOUND_TOLERANCE = 1e-9
# Number of samples per arc or line in `check_coarsely`.
_NUM_COARSE_SAMPLES = 5


class SteeringEdgeChecker(EdgeChecker):
    """Checker of steering paths against an oracle, and against the bounds of x and y.

    Bounds are checked for the whole path: the extremes of an arc are where it heads along an axis,
    so these points are checked. Against obstacles nothing is promised between two samples.
    """

    def __init__(
        self,
        steering_paths: SteeringPaths,
        oracle: WatchedOracle,
        resolution: float,
        norm: Callable[[Array], Array] | None,
        bounds: tuple[Float64[np.ndarray, " nq"], Float64[np.ndarray, " nq"]],
    ) -> None:
        """Make a checker with its counter at zero; `bounds` are the lower and upper ones of q."""
        super().__init__(steering_paths.manifold, oracle, resolution, norm)
        self.is_euclidean = False
        self._steering_paths = steering_paths
        self._oracle = oracle
        xy = slice(steering_paths.iq, steering_paths.iq + 2)
        self._lower, self._upper = bounds[0][xy], bounds[1][xy]

    @override
    def local_path(self, q0: Float64[np.ndarray, " nq"], q1: Float64[np.ndarray, " nq"]) -> Array:
        """Return the waypoints of the steering path from q0 to q1, shape (k, nq)."""
        return self._steering_paths.steer(q0, q1).waypoints

    @override
    def is_free(self, q0: Float64[np.ndarray, " nq"], q1: Float64[np.ndarray, " nq"]) -> bool:
        """Return whether all samples of the steering path are free, q1's included, q0's not."""
        self.num_motions += 1
        # Most blocked motions are blocked at their end, whose check takes no steering path.
        if not self._oracle.is_free(q1):
            return False
        return self._is_path_free(self._steering_paths.steer(q0, q1))

    def free_local_path(
        self,
        q0: Float64[np.ndarray, " nq"],
        q1: Float64[np.ndarray, " nq"],
        tangents: Float64[np.ndarray, "k nv"],
    ) -> Array | None:
        """Return the waypoints of the steering path whose segments have the given tangents.

        None if one of its samples, q1's included, q0's not, is not free.
        """
        self.num_motions += 1
        path = self._steering_paths.path_of_segments(q0, q1, tangents)
        is_free = self._oracle.is_free(q1) and self._is_path_free(path)
        return path.waypoints if is_free else None

    def _is_path_free(self, path: SteeringPath) -> bool:
        """Return whether all samples of a steering path between its ends are free."""
        if not self._is_within_bounds(path):
            return False
        samples = self._samples(path)
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
        tangents = self._steering_paths.tangents(q0s.reshape(-1, nq), q1s.reshape(-1, nq))
        return self.norm(tangents).sum(axis=1).reshape(q0s.shape[:-1])

    def check_coarsely(
        self, q0s: Float64[np.ndarray, "m nq"], q1s: Float64[np.ndarray, "m nq"]
    ) -> tuple[Float64[np.ndarray, "m k nv"], Bool[np.ndarray, " m"]]:
        """Return the tangents of the steering paths between rows, and which pass a coarse check.

        The coarse check is at `_NUM_COARSE_SAMPLES` samples of every arc and line.
        """
        tangents = self._steering_paths.tangents(q0s, q1s)
        samples: list[Array] = []
        q = q0s
        for step in (
            np.repeat(tangents, _NUM_COARSE_SAMPLES, axis=1).transpose(1, 0, 2)
            / _NUM_COARSE_SAMPLES
        ):
            q = self.manifold.plus(q, step)
            samples.append(q)
        qs = np.concatenate(samples)
        free = self._are_within_bounds(qs)
        free[free] = self._oracle.are_free(qs[free])
        return tangents, free.reshape(len(samples), -1).all(axis=0)

    def _samples(self, path: SteeringPath) -> Array:
        """Return configurations along a steering path at the resolution, without its first one."""
        steps = steps_of(path.deltas, self.resolution)
        edge = np.repeat(np.arange(len(steps)), steps)
        index = np.arange(len(edge)) - np.repeat(np.cumsum(steps) - steps, steps) + 1
        displacements = (index / steps[edge])[:, None] * path.deltas[edge]
        return self.manifold.plus(path.waypoints[edge], displacements)

    def _is_within_bounds(self, path: SteeringPath) -> bool:
        begins, deltas = path.waypoints[:-1], path.deltas
        yaw, turn = begins[:, self._steering_paths.iq + 2], deltas[:, self._steering_paths.iv + 2]
        positions = path.waypoints[:, self._steering_paths.iq : self._steering_paths.iq + 2]
        # The distance of an arc from its chord is at most its length times an eighth of its angle.
        max_sagitta = np.abs(deltas[:, self._steering_paths.iv] * turn).max() / 8 + _BOUND_TOLERANCE
        if (
            (positions >= self._lower + max_sagitta) & (positions <= self._upper - max_sagitta)
        ).all():
            return True
        first = np.ceil(np.minimum(yaw, yaw + turn) / (np.pi / 2))
        is_arc = np.abs(turn) > _BOUND_TOLERANCE
        divisors = np.where(is_arc, turn, 1.0)
        configurations = [path.waypoints]
        # An arc of less than half a turn heads along an axis twice at most.
        for k in (first, first + 1):
            fractions = (k * np.pi / 2 - yaw) / divisors
            rows = np.flatnonzero(is_arc & (fractions >= 0) & (fractions <= 1))
            configurations.append(
                self.manifold.plus(begins[rows], fractions[rows, None] * deltas[rows])
            )
        return bool(self._are_within_bounds(np.concatenate(configurations)).all())

    def _are_within_bounds(self, qs: Array) -> Bool[np.ndarray, " m"]:
        positions = qs[:, self._steering_paths.iq : self._steering_paths.iq + 2]
        return (
            (positions >= self._lower - _BOUND_TOLERANCE)
            & (positions <= self._upper + _BOUND_TOLERANCE)
        ).all(axis=1)
