"""EdgeChecker: whether a geodesic between two configurations is free, at a resolution.

The samples are i/n of the way, n the least number that makes every step at most the resolution.
The far end comes first, then the middle, then the quarters: the order of van der Corput's sequence
in base 2, which meets a collision of width w after about 1/w samples. The first samples are asked
one by one, because most blocked edges end there; the others in batches that grow.
"""

import math
from collections.abc import Iterator
from functools import lru_cache
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.manifold import Manifold
from planning.search.oracle import WatchedOracle

type Array = np.ndarray[Any, np.dtype[np.float64]]

_FIRST_BATCH = 6
_GROWTH = 4
_LARGEST_BATCH = 1024
_LARGEST_TABLE = 4096


class EdgeChecker:
    """Checks edges against an oracle.

    Not promised: anything between two samples.

    Attributes:
        resolution: Largest distance between two samples (radians and metres weigh the same).
        num_motions: Edges checked so far.
    """

    def __init__(self, manifold: Manifold, oracle: WatchedOracle, resolution: float) -> None:
        """Make a checker that has checked nothing yet."""
        self.manifold = manifold
        self.resolution = resolution
        self.num_motions = 0
        self._oracle = oracle
        self._is_vector = manifold.is_flat and not any(manifold.wraps)
        self._free: set[bytes] = set()

    def is_free(self, q0: Float64[np.ndarray, " nq"], q1: Float64[np.ndarray, " nq"]) -> bool:
        """Return whether all samples of the geodesic are free, q1's included, q0's not.

        Raises:
            Canceled: Somebody asked for the end.
            DeadlineExceeded: The time has run out.
        """
        self.num_motions += 1
        if not self._oracle.is_free(q1):
            return False
        delta = self._minus(q1, q0)
        steps = num_steps(math.sqrt(delta @ delta), self.resolution)
        for fractions in batches(steps):
            qs = self._along(q0, delta, fractions)
            if len(qs) == 1:
                if not self._oracle.is_free(qs[0]):
                    return False
            elif not self._oracle.are_free(qs).all():
                return False
        return True

    def is_known_free(self, q0: Float64[np.ndarray, " nq"], q1: Float64[np.ndarray, " nq"]) -> bool:
        """Return the same as `is_free`, but do not check again what was found free before.

        Raises:
            Canceled: Somebody asked for the end.
            DeadlineExceeded: The time has run out.
        """
        key = q0.tobytes() + q1.tobytes()
        if key in self._free:
            return True
        free = self.is_free(q0, q1)
        if free:
            self._free.add(key)
        return free

    def distance(self, q0: Float64[np.ndarray, " nq"], q1: Float64[np.ndarray, " nq"]) -> float:
        """Return the length of the geodesic."""
        delta = self._minus(q1, q0)
        return math.sqrt(delta @ delta)

    def geodesic(
        self,
        q0: Float64[np.ndarray, " nq"],
        q1: Float64[np.ndarray, " nq"],
        fractions: Float64[np.ndarray, " m"],
    ) -> Array:
        """Return the configurations at fractions of the way, shape (m, nq)."""
        return self._along(q0, self._minus(q1, q0), fractions)

    def _minus(self, q1: Array, q0: Array) -> Array:
        return q1 - q0 if self._is_vector else self.manifold.minus(q1, q0)

    def _along(self, q0: Array, delta: Array, fractions: Array) -> Array:
        steps = fractions[:, None] * delta
        if self._is_vector:
            return q0 + steps
        return self.manifold.plus(np.broadcast_to(q0, (len(steps), len(q0))), steps)


def num_steps(length: float, resolution: float) -> int:
    """Return the least number of equal steps of at most `resolution` in `length`, at least 1."""
    return max(1, int(np.ceil(length / resolution - 1e-9)))


def batches(steps: int) -> Iterator[Array]:
    """Yield the inner fractions i / steps, 0 < i < steps, in the order of checking."""
    return iter(_table(steps)) if steps <= _LARGEST_TABLE else _generate(steps)


@lru_cache(maxsize=1024)
def _table(steps: int) -> tuple[Array, ...]:
    return tuple(_generate(steps))


def _generate(steps: int) -> Iterator[Array]:
    bits = max(1, (steps - 1).bit_length())
    position, size = 1, 1
    while position < 1 << bits:
        stop = min(1 << bits, position + size)
        order = _reversed_bits(np.arange(position, stop), bits)
        inner = order[order < steps]
        if len(inner):
            yield inner / steps
        position = stop
        size = min(_LARGEST_BATCH, _FIRST_BATCH if size == 1 else size * _GROWTH)


def _reversed_bits(
    numbers: np.ndarray[Any, np.dtype[np.int64]], bits: int
) -> np.ndarray[Any, np.dtype[np.int64]]:
    mirrored = np.zeros_like(numbers)
    for k in range(bits):
        mirrored |= (numbers >> k & 1) << (bits - 1 - k)
    return mirrored
