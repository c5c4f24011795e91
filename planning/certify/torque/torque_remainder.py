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
from planning.certify.intervals.rounding import UNIT_ROUNDOFF
from planning.certify.intervals.taylor import derivative, enlarged, expand_at, scaled
from planning.certify.torque.joint_motion import MotionKind
from planning.certify.torque.links import Link
from planning.certify.torque.newton_euler import TERMS, inertial_derivative
from planning.domain.arrays import Array

# Bound on the relative rounding error of sums and products.
_RELATIVE_ROUNDING = 2**13 * UNIT_ROUNDOFF


def torque_errors(
    links: tuple[Link, ...],
    gravity: Array,
    motion: tuple[Array, Array, Array],
    coefficient_errors: Array,
    order: int,
) -> Array:
    """Bound remainder and rounding errors of the torques' polynomials of `TERMS` powers, (n, nv).

    The remainder of the series on |t - t_m| <= h is at most T h^k (Lagrange), where T bounds the
    coefficient of the first omitted power k at every instant of the segment.

    Args:
        links: The links, parents before children.
        gravity: Gravity vector g [m/s^2].
        motion: Taylor coefficients about the segments' middles, shape (n, k, nv), base
            configurations of the pieces, (n, nq), and half of the segments' widths [s].
        coefficient_errors: Bound on the errors of the coefficients, shape (n, k, nv).
        order: Order of the derivative in the inertial terms.
    """
    tangents, bases, halves = motion
    sizes, size_errors = (_norms(links, np.abs(part)) for part in (tangents, coefficient_errors))
    outer = (sizes + size_errors, bases, halves)
    bound = TorqueRemainderBound(links, gravity, outer, order).run()
    wider = (sizes + 2 * size_errors, bases, halves)
    wider_bound = TorqueRemainderBound(links, gravity, wider, order, size_errors[:, 0]).run()
    powers = halves[:, None] ** np.arange(TERMS + 1)
    errors = (wider_bound - bound + _RELATIVE_ROUNDING * wider_bound) * powers[:, :, None]
    return bound[:, TERMS] * powers[:, TERMS, None] + errors[:, :TERMS].sum(axis=1)


def _norms(links: tuple[Link, ...], sizes: Array) -> Array:
    """Return norms of coefficients, with each rotation in space as one norm, at its first."""
    norms = np.array(sizes)
    for link in links:
        if link.motion.kind is MotionKind.SPHERICAL:
            columns = slice(link.motion.velocity_index, link.motion.velocity_index + 3)
            norms[:, :, link.motion.velocity_index] = np.linalg.norm(sizes[:, :, columns], axis=2)
    return norms


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
        identity = enlarged(np.zeros((count, TERMS + 2)))
        self._rates = [np.zeros((count, TERMS + 2))] * (len(links) + 1)
        self._rotations = [identity] * (len(links) + 1)
        self._rotation_errors = [np.zeros(count)] * (len(links) + 1)
        self._positions = [np.zeros((count, TERMS + 3))] * (len(links) + 1)
        self._arms = [identity] * len(links)

    def run(self) -> Array:
        """Return the bounds, shape (n, k, nv)."""
        for i, link in enumerate(self._links):
            self._update_pose(i, link)
        forces = [self._force(i, link) for i, link in enumerate(self._links)]
        total = np.zeros((len(self._bounds), TERMS + 1, self._bounds.shape[2]))
        for i in reversed(range(len(self._links))):
            link, (force, moment) = self._links[i], forces[i]
            motion = link.motion
            if motion.kind is MotionKind.SPHERICAL:
                total[:, :, motion.velocity_index] += moment
            else:
                load = moment if motion.kind is MotionKind.REVOLUTE else force
                axis = self._rotations[link.parent][:, : TERMS + 1]
                torque = scaled(axis, load) + self._drive_torque(link)
                total[:, :, motion.velocity_index] += abs(motion.scale) * torque
            if link.parent >= 0:
                parent_force = forces[link.parent]
                arm = self._arms[i][:, : TERMS + 1]
                forces[link.parent] = (
                    parent_force[0] + force,
                    parent_force[1] + moment + scaled(arm, force),
                )
        return total

    def _update_pose(self, i: int, link: Link) -> None:
        motion = link.motion
        parent_rotation = self._rotations[link.parent]
        bound = abs(motion.scale) * self._bounds[:, :, motion.velocity_index]
        rate, arm = self._rates[link.parent], np.zeros_like(bound)
        arm[:, 0] = np.linalg.norm(link.X_PF[:3, 3])
        match motion.kind:
            case MotionKind.PRISMATIC:
                coordinate = motion.scale * self._bases[:, motion.position_index] + motion.offset
                arm = arm + bound
                arm[:, 0] += np.abs(coordinate)
            case MotionKind.REVOLUTE:
                rate = rate + derivative(bound, 1)
            case MotionKind.SPHERICAL:
                # The angle itself does not matter; see `angular_rates`.
                tangent = np.array(bound)
                tangent[:, 0] = self._constants[:, motion.velocity_index]
                rate = (
                    rate
                    + velocity_series(tangent[..., None, None], tangent[..., None], 1.0)[..., 0]
                )
        constant = 0.0 * bound[:, 0]
        if motion.kind is not MotionKind.PRISMATIC:
            constant = abs(motion.scale) * self._constants[:, motion.velocity_index]
        self._rotation_errors[i] = self._rotation_errors[link.parent] + constant
        self._rates[i], self._rotations[i] = (
            rate,
            enlarged(rate) * np.exp(self._rotation_errors[i])[:, None],
        )
        self._arms[i] = scaled(parent_rotation, arm)
        self._positions[i] = self._positions[link.parent] + self._arms[i]

    def _drive_torque(self, link: Link) -> Array:
        motion = link.motion
        bound = abs(motion.scale) * self._bounds[:, :, motion.velocity_index]
        speed = motion.damping * derivative(bound, 1)[:, : TERMS + 1]
        return speed + motion.rotor_inertia * inertial_derivative(bound, self._order, TERMS + 1)

    def _force(self, i: int, link: Link) -> tuple[Array, Array]:
        zero = np.zeros((len(self._bounds), TERMS + 1))
        if link.mass <= 0:
            return zero, zero
        rotation = self._rotations[i]
        arm = float(np.linalg.norm(link.center)) * rotation
        force = inertial_derivative(self._positions[i] + arm, self._order, TERMS + 1)
        force[:, 0] += self._gravity
        force = link.mass * force
        eigenvalues, _ = link.principal_second_moments
        derivatives = inertial_derivative(rotation, self._order, TERMS + 1)
        moment = float(np.abs(eigenvalues).sum()) * scaled(rotation[:, : TERMS + 1], derivatives)
        return force, scaled(arm[:, : TERMS + 1], force) + moment
