"""Newton-Euler recursion: joint torques along short segments of a motion as Taylor series.

With R(t) and p(t) of each link as Taylor series about a segment's middle, from the tips down to
the base,

    F = m (c'' - g),   N = sum s_k (R e_k) x (R e_k)'',
    f = F + sum f_child,   n = N + (c - p) x F + sum (n_child + (p_child - p) x f_child),

and the torque of a revolute joint about the axis a is a . n, the force of a prismatic one along it
a . f: the recursive Newton-Euler algorithm in the world's axes (Featherstone, "Rigid body dynamics
algorithms", 2008, section 5.3, with N as in `links`).

Followed at t = s(clock) the motion has c'' s'^2 + c' s'' for c'', and so have all inertial terms.
With the second derivative (`order` 2) they give the share of s'^2, with the first that of s'', and
with order 0 the static load.
"""

import numpy as np

from planning.certify.intervals.angular_rates import angular_velocity_series
from planning.certify.intervals.taylor import (
    cross,
    derivative,
    dot,
    product,
    scaled,
    sine_and_cosine,
    skew,
)
from planning.certify.torque.joint_motion import MotionKind
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
        identity = np.zeros((count, terms, 3, 3))
        identity[:, 0] = np.eye(3)
        # The world is the last entry, at index -1.
        self._rotations = [identity] * (len(links) + 1)
        self._positions = [np.zeros((count, terms, 3))] * (len(links) + 1)
        self._axes = [np.zeros(0)] * len(links)

    def run(self) -> Array:
        """Return Taylor coefficients, shape (n, k, nv)."""
        for i, link in enumerate(self._links):
            self._update_pose(i, link)
        forces = [self._force(i, link) for i, link in enumerate(self._links)]
        total = np.zeros((len(self._tangents), TERMS, self._tangents.shape[2]))
        for i in reversed(range(len(self._links))):
            link, (force, moment) = self._links[i], forces[i]
            motion = link.motion
            if motion.kind is MotionKind.SPHERICAL:
                total[:, :, motion.velocity_index : motion.velocity_index + 3] += moment
            else:
                load = moment if motion.kind is MotionKind.REVOLUTE else force
                torque = dot(self._axes[i][:, :TERMS], load) + self._drive_torque(link)
                total[:, :, motion.velocity_index] += motion.scale * torque
            if link.parent >= 0:
                parent_force = forces[link.parent]
                arm = (self._positions[i] - self._positions[link.parent])[:, :TERMS]
                forces[link.parent] = (
                    parent_force[0] + force,
                    parent_force[1] + moment + cross(arm, force),
                )
        return total

    def _update_pose(self, i: int, link: Link) -> None:
        """Compute R, p and the axis of a link."""
        motion = link.motion
        parent_rotation = self._rotations[link.parent]
        rotation = parent_rotation @ link.X_PF[:3, :3]
        position = self._positions[link.parent] + parent_rotation @ link.X_PF[:3, 3]
        axis = rotation @ motion.axis
        match motion.kind:
            case MotionKind.PRISMATIC:
                position = position + scaled(self._coordinate(link), axis)
            case MotionKind.REVOLUTE:
                sine, cosine = sine_and_cosine(self._coordinate(link))
                quarter = rotation @ skew(motion.axis)
                rotation = rotation + scaled(sine, quarter)
                rotation = rotation + scaled(_one_minus(cosine), quarter @ skew(motion.axis))
            case MotionKind.SPHERICAL:
                rotation = product(rotation, self._spherical_rotation(link))
        self._rotations[i], self._positions[i], self._axes[i] = rotation, position, axis

    def _coordinate(self, link: Link) -> Array:
        motion = link.motion
        series = motion.scale * self._tangents[:, :, motion.velocity_index]
        series[:, 0] += motion.scale * self._bases[:, motion.position_index] + motion.offset
        return series

    def _drive_torque(self, link: Link) -> Array:
        """Return the torque of damping and rotor inertia."""
        motion, coordinate = link.motion, self._coordinate(link)
        speed = motion.damping * derivative(coordinate, 1)[:, :TERMS]
        return speed + motion.rotor_inertia * inertial_derivative(coordinate, self._order, TERMS)

    def _spherical_rotation(self, link: Link) -> Array:
        """Return R_0 exp(delta(t)) from R' = R [omega], omega from `angular_rates`."""
        velocity_index, position_index = link.motion.velocity_index, link.motion.position_index
        delta = self._tangents[:, :, velocity_index : velocity_index + 3]
        omega = skew(angular_velocity_series(delta))
        base = multiply(self._bases[:, position_index : position_index + 4], exp(delta[:, 0]))
        rotations = np.zeros((*delta.shape, 3))
        rotations[:, 0] = matrix(base)
        for k in range(1, delta.shape[1]):
            terms = rotations[:, :k] @ omega[:, k - 1 :: -1][:, :k]
            rotations[:, k] = terms.sum(axis=1) / k
        return rotations

    def _force(self, i: int, link: Link) -> tuple[Array, Array]:
        """Return F, and N plus F's moment about the link's origin."""
        zero = np.zeros((len(self._tangents), TERMS, 3))
        if link.mass <= 0:
            return zero, zero
        rotation = self._rotations[i]
        arm = rotation @ link.center
        force = inertial_derivative(self._positions[i] + arm, self._order, TERMS)
        force[:, 0] -= self._gravity
        force = link.mass * force
        moment = cross(arm[:, :TERMS], force)
        eigenvalues, eigenvectors = link.principal_second_moments
        points = rotation @ eigenvectors
        derivatives = inertial_derivative(points, self._order, TERMS)
        for eigenvalue, k in zip(eigenvalues, range(3), strict=True):
            moment = moment + eigenvalue * cross(points[:, :TERMS, :, k], derivatives[:, :, :, k])
        return force, moment


def inertial_derivative(series: Array, order: int, terms: int) -> Array:
    """Return the derivative of a motion in the inertial terms, order 1 or 2; zero for order 0."""
    return derivative(series, order)[:, :terms] if order else np.zeros_like(series[:, :terms])


def _one_minus(cosine: Array) -> Array:
    """Return 1 - cos."""
    difference = -cosine
    difference[:, 0] += 1.0
    return difference
