"""Bounds on what the torques' Taylor series miss.

The recursion that gives the torques gives these too: with bounds on lengths for vectors, products
for cross products and plus for every sign. A rotation by q(t) has the majorant exp(sum b_i x^i),
b_i bounding the i-th coefficient of q: the exponential series of a rotation, of which only what
changes counts.
"""

from typing import Any

import numpy as np

from planning.certify.angular_rates import velocity_series
from planning.certify.link_motion import Kind
from planning.certify.links import Link
from planning.certify.taylor import about, derivative, grown, scaled
from planning.certify.torque_recursion import TERMS, resisted

type Array = np.ndarray[Any, np.dtype[np.float64]]


class TorqueMajorant:
    """Bounds on the first coefficient that is left out, at every instant of a segment."""

    def __init__(
        self,
        links: tuple[Link, ...],
        gravity: Array,
        motion: tuple[Array, Array, Array],
        order: int = 2,
    ) -> None:
        self._links, self._gravity, self._order = links, float(np.linalg.norm(gravity)), order
        tangents, self._bases, halves = motion
        sizes = np.abs(tangents)
        for link in links:
            if link.motion.kind is Kind.SPIN:
                spin = slice(link.motion.rate, link.motion.rate + 3)
                sizes[:, :, link.motion.rate] = np.linalg.norm(tangents[:, :, spin], axis=2)
        # sum C(m, k) |q_m| h^(m - k) bounds the k-th coefficient about any point in [-h, h].
        self._bounds = about(sizes, halves, TERMS + 3)
        count = len(halves)
        still = grown(np.zeros((count, TERMS + 2)))
        self._rates = [np.zeros((count, TERMS + 2))] * (len(links) + 1)
        self._turns = [still] * (len(links) + 1)
        self._places = [np.zeros((count, TERMS + 3))] * (len(links) + 1)
        self._arms = [still] * len(links)

    def run(self) -> Array:
        """Return the bounds, shape (n, nv)."""
        for i, link in enumerate(self._links):
            self._place(i, link)
        forces = [self._force(i, link) for i, link in enumerate(self._links)]
        total = np.zeros((len(self._bounds), self._bounds.shape[2]))
        for i in reversed(range(len(self._links))):
            link, (force, moment) = self._links[i], forces[i]
            motion = link.motion
            if motion.kind is Kind.SPIN:
                total[:, motion.rate] += moment[:, TERMS]
            else:
                along = moment if motion.kind is Kind.TURN else force
                axis = self._turns[link.parent][:, : TERMS + 1]
                torque = scaled(axis, along)[:, TERMS] + self._drive(link)
                total[:, motion.rate] += abs(motion.scale) * torque
            if link.parent >= 0:
                below = forces[link.parent]
                arm = self._arms[i][:, : TERMS + 1]
                forces[link.parent] = below[0] + force, below[1] + moment + scaled(arm, force)
        return total

    def _place(self, i: int, link: Link) -> None:
        motion = link.motion
        before = self._turns[link.parent]
        bound = abs(motion.scale) * self._bounds[:, :, motion.rate]
        rate, reach = self._rates[link.parent], np.zeros_like(bound)
        reach[:, 0] = np.linalg.norm(link.X_PF[:3, 3])
        match motion.kind:
            case Kind.SLIDE:
                at = motion.scale * self._bases[:, motion.position] + motion.offset
                reach = reach + bound
                reach[:, 0] += np.abs(at)
            case Kind.TURN:
                rate = rate + derivative(bound, 1)
            case Kind.SPIN:
                rate = rate + velocity_series(bound[..., None, None], bound[..., None], 1.0)[..., 0]
        self._rates[i], self._turns[i] = rate, grown(rate)
        self._arms[i] = scaled(before, reach)
        self._places[i] = self._places[link.parent] + self._arms[i]

    def _drive(self, link: Link) -> Array:
        motion = link.motion
        bound = abs(motion.scale) * self._bounds[:, :, motion.rate]
        speed = motion.damping * derivative(bound, 1)[:, TERMS]
        return speed + motion.rotor * resisted(bound, self._order, TERMS + 1)[:, TERMS]

    def _force(self, i: int, link: Link) -> tuple[Array, Array]:
        zero = np.zeros((len(self._bounds), TERMS + 1))
        if link.mass <= 0:
            return zero, zero
        turn = self._turns[i]
        arm = float(np.linalg.norm(link.center)) * turn
        force = resisted(self._places[i] + arm, self._order, TERMS + 1)
        force[:, 0] += self._gravity
        force = link.mass * force
        sizes, _ = link.moments
        changes = resisted(turn, self._order, TERMS + 1)
        spread = float(np.abs(sizes).sum()) * scaled(turn[:, : TERMS + 1], changes)
        return force, scaled(arm[:, : TERMS + 1], force) + spread
