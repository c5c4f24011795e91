"""JointMetric: weighted joint-space distance of configurations, with a weight per joint."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.robot.joints import JointGroup
from planning.domain.robot.manifold import Manifold
from planning.errors import ProblemInvalid, UnknownName


@dataclass(frozen=True)
class JointMetric:
    """d(q) = |w * (q [-] start)|: the Euclidean length of the weighted geodesic.

    Attributes:
        manifold: Configuration manifold of the group.
        weights: Weight per velocity coordinate, shape (nv,); None if all are 1.
    """

    manifold: Manifold
    weights: Array | None

    @classmethod
    def from_names(cls, group: JointGroup, by_joint: Mapping[str, float]) -> "JointMetric":
        """Build from weights by full joint name; joints that are not named have weight 1.

        Raises:
            UnknownName: The group has no such joint.
            ProblemInvalid: A weight is negative or not finite.
        """
        names = [joint.name for joint in group.joints]
        for name, weight in by_joint.items():
            if name not in names:
                raise UnknownName.among("joint", name, names)
            if not (np.isfinite(weight) and weight >= 0):
                message = f"ik.joint_weights.{name} must be finite and not negative, got {weight}"
                raise ProblemInvalid(message, {"field": f"ik.joint_weights.{name}"})
        if not by_joint:
            return cls(Manifold.of(group.joints), None)
        weights = [
            by_joint.get(joint.name, 1.0)
            for joint in group.joints
            for _ in range(joint.num_velocities)
        ]
        return cls(Manifold.of(group.joints), np.array(weights, dtype=np.float64))

    def distance(
        self, rows: Float64[np.ndarray, "n nq"], start: Float64[np.ndarray, " nq"]
    ) -> Array:
        """Return the weighted distance of each row from the start; radians and metres are mixed."""
        if self.weights is None:
            return self.manifold.distance(rows, start[None])
        delta = self.manifold.minus(rows, start[None])
        return np.asarray(np.linalg.norm(self.weights * delta, axis=-1))
