"""JointPath: untimed waypoints joined by geodesics, which are arcs for steered bases."""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from jaxtyping import Float64

from planning.domain.curves.arcs import arcs_through
from planning.domain.curves.curve import JointSpline
from planning.domain.robot.joints import JointGroup
from planning.domain.robot.steering import SteeredManifold, manifold_of
from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class JointPath(Value):
    """Geometric path in joint space, without time.

    Attributes:
        group: Group of the waypoints.
        waypoints: Shape (n, nq), n >= 2, from start to goal.
    """

    group: JointGroup
    waypoints: Float64[np.ndarray, "n nq"]

    @cached_property
    def length(self) -> float:
        """Sum of the geodesics' lengths (radians and metres weigh the same)."""
        manifold = manifold_of(self.group)
        return float(manifold.distance(self.waypoints[1:], self.waypoints[:-1]).sum())

    @property
    def continuous(self) -> "JointPath":
        """The same path with continuous numbers: no jumps by whole turns or signs of quaternions.

        The first waypoint stays as it is.
        """
        manifold = manifold_of(self.group)
        if manifold.is_vector_space:
            return JointPath(self.group, _running_sums(self.waypoints))
        rows = [self.waypoints[0]]
        for waypoint in self.waypoints[1:]:
            rows.append(manifold.plus(rows[-1], manifold.minus(waypoint, rows[-1])))
        return JointPath(self.group, manifold.normalized(np.stack(rows)))

    @property
    def straight(self) -> "JointPath":
        """Geodesic between the ends of the path."""
        return JointPath(self.group, self.waypoints[[0, -1]])

    @property
    def spline(self) -> JointSpline:
        """The path as a curve: of degree one, or of degree five where it follows arcs."""
        manifold = manifold_of(self.group)
        if isinstance(manifold, SteeredManifold):
            return arcs_through(manifold, self.waypoints)
        return JointSpline.through(self.group.joints, self.waypoints)


def _running_sums(waypoints: Float64[np.ndarray, "n nq"]) -> Float64[np.ndarray, "n nq"]:
    """Return each waypoint as the one before it plus the step to it, which may be rounded."""
    rows = waypoints.tolist()
    for before, here in pairwise(rows):
        here[:] = [a + (b - a) for a, b in zip(before, here, strict=True)]
    return np.array(rows)
