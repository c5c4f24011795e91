"""Steering: planar bases that roll like a car, never sideways, with a smallest turning radius.

Where a plain planar joint goes straight from pose to pose, a steered one follows the motion of
constant velocity in its own frame: an arc, or a line. That is the geodesic of SE(2) as a group,
X_1 = X_0 exp(v_x, v_y, omega), with v_y = 0 where a car can follow it (Sola et al. 2018,
appendix A; Lynch and Park, "Modern Robotics", 2017, section 3.2.3). With one radian for one metre
it has the constant speed sqrt(v_x^2 + omega^2).
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import override

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.robot.joints import JointGroup, offsets_of
from planning.domain.robot.manifold import Manifold
from planning.domain.value import Value

# Angles smaller than this use the series of the quotients by them [rad].
_SMALL = 1e-4


@dataclass(frozen=True, eq=False)
class Steering(Value):
    """Steering limits of a car-like base.

    Attributes:
        turning_radius: Smallest turning radius of the base's origin [m], above 0.
        reverse: Whether it drives backwards too: its shortest paths are Reeds and Shepp's, else
            Dubins'.
    """

    turning_radius: float
    reverse: bool = True


@dataclass(frozen=True, eq=False)
class SteeredGroup(JointGroup):
    """Joint group with some planar joints steered.

    Attributes:
        steering: By full name of a planar joint.
    """

    steering: Mapping[str, Steering] = field(default_factory=dict)


def steering_of(group: JointGroup) -> Mapping[str, Steering]:
    """Return the steering of a group's planar joints, by name; empty for most groups."""
    return group.steering if isinstance(group, SteeredGroup) else {}


def steered(group: JointGroup, steering: Mapping[str, Steering]) -> JointGroup:
    """Return the group with some of its planar joints steered; a plain group without any."""
    if not steering:
        return JointGroup(group.name, group.joints, group.tool_frames, group.winding)
    return SteeredGroup(group.name, group.joints, group.tool_frames, group.winding, steering)


def manifold_of(group: JointGroup) -> Manifold:
    """Return the manifold whose geodesics a group's motions follow between waypoints."""
    names = tuple(joint.name for joint in group.joints if joint.name in steering_of(group))
    return SteeredManifold(group.joints, names) if names else Manifold.of(group.joints)


@dataclass(frozen=True, eq=False)
class SteeredManifold(Manifold):
    """Configuration manifold on which the geodesics of steered joints are arcs and lines.

    The tangent of a steered joint is (v_x, v_y, omega) in the base's own frame. `distance` counts
    v_y like any other number, so for poses that no single arc joins it is their distance, not the
    length that a car must drive.

    Attributes:
        cars: Full names of the steered joints.
    """

    cars: tuple[str, ...] = ()

    @cached_property
    @override
    def is_flat(self) -> bool:
        """False: a tangent of a steered joint is not a difference of coordinates."""
        return False

    @cached_property
    def offsets(self) -> tuple[tuple[int, int], ...]:
        """First index of each steered joint's coordinates in q and in v."""
        return offsets_of(self.joints, lambda joint: joint.name in self.cars)

    @override
    def plus(self, q: Float64[np.ndarray, "*#n nq"], delta: Float64[np.ndarray, "*#n nv"]) -> Array:
        """Return the configuration after a unit of time at the constant velocity delta."""
        moved = super().plus(q, delta)
        for iq, iv in self.offsets:
            v_x, v_y, angle = (delta[..., iv + i] for i in range(3))
            sinc, cosinc = _sinc_and_cosinc(angle)
            x = sinc * v_x - cosinc * v_y
            y = cosinc * v_x + sinc * v_y
            c, s = np.cos(q[..., iq + 2]), np.sin(q[..., iq + 2])
            moved[..., iq] = q[..., iq] + c * x - s * y
            moved[..., iq + 1] = q[..., iq + 1] + s * x + c * y
        return moved

    @override
    def minus(self, q1: Float64[np.ndarray, "*#n nq"], q0: Float64[np.ndarray, "*#n nq"]) -> Array:
        """Return the constant velocity from q0 to q1 in a unit of time, by half a turn at most."""
        delta = super().minus(q1, q0)
        for iq, iv in self.offsets:
            x, y = (q1[..., iq + i] - q0[..., iq + i] for i in range(2))
            c, s = np.cos(q0[..., iq + 2]), np.sin(q0[..., iq + 2])
            x, y = c * x + s * y, c * y - s * x
            sinc, cosinc = _sinc_and_cosinc(delta[..., iv + 2])
            squared_norm = sinc**2 + cosinc**2
            delta[..., iv] = (sinc * x + cosinc * y) / squared_norm
            delta[..., iv + 1] = (sinc * y - cosinc * x) / squared_norm
        return delta


def _sinc_and_cosinc(angle: Array) -> tuple[Array, Array]:
    """Return sin(angle) / angle and (1 - cos(angle)) / angle."""
    small = np.abs(angle) < _SMALL
    safe = np.where(small, 1.0, angle)
    # 1 - cos is 2 sin^2 of half the angle, which does not cancel.
    sinc = np.where(small, 1 - angle**2 / 6, np.sin(safe) / safe)
    cosinc = np.where(small, angle / 2 - angle**3 / 24, 2 * np.sin(safe / 2) ** 2 / safe)
    return sinc, cosinc
