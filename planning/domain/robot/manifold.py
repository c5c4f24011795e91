"""Manifold: the configuration space of some joints, with plus, minus, interpolation and distance.

`q [+] delta` moves along the geodesic that leaves q with tangent delta in R^nv; `q1 [-] q0` is the
shortest such delta. R^1 for bounded joints, the circle for continuous joints and a planar joint's
yaw, SO(3) x R^3 for floating joints (right-perturbed: R exp(delta), p + delta). See Sola et al.
(2018), section II-E. Everything takes stacks along leading axes.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.geometry import rotation
from planning.domain.robot.joints import Joint, JointType, offsets_of
from planning.domain.value import Value

# Manifolds by the id() of their joints; each keeps its joints alive, so no id() is reused.
_cache: dict[int, "Manifold"] = {}
_MAX_CACHED = 256


@dataclass(frozen=True, eq=False)
class Manifold(Value):
    """Configuration manifold: the product of the joints' manifolds, in the joints' order."""

    joints: tuple[Joint, ...]

    @staticmethod
    def of(joints: tuple[Joint, ...]) -> "Manifold":
        """Return the manifold of a tuple of joints, cached by the identity of the tuple."""
        found = _cache.get(id(joints))
        if found is None:
            if len(_cache) >= _MAX_CACHED:
                _cache.clear()
            found = _cache[id(joints)] = Manifold(joints)
        return found

    @cached_property
    def num_positions(self) -> int:
        """Length of q."""
        return sum(joint.num_positions for joint in self.joints)

    @cached_property
    def num_velocities(self) -> int:
        """Length of v and of delta."""
        return sum(joint.num_velocities for joint in self.joints)

    @cached_property
    def is_flat(self) -> bool:
        """Whether q and delta are the same numbers, up to whole turns."""
        return all(joint.type is not JointType.FLOATING for joint in self.joints)

    @cached_property
    def _floating(self) -> tuple[tuple[int, int], ...]:
        """Offset in q and in v of each floating joint."""
        return offsets_of(self.joints, lambda joint: joint.type is JointType.FLOATING)

    @cached_property
    def _additive_indices(self) -> tuple[list[int], list[int]]:
        """Indices in q and in v of the coordinates that simply add."""
        in_q = set(range(self.num_positions))
        in_v = set(range(self.num_velocities))
        for iq, iv in self._floating:
            in_q -= set(range(iq, iq + 7))
            in_v -= set(range(iv, iv + 6))
        return sorted(in_q), sorted(in_v)

    @cached_property
    def wraps(self) -> tuple[bool, ...]:
        """Whether each velocity coordinate is an angle on a circle, modulo whole turns."""
        return tuple(flag for joint in self.joints for flag in joint.wraps)

    @cached_property
    def _circles(self) -> tuple[int, ...]:
        """Indices of the velocity coordinates that are angles on a circle."""
        return tuple(i for i, wraps in enumerate(self.wraps) if wraps)

    @cached_property
    def is_vector_space(self) -> bool:
        """Whether q and delta are the same numbers: no circle and no rotation among them."""
        return self.is_flat and not any(self.wraps)

    def plus(self, q: Float64[np.ndarray, "*#n nq"], delta: Float64[np.ndarray, "*#n nv"]) -> Array:
        """Return q [+] delta; angles are not wrapped, so curves stay continuous."""
        if self.is_flat:
            return q + delta
        shape = np.broadcast_shapes(q.shape[:-1], delta.shape[:-1])
        moved = np.empty((*shape, self.num_positions))
        in_q, in_v = self._additive_indices
        if in_q:
            moved[..., in_q] = q[..., in_q] + delta[..., in_v]
        for iq, iv in self._floating:
            turned = rotation.multiply(q[..., iq : iq + 4], rotation.exp(delta[..., iv : iv + 3]))
            moved[..., iq : iq + 4] = turned
            moved[..., iq + 4 : iq + 7] = q[..., iq + 4 : iq + 7] + delta[..., iv + 3 : iv + 6]
        return moved

    def minus(self, q1: Float64[np.ndarray, "*#n nq"], q0: Float64[np.ndarray, "*#n nq"]) -> Array:
        """Return the shortest delta with q0 [+] delta = q1 (up to whole turns)."""
        if self.is_vector_space:
            return q1 - q0
        delta = q1 - q0 if self.is_flat else self._minus_floating(q1, q0)
        for i in self._circles:
            delta[..., i] = np.remainder(delta[..., i] + np.pi, 2 * np.pi) - np.pi
        return delta

    def _minus_floating(self, q1: Array, q0: Array) -> Array:
        """Return the same as `minus`, but without removing whole turns of angles."""
        shape = np.broadcast_shapes(q1.shape[:-1], q0.shape[:-1])
        delta = np.empty((*shape, self.num_velocities))
        in_q, in_v = self._additive_indices
        if in_q:
            delta[..., in_v] = q1[..., in_q] - q0[..., in_q]
        for iq, iv in self._floating:
            inverse = rotation.conjugate(q0[..., iq : iq + 4])
            turn = rotation.log(rotation.multiply(inverse, q1[..., iq : iq + 4]))
            delta[..., iv : iv + 3] = turn
            delta[..., iv + 3 : iv + 6] = q1[..., iq + 4 : iq + 7] - q0[..., iq + 4 : iq + 7]
        return delta

    def interpolate(self, q0: Array, q1: Array, s: Float64[np.ndarray, " m"]) -> Array:
        """Return the geodesic from q0 to q1 at fractions s, shape (m, nq)."""
        return self.plus(q0[None], s[:, None] * self.minus(q1, q0)[None])

    def distance(
        self, q1: Float64[np.ndarray, "*#n nq"], q0: Float64[np.ndarray, "*#n nq"]
    ) -> Array:
        """Return the Euclidean length of q1 [-] q0 (radians and metres weigh the same)."""
        delta = self.minus(q1, q0)
        return np.asarray(np.sqrt(np.add.reduce(delta * delta, axis=-1)))

    def normalized(self, q: Float64[np.ndarray, "*n nq"]) -> Array:
        """Return q with unit quaternions."""
        unit = np.array(q)
        if self.is_flat:
            return unit
        for iq, _ in self._floating:
            a = unit[..., iq : iq + 4]
            unit[..., iq : iq + 4] = a / np.linalg.norm(a, axis=-1, keepdims=True)
        return unit

    def generalized_velocity(self, q: Array, delta: Array, rate: Array) -> Array:
        """Return Drake's v at q = base [+] delta where delta' = rate.

        Floating joints: angular velocity in the parent frame, R J_r(delta) delta'.
        """
        v = np.array(rate)
        for iq, iv in self._floating:
            body = rotation.right_jacobian(delta[..., iv : iv + 3], rate[..., iv : iv + 3])
            v[..., iv : iv + 3] = rotation.rotate(q[..., iq : iq + 4], body)
        return v

    def tangent_velocity(self, q: Array, v: Array) -> Array:
        """Return delta' of q [+] delta at delta = 0 from Drake's v.

        The inverse of `generalized_velocity` there: R^T omega of a floating joint.
        """
        rate = np.array(v)
        for iq, iv in self._floating:
            turn_back = rotation.conjugate(q[..., iq : iq + 4])
            rate[..., iv : iv + 3] = rotation.rotate(turn_back, v[..., iv : iv + 3])
        return rate

    def generalized_acceleration(
        self, q: Array, delta: Array, rate: Array, curvature: Array
    ) -> Array:
        """Return Drake's vdot at q = base [+] delta where delta' = rate, delta'' = curvature."""
        vdot = np.array(curvature)
        for iq, iv in self._floating:
            turn = slice(iv, iv + 3)
            body = rotation.body_acceleration(
                delta[..., turn], rate[..., turn], curvature[..., turn]
            )
            vdot[..., turn] = rotation.rotate(q[..., iq : iq + 4], body)
        return vdot
