"""SegmentTimes: durations of arc segments, each from rest to rest, as estimates of the retimer's.

All along a segment the limits are constant, so its squared path velocity x = (ds/dt)^2 over s from
0 to 1 has a constant bound, and its path acceleration dx/ds / 2 is at most

    min(A, sqrt(B^2 - (turn x)^2)):

A is the bound of the slowest joint, B that of the car, whose acceleration on an arc has a
centripetal part too. From rest that is

    x(s) = 2 A s                             while B leaves as much,
    x(s) = B / turn sin(2 turn (s - s_0))    after that, until the sine is 1,

and the same before the end. The duration is the integral of x^(-1/2); toppra's are 0 to 1 % longer.
With bounded jerk it is at least that of a straight line (Biagiotti and Melchiorri, "Trajectory
Planning for Automatic Machines and Robots", 2008, section 3.4), on an arc with a lower top speed: 4
% from ruckig's on average.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.robot.joints import JointLimits

# Gauss-Legendre rule on u, u^2 = s, where the integrand is smooth except where the bounds switch.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(24)
# Share of an arc's speed bounds that is used with bounded jerk. Found by measurement.
_CIRCLE_SHARE = 0.5
_DUST, _UNBOUNDED = 1e-12, 1e6


@dataclass(frozen=True)
class SegmentTimes:
    """Durations of arc segments under velocity, acceleration and jerk limits.

    Attributes:
        car: Bounds of the car on speed, acceleration and jerk, in metres, shape (3,).
        rates: The same for all other bounded blocks, shape (3, b).
        blocks: Coordinates (yaw and other joints) that each of these bounds.
        jerk: Whether jerk is bounded.
    """

    car: Array
    rates: Array
    blocks: tuple[list[int], ...]
    jerk: bool

    @classmethod
    def of(cls, limits: JointLimits, car: int, *, jerk: bool) -> "SegmentTimes":
        """Return the durations for a group whose car's coordinates begin at `car` in v."""
        rates = np.minimum([limits.velocity, limits.acceleration, limits.jerk], _UNBOUNDED)
        rates = np.maximum(rates, 1 / _UNBOUNDED)
        count = sum(len(block) for block in limits.blocks)
        columns = [car + 2, *(v for v in range(count) if not car <= v < car + 3)]
        place = limits.blocks.index((car, car + 1))
        rest = limits.blocks[:place] + limits.blocks[place + 1 :]
        blocks = tuple([columns.index(v) for v in block] for block in rest)
        return cls(rates[:, place], np.delete(rates, place, axis=1), blocks, jerk)

    def durations(
        self,
        ways: Float64[np.ndarray, " n"],
        turns: Float64[np.ndarray, " n"],
        moves: Float64[np.ndarray, "n k"],
    ) -> Float64[np.ndarray, " n"]:
        """Return the duration of every segment [s].

        Args:
            ways: Signed lengths [m].
            turns: Turning angles [rad].
            moves: Displacements of the other joints.
        """
        columns = np.column_stack([turns, moves])
        sizes = [np.linalg.norm(columns[:, block], axis=1) for block in self.blocks]
        turns = np.abs(turns) + _DUST
        car = self.car[:, None] / (np.abs(ways) + _DUST)
        rest = (self.rates[:, None] / (np.stack(sizes, axis=1) + _DUST)).min(axis=2)
        top = np.minimum(np.minimum(car[0], rest[0]) ** 2, car[1] / turns)
        times = _of_circles(top, rest[1], car[1], turns)
        if not self.jerk:
            return times
        around = np.minimum(car[1] / turns, (car[2] / turns**2 / _CIRCLE_SHARE**0.5) ** (2 / 3))
        speed = np.sqrt(np.minimum(top, _CIRCLE_SHARE * around))
        push, swing = np.minimum(car[1:], rest[1:])
        return np.maximum(times, _of_lines(speed, push, swing))


def _of_circles(top: Array, push: Array, circle: Array, turns: Array) -> Array:
    """Return durations on arcs without jerk bounds: the integral over both equal halves."""
    u = (_NODES[:, None] + 1) * np.sqrt(0.125)
    s = u * u
    push = np.minimum(push, circle / _DUST**0.5)
    left = np.sqrt(np.maximum(circle**2 - push**2, 0.0))
    s_0 = left / (2 * push * turns)
    phase = 2 * turns * (s - s_0) + np.arcsin(np.minimum(left / circle, 1.0))
    round_ = circle / turns * np.sin(np.minimum(phase, np.pi / 2))
    pace = np.minimum(np.where(s < s_0, 2 * push * s, round_), top)
    return (_WEIGHTS[:, None] * np.sqrt(0.5) * 2 * u / np.sqrt(pace)).sum(axis=0)


def _of_lines(speed: Array, push: Array, swing: Array) -> Array:
    """Return durations from s = 0 to 1, rest to rest, with bounded speed, acceleration, jerk."""
    push = np.minimum(push, np.sqrt(speed * swing))
    ramp = push / swing
    cruising = 1 / speed + speed / push + ramp
    pushing = np.sqrt(ramp**2 + 4 / push) + ramp
    swinging = (32 / swing) ** (1 / 3)
    is_short = np.where(2 * push * ramp**2 <= 1, pushing, swinging)
    return np.where(speed * (speed / push + ramp) <= 1, cruising, is_short)
