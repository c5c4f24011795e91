"""Newton-Euler recursion: joint torques along short segments of a motion as Taylor series.

With R(t) and p(t) of each link as Taylor series about a segment's middle, from the tips down to
the base,

    F = m (c'' - g),   N = sum s_k (R e_k) x (R e_k)'',
    f = F + sum f_child,   n = N + (c - p) x F + sum (n_child + (p_child - p) x f_child),

and the torque of a turn about a is a . n, the force of a slide along it a . f: the recursive
Newton-Euler algorithm in the world's axes (Featherstone, "Rigid body dynamics algorithms", 2008,
section 5.3, with N as in `links`).
Followed at t = s(clock) the motion has c'' s'^2 + c' s'' for c'', and so have all inertial terms.
With the second derivative (`order` 2) they give the share of s'^2, with the first that of s'', and
with order 0 the static load.
"""

import numpy as np

from planning.certify.intervals.angular_rates import turn_rates
from planning.certify.intervals.taylor import (
    cross,
    derivative,
    dot,
    product,
    scaled,
    sine_and_cosine,
    skew,
)
from planning.certify.torque.link_motion import Kind
from planning.certify.torque.links import Link
from planning.domain.arrays import Array
from planning.domain.geometry.rotation import exp, matrix, multiply

# Number of coefficients of the torques' polynomials: powers 0 to TERMS - 1.
TERMS = 5


class TorqueRecursion:
    """Recursion for the Taylor coefficients of the torques."""

    def __init__(
        self, links: tuple[Link, ...], gravity: Array, motion: tuple[Array, Array], order: int = 2
    ) -> None:
        self._links, self._gravity, self._order = links, gravity, order
        tangents, bases = motion
        self._tangents, self._bases = tangents, bases
        count, terms, _ = tangents.shape
        still = np.zeros((count, terms, 3, 3))
        still[:, 0] = np.eye(3)
        # The world is the last entry, at index -1.
        self._turns = [still] * (len(links) + 1)
        self._places = [np.zeros((count, terms, 3))] * (len(links) + 1)
        self._axes = [np.zeros(0)] * len(links)

    def run(self) -> Array:
        """Return Taylor coefficients, shape (n, k, nv)."""
        for i, link in enumerate(self._links):
            self._place(i, link)
        forces = [self._force(i, link) for i, link in enumerate(self._links)]
        total = np.zeros((len(self._tangents), TERMS, self._tangents.shape[2]))
        for i in reversed(range(len(self._links))):
            link, (force, moment) = self._links[i], forces[i]
            motion = link.motion
            if motion.kind is Kind.SPIN:
                total[:, :, motion.rate : motion.rate + 3] += moment
            else:
                along = moment if motion.kind is Kind.TURN else force
                torque = dot(self._axes[i][:, :TERMS], along) + self._drive(link)
                total[:, :, motion.rate] += motion.scale * torque
            if link.parent >= 0:
                below = forces[link.parent]
                arm = (self._places[i] - self._places[link.parent])[:, :TERMS]
                forces[link.parent] = below[0] + force, below[1] + moment + cross(arm, force)
        return total

    def _place(self, i: int, link: Link) -> None:
        """Compute R, p and the axis of a link."""
        motion = link.motion
        before = self._turns[link.parent]
        turn = before @ link.X_PF[:3, :3]
        place = self._places[link.parent] + before @ link.X_PF[:3, 3]
        axis = turn @ motion.axis
        match motion.kind:
            case Kind.SLIDE:
                place = place + scaled(self._coordinate(link), axis)
            case Kind.TURN:
                sine, cosine = sine_and_cosine(self._coordinate(link))
                quarter = turn @ skew(motion.axis)
                turn = turn + scaled(sine, quarter)
                turn = turn + scaled(_one_less(cosine), quarter @ skew(motion.axis))
            case Kind.SPIN:
                turn = product(turn, self._spin(link))
        self._turns[i], self._places[i], self._axes[i] = turn, place, axis

    def _coordinate(self, link: Link) -> Array:
        motion = link.motion
        series = motion.scale * self._tangents[:, :, motion.rate]
        series[:, 0] += motion.scale * self._bases[:, motion.position] + motion.offset
        return series

    def _drive(self, link: Link) -> Array:
        """Return the torque of damping and rotor inertia."""
        motion, coordinate = link.motion, self._coordinate(link)
        speed = motion.damping * derivative(coordinate, 1)[:, :TERMS]
        return speed + motion.rotor * resisted(coordinate, self._order, TERMS)

    def _spin(self, link: Link) -> Array:
        """Return R_0 exp(delta(t)) from R' = R [omega], omega from `angular_rates`."""
        rate, at = link.motion.rate, link.motion.position
        delta = self._tangents[:, :, rate : rate + 3]
        omega = skew(turn_rates(delta))
        base = multiply(self._bases[:, at : at + 4], exp(delta[:, 0]))
        spun = np.zeros((*delta.shape, 3))
        spun[:, 0] = matrix(base)
        for k in range(1, delta.shape[1]):
            terms = spun[:, :k] @ omega[:, k - 1 :: -1][:, :k]
            spun[:, k] = terms.sum(axis=1) / k
        return spun

    def _force(self, i: int, link: Link) -> tuple[Array, Array]:
        """Return F, and N plus F's moment about the link's origin."""
        zero = np.zeros((len(self._tangents), TERMS, 3))
        if link.mass <= 0:
            return zero, zero
        turn = self._turns[i]
        arm = turn @ link.center
        force = resisted(self._places[i] + arm, self._order, TERMS)
        force[:, 0] -= self._gravity
        force = link.mass * force
        moment = cross(arm[:, :TERMS], force)
        sizes, vectors = link.moments
        points = turn @ vectors
        changes = resisted(points, self._order, TERMS)
        for size, k in zip(sizes, range(3), strict=True):
            moment = moment + size * cross(points[:, :TERMS, :, k], changes[:, :, :, k])
        return force, moment


def resisted(series: Array, order: int, terms: int) -> Array:
    """Return the derivative of a motion in the inertial terms, order 1 or 2; zero for order 0."""
    return derivative(series, order)[:, :terms] if order else np.zeros_like(series[:, :terms])


def _one_less(cosine: Array) -> Array:
    """Return 1 - cos."""
    less = -cosine
    less[:, 0] += 1.0
    return less
