r"""Barrier: a place on a path that an execution does not pass, and how fast it may be before it.

With x = s'^2, the limit |q'' x + q' s''| <= a of a block of joints is convex in (s'', x), and so is
what can still come to rest before a place: from its end backwards, cell by cell, the largest x from
which some s'' leads to the largest x of the next cell (the controllable sets of TOPP-RA, Pham &
Pham 2018, with the whole interval [0, x] controllable, as s'' = 0 keeps the limits for x <= 1).
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.robot.joints import JointLimits
from planning.domain.value import Value

# Width of cells [s], and their largest number.
_CELL, _MAX_CELLS = 4e-3, 500
# Share of the limits that the speeds before a barrier are made for: the rest is for what a control
# period does between cells.
_SHARE = 0.9
# How far before the barrier it rests, and from where on it does not creep nearer [s].
_GUARD, _NEAR = 4e-3, 4e-3
_NUM_HALVINGS = 24
# A block that moves slower than this bounds nothing [rad/s or m/s].
_MIN_SPEED = 1e-9


@dataclass(frozen=True, eq=False)
class Barrier(Value):
    """A place that a motion forwards does not pass.

    Attributes:
        time: The place, time along the trajectory [s].
        places: Increasing places until where it rests [s], shape (n,).
        squared_speeds: Largest s'^2 at each from which it comes to rest in time, shape (n,); linear
            between them, and 0 beyond the last.
    """

    time: float
    places: Float64[np.ndarray, " n"]
    squared_speeds: Float64[np.ndarray, " n"]

    @classmethod
    def at(
        cls,
        time: float,
        trajectory: TimedTrajectory,
        limits: JointLimits,
        path_acceleration: float,
    ) -> "Barrier":
        """Return the barrier at a place of a trajectory.

        Args:
            time: The place [s].
            trajectory: That is followed.
            limits: Joint limits; only `acceleration` is used, per block.
            path_acceleration: Largest magnitude of s'' [1/s].
        """
        end = float(np.clip(time - _GUARD, 0.0, trajectory.duration))
        places = np.linspace(0.0, end, 1 + min(_MAX_CELLS, max(1, int(np.ceil(end / _CELL)))))
        speeds = _controllable(trajectory, limits, places, _SHARE * path_acceleration)
        return cls(time, places, speeds)

    def max_speed(self, time: float) -> float:
        """Return the largest s' at a place from which it comes to rest in time."""
        return float(np.sqrt(self._squared(time)))

    def limited(
        self, place: tuple[float, float], bounds: tuple[float, float], chosen: float, period: float
    ) -> float:
        """Return the largest s'' up to the chosen one after which it still comes to rest in time.

        If there is none within its bounds, the least one: it is too late, and rests beyond.

        Args:
            place: s [s] and s'.
            bounds: Least and largest s'' that keep the limits [1/s]; 0 is between them.
            chosen: s'' within them that is wanted [1/s].
            period: For which it holds [s].
        """
        time, speed = place
        if speed <= 0 and chosen <= 0:
            return chosen
        if self.places[-1] - time <= _NEAR:
            return max(bounds[0], min(chosen, -speed / period))
        if self._is_in_time(place, chosen, period):
            return chosen
        low, high = bounds[0], chosen
        for _ in range(_NUM_HALVINGS):
            middle = 0.5 * (low + high)
            is_safe = self._is_in_time(place, middle, period)
            low, high = (middle, high) if is_safe else (low, middle)
        return low

    def _is_in_time(self, place: tuple[float, float], rate: float, period: float) -> bool:
        time, speed = place
        after = speed + rate * period
        if after <= 0:
            return True
        reached = time + 0.5 * (speed + after) * period
        return after * after <= self._squared(reached)

    def _squared(self, time: float) -> float:
        return float(np.interp(time, self.places, self.squared_speeds, right=0.0))


def _controllable(
    trajectory: TimedTrajectory,
    limits: JointLimits,
    places: Float64[np.ndarray, " n"],
    path_acceleration: float,
) -> Array:
    """Return the largest s'^2 at each place that leads to rest at the last one, shape (n,)."""
    bb, bc, cc = _products(trajectory, limits, places)
    # Where the trajectory itself needs more, that is the bound, as in `time_scaling`.
    squared_bounds = np.maximum((_SHARE * limits.acceleration) ** 2, cc)
    found = np.zeros(len(places))
    for i in range(len(places) - 2, -1, -1):
        width, x = places[i + 1] - places[i], found[i + 1]
        if width <= 0:
            continue
        least = max(-path_acceleration, _least_rate(bb, bc, cc, squared_bounds, i + 1, x))
        most = min(1.0, x - 2 * width * min(least, 0.0))
        k = 0.5 / width
        # |q'' y + q' k (x - y)|^2 <= a^2, quadratic in y = s'^2 at this place
        square = cc[i] - 2 * k * bc[i] + k * k * bb[i]
        half = k * x * (bc[i] - k * bb[i])
        rest = k * k * x * x * bb[i] - squared_bounds[i]
        bends = square > _MIN_SPEED**2
        if bends.any():
            square, half, rest = square[bends], half[bends], rest[bends]
            root = np.sqrt(np.maximum(half * half - square * rest, 0.0))
            most = min(most, float(np.min((-half + root) / square)))
        found[i] = max(0.0, most)
    return found


def _products(
    trajectory: TimedTrajectory, limits: JointLimits, places: Float64[np.ndarray, " n"]
) -> tuple[Array, Array, Array]:
    """Return |q'|^2, q'.q'' and |q''|^2 of every block at every place, shapes (n, num_blocks)."""
    velocities, accelerations = trajectory.velocities(places), trajectory.accelerations(places)
    parts = [(velocities[:, list(block)], accelerations[:, list(block)]) for block in limits.blocks]
    bb = np.stack([np.sum(b * b, axis=1) for b, _ in parts], axis=1)
    bc = np.stack([np.sum(b * c, axis=1) for b, c in parts], axis=1)
    cc = np.stack([np.sum(c * c, axis=1) for _, c in parts], axis=1)
    return bb, bc, cc


def _least_rate(bb: Array, bc: Array, cc: Array, squared_bounds: Array, i: int, x: float) -> float:
    """Return the least s'' [1/s] at a place that keeps all limits at s'^2 = x."""
    moves = bb[i] > _MIN_SPEED**2
    if not moves.any():
        return -np.inf
    a, half = bb[i][moves], bc[i][moves] * x
    rest = cc[i][moves] * x * x - squared_bounds[i][moves]
    root = np.sqrt(np.maximum(half * half - a * rest, 0.0))
    return float(np.max((-half - root) / a))
