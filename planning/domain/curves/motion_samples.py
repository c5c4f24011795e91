"""Motion samples: the configurations at which a geodesic is collision-checked, and their order.

A motion leaves `origin` along `displacement` (a tangent, shape (nv,)). Its n samples are
`origin [+] (i / n) * displacement`, i = 1..n, where n is the least number that makes every step at
most the resolution. Where joints do not float that is `origin + (i / n) * displacement` in float64,
each operation rounded by itself: every collision checker checks these very numbers.

The far end comes first, then the middle, then the quarters: the order of van der Corput's sequence
in base 2, which meets a collision of width w after about 1/w samples. The first samples come one by
one, because most blocked motions end there; the others in batches that grow.
"""

import math
from collections.abc import Callable, Iterator
from functools import lru_cache

import numpy as np
from jaxtyping import Bool, Float64, Int64

from planning.domain.arrays import Array, Flags, Indices
from planning.domain.robot.manifold import Manifold

type AreFree = Callable[[Array], Flags]

_FIRST_BATCH = 6
_GROWTH = 4
_LARGEST_BATCH = 1024
_LARGEST_TABLE = 4096
_FAR_END = np.ones(1)


def num_steps(displacement: Float64[np.ndarray, " nv"], resolution: float) -> int:
    """Return the number of samples of one motion, as `steps_of` does."""
    squares = 0.0
    for x in displacement.tolist():
        squares += x * x
    return max(1, math.ceil(math.sqrt(squares) / resolution - 1e-9))


def steps_of(
    displacements: Float64[np.ndarray, "m nv"], resolution: float
) -> Int64[np.ndarray, " m"]:
    """Return the number of samples of each motion: the least with steps within the resolution.

    At least one. The squares of a displacement are added in the order of its coordinates, so that
    the number is the same wherever it is computed.
    """
    squares = np.add.accumulate(displacements * displacements, axis=1)[:, -1]
    counts = np.ceil(np.sqrt(squares) / resolution - 1e-9)
    return np.maximum(counts, 1.0).astype(np.int64)


def is_motion_free(
    manifold: Manifold,
    are_free: AreFree,
    motion: tuple[Float64[np.ndarray, " nq"], Float64[np.ndarray, " nv"]],
    resolution: float,
) -> bool:
    """Return whether every sample of a motion is free; the origin is not one of them.

    Args:
        manifold: Configuration manifold of the joints that move.
        are_free: Returns whether each configuration is free, for an array of shape (m, nq).
        motion: Origin and displacement.
        resolution: Largest length of a step.
    """
    return all(are_free(qs).all() for qs in sample_batches(manifold, motion, resolution))


def are_motions_free(
    manifold: Manifold,
    are_free: AreFree,
    motions: tuple[Float64[np.ndarray, "m nq"], Float64[np.ndarray, "m nv"]],
    resolution: float,
) -> Bool[np.ndarray, " m"]:
    """Return the same for every motion: rows of origins and of displacements."""
    verdicts = [
        is_motion_free(manifold, are_free, motion, resolution)
        for motion in zip(*motions, strict=True)
    ]
    return np.array(verdicts, dtype=bool)


def sample_batches(
    manifold: Manifold,
    motion: tuple[Float64[np.ndarray, " nq"], Float64[np.ndarray, " nv"]],
    resolution: float,
) -> Iterator[Array]:
    """Yield the samples of a motion, shape (m, nq) each, in the order of checking."""
    origin, displacement = motion
    for fractions in fraction_batches(num_steps(displacement, resolution)):
        yield manifold.plus(origin, fractions[:, None] * displacement)


def fraction_batches(steps: int) -> Iterator[Array]:
    """Yield the fractions i / steps, 0 < i <= steps, in the order of checking."""
    return iter(_table(steps)) if steps <= _LARGEST_TABLE else _generate(steps)


@lru_cache(maxsize=1024)
def _table(steps: int) -> tuple[Array, ...]:
    return tuple(_generate(steps))


def _generate(steps: int) -> Iterator[Array]:
    yield _FAR_END
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


def _reversed_bits(numbers: Indices, bits: int) -> Indices:
    mirrored = np.zeros_like(numbers)
    for k in range(bits):
        mirrored |= (numbers >> k & 1) << (bits - 1 - k)
    return mirrored
