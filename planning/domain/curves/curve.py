"""Curve: a piecewise polynomial on a configuration manifold, the exact form of every motion."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import comb, factorial

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array, Indices
from planning.domain.robot.joints import Joint
from planning.domain.robot.manifold import Manifold
from planning.domain.value import Value, frozen

# Steps in which the length of a path is summed: in all and in each piece, at least.
_LENGTH_STEPS, _STEPS_PER_PIECE = 1024, 4


@dataclass(frozen=True, eq=False)
class Curve(Value):
    """Piecewise polynomial curve: q(x) = bases[i] [+] delta_i(x) on piece i.

    delta_i(x) = sum_k coefficients[i, k] (x - breaks[i])^k for breaks[i] <= x <= breaks[i + 1].
    With the tangent delta in R^nv as the polynomial, straight lines on any manifold are polynomials
    of degree one, and |delta'| bounds the speed.

    Attributes:
        joints: Joints of the manifold; `bases` and `coefficients` stack their coordinates.
        breaks: Increasing parameter values, shape (n + 1,).
        bases: Configuration at which each piece is anchored, shape (n, nq).
        coefficients: Power basis, lowest first, shape (n, degree + 1, nv).
    """

    joints: tuple[Joint, ...]
    breaks: Float64[np.ndarray, " n_plus_1"]
    bases: Float64[np.ndarray, "n nq"]
    coefficients: Float64[np.ndarray, "n degree_plus_1 nv"]

    @cached_property
    def manifold(self) -> Manifold:
        """Configuration manifold that the curve lies on."""
        return Manifold.of(self.joints)

    @cached_property
    def widths(self) -> Array:
        """Parameter width of each piece, shape (n,)."""
        return frozen(self.breaks[1:] - self.breaks[:-1])

    @property
    def num_pieces(self) -> int:
        """Number of polynomial pieces."""
        return len(self.bases)

    def locate(self, x: Float64[np.ndarray, " m"]) -> tuple[Indices, Array]:
        """Return the piece of each x and x relative to its break; the ends are extended."""
        piece = self.breaks[1:-1].searchsorted(x, side="right")
        return piece, x - self.breaks[piece]

    def tangents(self, x: Float64[np.ndarray, " m"], order: int = 0) -> Array:
        """Return the order-th derivative of delta at x, shape (m, nv)."""
        return self._tangents_at(*self.locate(x), order)

    def _tangents_at(self, piece: Indices, local: Float64[np.ndarray, " m"], order: int) -> Array:
        """Return the same at places that are located."""
        # Few instants: differentiate only the pieces that they lie on.
        if len(piece) < self.num_pieces:
            coefficients = derivative(self.coefficients[piece], order)
        else:
            coefficients = derivative(self.coefficients, order)[piece]
        local = local[:, None]
        total = coefficients[:, -1] + 0.0
        for k in range(coefficients.shape[1] - 2, -1, -1):
            total *= local
            total += coefficients[:, k]
        return total

    def positions(self, x: Float64[np.ndarray, " m"]) -> Array:
        """Return q(x), shape (m, nq)."""
        piece, local = self.locate(x)
        return self.manifold.plus(self.bases[piece], self._tangents_at(piece, local, 0))

    def velocities(self, x: Float64[np.ndarray, " m"]) -> Array:
        """Return Drake's generalized velocities dq/dx, shape (m, nv)."""
        if self.manifold.is_flat:
            return self.tangents(x, 1)
        q, delta = self.positions(x), self.tangents(x)
        return self.manifold.generalized_velocity(q, delta, self.tangents(x, 1))

    def accelerations(self, x: Float64[np.ndarray, " m"]) -> Array:
        """Return the derivative of `velocities`, shape (m, nv)."""
        if self.manifold.is_flat:
            return self.tangents(x, 2)
        q, delta = self.positions(x), self.tangents(x)
        rates = self.tangents(x, 1), self.tangents(x, 2)
        return self.manifold.generalized_acceleration(q, delta, *rates)

    @cached_property
    def start(self) -> Array:
        """First configuration, shape (nq,)."""
        return self._position_at(0, self.breaks[:1])

    @cached_property
    def end(self) -> Array:
        """Last configuration, shape (nq,)."""
        return self._position_at(self.num_pieces - 1, self.breaks[-1:])

    def _position_at(self, piece: int, x: Float64[np.ndarray, "1"]) -> Array:
        """Return q(x) of one piece, as `positions` does with the piece located; shape (nq,)."""
        rows = slice(piece, piece + 1)
        local = x - self.breaks[rows]
        delta = np.zeros((1, self.coefficients.shape[2]))
        for k in range(self.coefficients.shape[1] - 1, -1, -1):
            delta = delta * local + self.coefficients[rows, k]
        return frozen(self.manifold.plus(self.bases[rows], delta)[0])


@dataclass(frozen=True, eq=False)
class JointSpline(Curve):
    """Geometric path r(s), s in [0, 1], without time."""

    @classmethod
    def through(
        cls, joints: tuple[Joint, ...], waypoints: Float64[np.ndarray, "n nq"]
    ) -> "JointSpline":
        """Build the polyline of geodesics, parametrised by length."""
        manifold = Manifold.of(joints)
        steps = manifold.minus(waypoints[1:], waypoints[:-1])
        lengths = np.linalg.norm(steps, axis=-1)
        keep = lengths > 1e-12
        if not keep.any():
            keep[:1] = True
            lengths = np.ones_like(lengths)
        fractions = lengths[keep] / lengths[keep].sum()
        breaks = np.concatenate([[0.0], np.cumsum(fractions)])
        breaks[-1] = 1.0
        slopes = steps[keep] / np.diff(breaks)[:, None]
        coefficients = np.stack([np.zeros_like(slopes), slopes], axis=1)
        return cls(joints, breaks, waypoints[:-1][keep], coefficients)


@dataclass(frozen=True, eq=False)
class TimedTrajectory(Curve):
    """Timed motion q(t), t in [0, duration] seconds."""

    @property
    def duration(self) -> float:
        """Duration of the motion [s]."""
        return float(self.breaks[-1])

    def path_fraction(self, time: float) -> float:
        """Return the share of the path's length that is done at an instant, 0 to 1.

        The length is that of q(t) in velocity coordinates [rad and m, as they are]. A motion
        without length has the share of its time.
        """
        times, lengths = self._lengths
        return float(np.interp(time, times, lengths / lengths[-1]))

    @cached_property
    def _lengths(self) -> tuple[Array, Array]:
        """Instants and the length until each, by the trapezoidal rule; shapes (m,)."""
        steps = max(_STEPS_PER_PIECE, -(-_LENGTH_STEPS // self.num_pieces))
        shares = np.arange(steps) / steps
        inner = (self.breaks[:-1, None] + self.widths[:, None] * shares).ravel()
        times = np.append(inner, self.duration)
        speeds = np.linalg.norm(self.velocities(times), axis=1)
        increments = 0.5 * (speeds[1:] + speeds[:-1]) * np.diff(times)
        lengths = np.concatenate([[0.0], np.cumsum(increments)])
        return (times, lengths) if lengths[-1] > 0 else (times, times)

    def sample_times(self, period: float) -> Array:
        """Return instants every `period` [s], the first and the last instant included."""
        count = max(1, int(np.ceil(self.duration / period - 1e-9)))
        times = np.minimum(np.arange(count + 1) * period, self.duration)
        times[-1] = self.duration
        return times

    def evenly_spaced_times(self, count: int) -> Array:
        """Return `count` instants [s], evenly spaced, from the first to the last; at least two."""
        return np.linspace(0.0, self.duration, count)

    @classmethod
    def at_rest(cls, joints: tuple[Joint, ...], q: Float64[np.ndarray, " nq"]) -> "TimedTrajectory":
        """Build the motion of no duration at a configuration."""
        num_velocities = sum(joint.num_velocities for joint in joints)
        return cls(joints, np.zeros(2), np.array(q)[None], np.zeros((1, 1, num_velocities)))

    @classmethod
    def joined(cls, parts: Sequence["TimedTrajectory"]) -> "TimedTrajectory":
        """Build the concatenation of motions."""
        if len(parts) == 1:
            return parts[0]
        degree = max(part.coefficients.shape[1] for part in parts)
        padded = [
            np.pad(part.coefficients, ((0, 0), (0, degree - part.coefficients.shape[1]), (0, 0)))
            for part in parts
        ]
        starts = np.cumsum([0.0, *(part.duration for part in parts)])
        breaks = [part.breaks[:-1] + begin for part, begin in zip(parts, starts[:-1], strict=True)]
        return cls(
            parts[0].joints,
            np.append(np.concatenate(breaks), starts[-1]),
            np.concatenate([part.bases for part in parts]),
            np.concatenate(padded),
        )

    def until(self, time: float) -> "TimedTrajectory":
        """Return the motion up to an instant within it, later than its beginning [s]."""
        pieces = int(np.searchsorted(self.breaks[1:], time)) + 1
        return TimedTrajectory(
            self.joints,
            np.append(self.breaks[:pieces], time),
            self.bases[:pieces],
            self.coefficients[:pieces],
        )

    def after(self, time: float) -> "TimedTrajectory":
        """Return the rest of the motion from an instant within it on [s]."""
        piece = int(self.locate(np.array([time]))[0][0])
        terms = self.coefficients.shape[1]
        taylor = [self.tangents(np.array([time]), k)[0] / factorial(k) for k in range(terms)]
        return TimedTrajectory(
            self.joints,
            np.concatenate([[time], self.breaks[piece + 1 :]]) - time,
            self.bases[piece:],
            np.concatenate([np.stack(taylor)[None], self.coefficients[piece + 1 :]]),
        )

    @property
    def reverse(self) -> "TimedTrajectory":
        """The same motion from its end to its start."""
        widths, terms = np.diff(self.breaks), self.coefficients.shape[1]
        reversed_coefficients = np.zeros_like(self.coefficients)
        # (w - x)^k by the binomial theorem.
        for k in range(terms):
            for j in range(k + 1):
                factors = (-1.0) ** j * comb(k, j) * widths ** (k - j)
                reversed_coefficients[:, j] += factors[:, None] * self.coefficients[:, k]
        breaks = self.duration - self.breaks[::-1]
        return TimedTrajectory(self.joints, breaks, self.bases[::-1], reversed_coefficients[::-1])

    def time_scaled(self, factor: float) -> "TimedTrajectory":
        """Return the same motion taking `factor` times as long."""
        # Products: numpy's powers differ from one instruction set to another.
        powers = np.vander([1 / factor], self.coefficients.shape[1], increasing=True)[0]
        return TimedTrajectory(
            self.joints,
            self.breaks * factor,
            self.bases,
            self.coefficients * powers[None, :, None],
        )


def derivative(coefficients: Float64[np.ndarray, "n k nv"], order: int) -> Array:
    """Return the power-basis coefficients of the order-th derivative, shape (n, >= 1, nv)."""
    for _ in range(order):
        powers = np.arange(1, coefficients.shape[1], dtype=np.float64)
        coefficients = coefficients[:, 1:] * powers[None, :, None]
        if coefficients.shape[1] == 0:
            return np.zeros((coefficients.shape[0], 1, coefficients.shape[2]))
    return coefficients
