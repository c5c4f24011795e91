"""Torque remainder: bounds on the error of the torques' Taylor polynomials.

The recursion for the torques gives these bounds too: with bounds on norms for vectors, products for
cross products and plus for every sign. A rotation by q(t) has the majorant exp(sum b_i x^i), b_i
bounding the i-th coefficient of q: the exponential series of a rotation, without its constant.

The majorants bound rounding errors, too: if e_i bounds the error of the coefficients of q, the
error of the torques' is at most the growth of the recursion's result from b_i to b_i + e_i. For a
rotation the constant counts then: exp(e_0).
"""

import numpy as np

from planning.certify.intervals.angular_rates import velocity_series
from planning.certify.intervals.rounding import UNIT
from planning.certify.intervals.taylor import derivative, enlarged, expand_at, scaled
from planning.certify.torque.link_motion import Kind
from planning.certify.torque.links import Link
from planning.certify.torque.newton_euler import TERMS, resisted
from planning.domain.arrays import Array

# Bound on the relative rounding error of sums and products.
_ROUNDED = 2**13 * UNIT


def missed(
    links: tuple[Link, ...],
    gravity: Array,
    motion: tuple[Array, Array, Array],
    hidden: Array,
    order: int,
) -> Array:
    """Bound remainder and rounding errors of the torques' polynomials of `TERMS` powers, (n, nv).

    The remainder of the series on |t - t_m| <= h is at most T h^k (Lagrange), where T bounds the
    coefficient of the first omitted power k at every instant of the segment.

    Args:
        links: The links, parents before children.
        gravity: Gravity vector g [m/s^2].
        motion: Taylor coefficients about the segments' middles, shape (n, k, nv), anchor
            configurations of the pieces, (n, nq), and half of the segments' widths [s].
        hidden: Bound on the errors of the coefficients, shape (n, k, nv).
        order: Order of the derivative in the inertial terms.
    """
    tangents, bases, halves = motion
    sizes, off = (_lengths(links, np.abs(part)) for part in (tangents, hidden))
    near = TorqueRemainderBound(links, gravity, (sizes + off, bases, halves), order).run()
    wide = (sizes + 2 * off, bases, halves)
    far = TorqueRemainderBound(links, gravity, wide, order, off[:, 0]).run()
    powers = halves[:, None] ** np.arange(TERMS + 1)
    errors = (far - near + _ROUNDED * far) * powers[:, :, None]
    return near[:, TERMS] * powers[:, TERMS, None] + errors[:, :TERMS].sum(axis=1)


def _lengths(links: tuple[Link, ...], sizes: Array) -> Array:
    """Return norms of coefficients, with each rotation in space as one norm, at its first."""
    found = np.array(sizes)
    for link in links:
        if link.motion.kind is Kind.SPIN:
            spin = slice(link.motion.rate, link.motion.rate + 3)
            found[:, :, link.motion.rate] = np.linalg.norm(sizes[:, :, spin], axis=2)
    return found


class TorqueRemainderBound:
    """Bounds on coefficients at every instant of a segment, up to the first omitted power."""

    def __init__(
        self,
        links: tuple[Link, ...],
        gravity: Array,
        motion: tuple[Array, Array, Array],
        order: int = 2,
        constants: Array | None = None,
    ) -> None:
        self._links, self._gravity, self._order = links, float(np.linalg.norm(gravity)), order
        sizes, self._bases, halves = motion
        self._constants = np.zeros_like(sizes[:, 0]) if constants is None else constants
        # sum C(m, k) |q_m| h^(m - k) bounds the k-th coefficient about any point in [-h, h].
        self._bounds = expand_at(sizes, halves, TERMS + 3)
        count = len(halves)
        still = enlarged(np.zeros((count, TERMS + 2)))
        self._rates = [np.zeros((count, TERMS + 2))] * (len(links) + 1)
        self._turns = [still] * (len(links) + 1)
        self._turned = [np.zeros(count)] * (len(links) + 1)
        self._places = [np.zeros((count, TERMS + 3))] * (len(links) + 1)
        self._arms = [still] * len(links)

    def run(self) -> Array:
        """Return the bounds, shape (n, k, nv)."""
        for i, link in enumerate(self._links):
            self._place(i, link)
        forces = [self._force(i, link) for i, link in enumerate(self._links)]
        total = np.zeros((len(self._bounds), TERMS + 1, self._bounds.shape[2]))
        for i in reversed(range(len(self._links))):
            link, (force, moment) = self._links[i], forces[i]
            motion = link.motion
            if motion.kind is Kind.SPIN:
                total[:, :, motion.rate] += moment
            else:
                along = moment if motion.kind is Kind.TURN else force
                axis = self._turns[link.parent][:, : TERMS + 1]
                torque = scaled(axis, along) + self._drive(link)
                total[:, :, motion.rate] += abs(motion.scale) * torque
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
                # The angle itself does not matter; see `angular_rates`.
                spin = np.array(bound)
                spin[:, 0] = self._constants[:, motion.rate]
                rate = rate + velocity_series(spin[..., None, None], spin[..., None], 1.0)[..., 0]
        constant = 0.0 * bound[:, 0]
        if motion.kind is not Kind.SLIDE:
            constant = abs(motion.scale) * self._constants[:, motion.rate]
        self._turned[i] = self._turned[link.parent] + constant
        self._rates[i], self._turns[i] = rate, enlarged(rate) * np.exp(self._turned[i])[:, None]
        self._arms[i] = scaled(before, reach)
        self._places[i] = self._places[link.parent] + self._arms[i]

    def _drive(self, link: Link) -> Array:
        motion = link.motion
        bound = abs(motion.scale) * self._bounds[:, :, motion.rate]
        speed = motion.damping * derivative(bound, 1)[:, : TERMS + 1]
        return speed + motion.rotor * resisted(bound, self._order, TERMS + 1)

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
