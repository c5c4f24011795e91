"""JointPerturbations: random displacements of a group in its weighted joint metric."""

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.robot.joints import JointGroup, JointType
from planning.domain.robot.manifold import Manifold
from planning.goals.joint_metric import JointMetric

# Largest displacement of a coordinate, reached by coordinates of weight 0 [rad, m].
_TURN, _SHIFT = np.pi, 2.0
# Largest number of coordinates that a sparse displacement changes.
_FEW = 3


class JointPerturbations:
    """Sampler of random tangent vectors delta with the norm of the metric, |w * delta|."""

    def __init__(self, group: JointGroup, metric: JointMetric, rng: np.random.Generator) -> None:
        """Prepare for a group and its joint metric."""
        self._rng = rng
        count = Manifold(group.joints).num_velocities
        weights = np.ones(count) if metric.weights is None else metric.weights
        self._is_idle = weights == 0
        self._scale = 1 / np.where(self._is_idle, 1.0, weights)
        kinds = [joint.type for joint in group.joints for _ in joint.velocity_names]
        straight = [kind is JointType.PRISMATIC for kind in kinds]
        self._reach = np.where(straight, _SHIFT, _TURN)

    @property
    def largest(self) -> float:
        """Norm of the largest displacement worth sampling."""
        return float(np.linalg.norm(self._reach[~self._is_idle] / self._scale[~self._is_idle]))

    def within(self, radius: float, count: int) -> Float64[np.ndarray, "count nv"]:
        """Return displacements of norm at most `radius`: half uniform, half along few coordinates.

        In many dimensions uniform samples of a ball hardly ever lie along the axes, where the
        nearest feasible configuration often is.
        """
        moves = self._normal(count)
        few = count // 2
        order = self._rng.random((few, moves.shape[1])).argsort(axis=1)
        moves[:few][order >= self._rng.integers(1, _FEW + 1, (few, 1))] = 0.0
        lengths = self._rng.random((count, 1))
        lengths[few:] **= 1 / moves.shape[1]
        norms = np.linalg.norm(moves, axis=1, keepdims=True)
        return self._unweighted(radius * lengths * moves / np.maximum(norms, 1e-12))

    def about(self, radius: float, count: int) -> Float64[np.ndarray, "count nv"]:
        """Return displacements of all scales up to about `radius`, most of them much smaller."""
        sizes = radius * 10 ** self._rng.uniform(-4.0, -0.5, (count, 1))
        return self._unweighted(sizes * self._normal(count) / np.sqrt(len(self._scale)))

    def _normal(self, count: int) -> Array:
        moves = self._rng.normal(size=(count, len(self._scale)))
        moves[:, self._is_idle] = 0.0
        return moves

    def _unweighted(self, moves: Array) -> Array:
        """Return displacements [rad, m]; weight-0 coordinates are uniform in every other row."""
        moves = moves * self._scale
        anywhere = self._rng.uniform(-1.0, 1.0, moves[::2].shape) * self._reach
        moves[::2] = np.where(self._is_idle, anywhere, moves[::2])
        return moves
