"""combined(): several timed motions of different joints as one motion of all their joints.

Between two instants at which any of them changes its polynomial, each is one polynomial; about the
beginning of such an interval it has the coefficients of its Taylor series there, which is exact.
"""

from collections.abc import Sequence
from itertools import chain
from math import comb

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.curves.curve import TimedTrajectory

# Instants nearer than this are one: a piece this short has no place in a motion [s].
_SAME_INSTANT = 1e-12


def combined(trajectories: Sequence[TimedTrajectory], begins: Sequence[float]) -> TimedTrajectory:
    """Return one motion of all joints, from time 0 until the last motion has ended.

    Each motion rests at its start before it begins, and at its end after it has ended.

    Args:
        trajectories: Motions of different joints.
        begins: When each begins [s], at least 0.
    """
    placed = [begin + one.breaks for one, begin in zip(trajectories, begins, strict=True)]
    breaks = _joint_breaks(placed)
    degree = max(one.coefficients.shape[1] for one in trajectories)
    pieces = [
        _on_intervals(one, own, breaks, degree)
        for one, own in zip(trajectories, placed, strict=True)
    ]
    return TimedTrajectory(
        tuple(chain.from_iterable(one.joints for one in trajectories)),
        breaks,
        np.concatenate([bases for bases, _ in pieces], axis=1),
        np.concatenate([coefficients for _, coefficients in pieces], axis=2),
    )


def _joint_breaks(placed: Sequence[Array]) -> Array:
    """Return 0 and the breaks of all motions in order, each instant once."""
    all_breaks = np.unique(np.concatenate([np.zeros(1), *placed]))
    is_kept = np.append(True, np.diff(all_breaks) > _SAME_INSTANT)
    breaks = all_breaks[is_kept]
    if len(breaks) > 1:
        breaks[-1] = all_breaks[-1]
    return breaks


def _on_intervals(
    trajectory: TimedTrajectory,
    placed: Float64[np.ndarray, " m"],
    breaks: Float64[np.ndarray, " n_plus_1"],
    degree: int,
) -> tuple[Array, Array]:
    """Return bases and coefficients of a motion on intervals, within each of which it is smooth.

    Args:
        trajectory: The motion.
        placed: Its breaks, in the time of the intervals [s].
        breaks: Begins of the intervals, and the end of the last [s].
        degree: Number of coefficients to return, at least the motion's own.
    """
    begins, middles = breaks[:-1], (breaks[:-1] + breaks[1:]) / 2
    piece = np.clip(np.searchsorted(placed, middles) - 1, 0, trajectory.num_pieces - 1)
    own = trajectory.coefficients[piece]
    local = begins - placed[piece]
    shifted = np.zeros((len(begins), degree, own.shape[2]))
    for power in range(own.shape[1]):
        for k in range(power + 1):
            factors = comb(power, k) * local ** (power - k)
            shifted[:, k] += factors[:, None] * own[:, power]
    bases = np.array(trajectory.bases[piece])
    for is_at_rest, q in (
        (middles < placed[0], trajectory.start),
        (middles > placed[-1], trajectory.end),
    ):
        bases[is_at_rest] = q
        shifted[is_at_rest] = 0.0
    return bases, shifted
