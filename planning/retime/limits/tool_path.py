"""ToolPath: the path of a frame's origin along a curve of its group, as polynomials in space.

On a short part of the curve the origin's velocity J(q) q' is analytic and nearly a polynomial: it
is interpolated at Chebyshev points (Trefethen, "Approximation Theory and Approximation Practice",
2013, theorem 8.2: the error falls geometrically with the degree) and integrated. Bounds on
polynomials and their blocks of coordinates then apply to the frame as to joints.
"""

from functools import cache
from typing import Any

import numpy as np

from planning.domain.arrays import Array
from planning.domain.curves.curve import Curve, JointSpline
from planning.domain.robot.joints import Joint, JointType
from planning.retime.cells import cut_at, even_edges, num_parts
from planning.world.mechanics.tool_kinematics import ToolKinematics

# Longest part (joint-space length), and number of its interpolation points: the error is below 1e-9
# of the speed.
_MAX_PART_LENGTH, _NUM_POINTS = 0.2, 8
_AXES = tuple(Joint(axis, JointType.PRISMATIC) for axis in ("x", "y", "z"))


class ToolPath:
    """The path of one frame of one group."""

    def __init__(self, kinematics: ToolKinematics) -> None:
        """Prepare; only the last result is cached, for several limits of one frame."""
        self._kinematics = kinematics
        self._last: tuple[Curve, JointSpline] | None = None

    def along(self, curve: Curve) -> JointSpline:
        """Return p_WT [m] as a curve over the same parameter, on the same or shorter pieces.

        Pieces with little motion of the group stay whole.
        """
        if self._last is None or self._last[0] is not curve:
            counts = num_parts(curve, _MAX_PART_LENGTH)
            parts = (
                curve if (counts == 1).all() else cut_at(curve, even_edges(curve.breaks, counts))
            )
            self._last = curve, self._interpolated(parts)
        return self._last[1]

    def _interpolated(self, parts: Curve) -> JointSpline:
        points, inverse = _interpolation()
        widths = np.diff(parts.breaks)
        pieces = np.repeat(np.arange(parts.num_pieces), _NUM_POINTS)
        local = (widths[:, None] * points).ravel()
        q, v = _states(parts, pieces, local)
        velocities = self._kinematics.velocities(q, v).reshape(-1, _NUM_POINTS, 3)
        powers = np.arange(_NUM_POINTS)
        terms = (inverse @ velocities) / (widths[:, None] ** powers * (powers + 1))[:, :, None]
        _, p_wt = self._kinematics.poses(q[::_NUM_POINTS])
        coefficients = np.concatenate([np.zeros_like(terms[:, :1]), terms], axis=1)
        return JointSpline(_AXES, parts.breaks, p_wt, coefficients)


@cache
def _interpolation() -> tuple[Array, Array]:
    """Return Chebyshev points on [0, 1], both ends included, and the matrix to the power basis."""
    points = (1 - np.cos(np.pi * np.arange(_NUM_POINTS) / (_NUM_POINTS - 1))) / 2
    return points, np.linalg.inv(points[:, None] ** np.arange(_NUM_POINTS))


def _states(curve: Curve, pieces: Any, local: Array) -> tuple[Array, Array]:
    """Return q and Drake's generalized velocity on given pieces."""
    powers = np.arange(curve.coefficients.shape[1])
    terms = curve.coefficients[pieces]
    monomials = local[:, None] ** powers
    delta = np.einsum("mk,mkv->mv", monomials, terms)
    rate = np.einsum("mk,mkv->mv", monomials[:, :-1] * powers[1:], terms[:, 1:])
    q = curve.manifold.plus(curve.bases[pieces], delta)
    return q, curve.manifold.generalized_velocity(q, delta, rate)
