"""JointPerturbations: random displacements of a group in its weighted joint metric."""

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.robot.joints import JointGroup, JointType
from planning.domain.robot.manifold import Manifold
from planning.goals.joint_metric import JointMetric

# Largest displacement of a coordinate, reached by coordinates of weight 0 [rad, m].
_MAX_ROTATION, _MAX_TRANSLATION = np.pi, 2.0
# Largest number of coordinates that a sparse displacement changes.
_MAX_SPARSE_COORDINATES = 3


class JointPerturbations:
    """Sampler of random tangent vectors delta with the norm of the metric, |w * delta|."""

    def __init__(self, group: JointGroup, metric: JointMetric, rng: np.random.Generator) -> None:
        """Prepare for a group and its joint metric."""
        self._rng = rng
        count = Manifold(group.joints).num_velocities
        weights = np.ones(count) if metric.weights is None else metric.weights
        self._is_unweighted = weights == 0
        self._scale = 1 / np.where(self._is_unweighted, 1.0, weights)
        kinds = [joint.type for joint in group.joints for _ in joint.velocity_names]
        is_prismatic = [kind is JointType.PRISMATIC for kind in kinds]
        self._max_displacement = np.where(is_prismatic, _MAX_TRANSLATION, _MAX_ROTATION)

    @property
    def max_radius(self) -> float:
        """Norm of the largest displacement worth sampling."""
        weighted = ~self._is_unweighted
        return float(np.linalg.norm(self._max_displacement[weighted] / self._scale[weighted]))

    def sample_ball(self, radius: float, count: int) -> Float64[np.ndarray, "count nv"]:
        """Return displacements of norm at most `radius`: half uniform, half along few coordinates.

        In many dimensions uniform samples of a ball hardly ever lie along the axes, where the
        nearest feasible configuration often is.
        """
        displacements = self._normal_samples(count)
        num_sparse = count // 2
        order = self._rng.random((num_sparse, displacements.shape[1])).argsort(axis=1)
        num_changed = self._rng.integers(1, _MAX_SPARSE_COORDINATES + 1, (num_sparse, 1))
        displacements[:num_sparse][order >= num_changed] = 0.0
        lengths = self._rng.random((count, 1))
        lengths[num_sparse:] **= 1 / displacements.shape[1]
        norms = np.linalg.norm(displacements, axis=1, keepdims=True)
        return self._to_displacements(radius * lengths * displacements / np.maximum(norms, 1e-12))

    def sample_multiscale(self, radius: float, count: int) -> Float64[np.ndarray, "count nv"]:
        """Return displacements of all scales up to about `radius`, most of them much smaller."""
        scales = radius * 10 ** self._rng.uniform(-4.0, -0.5, (count, 1))
        return self._to_displacements(
            scales * self._normal_samples(count) / np.sqrt(len(self._scale))
        )

    def _normal_samples(self, count: int) -> Array:
        displacements = self._rng.normal(size=(count, len(self._scale)))
        displacements[:, self._is_unweighted] = 0.0
        return displacements

    def _to_displacements(self, displacements: Array) -> Array:
        """Return displacements [rad, m]; weight-0 coordinates are uniform in every other row."""
        displacements = displacements * self._scale
        uniform = self._rng.uniform(-1.0, 1.0, displacements[::2].shape) * self._max_displacement
        displacements[::2] = np.where(self._is_unweighted, uniform, displacements[::2])
        return displacements
