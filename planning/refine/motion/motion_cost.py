"""MotionCost: the objective of a spline motion by its control points and duration, with gradient.

With R_d = r^(d) at the nodes of a quadrature over s, and w their weights,

    smoothness = T^(1 - 2d) sum w |R_d|^2,    path_length = sum w |R_1|,
    energy = T sum w |tau(R_0, R_1 / T, R_2 / T^2)|^2.
"""

from dataclasses import dataclass

import numpy as np

from planning.domain.arrays import Array
from planning.domain.request.refine_objective import RefineObjective
from planning.refine.constraints.load import difference_quotients
from planning.refine.motion.spline_matrices import SplineMatrices, quadrature
from planning.world.mechanics.dynamics import GroupDynamics

# Nodes per span: exact for squares of derivatives; torques change little within a span.
_NODES, _ENERGY_NODES = 4, 2
# Speed below which the length's gradient fades [rad or m], per unit of s.
_LEAST_SPEED = 1e-6
# Cost that stands for none where others are divided by it.
LEAST_COST = 1e-100


@dataclass(frozen=True)
class MotionCost:
    """Weighted sum of the objectives.

    Attributes:
        objective: The weights.
        dynamics: Inverse dynamics; None if energy has no weight.
        num_control_points: Of every motion.
    """

    objective: RefineObjective
    dynamics: GroupDynamics | None
    num_control_points: int

    @property
    def rate_order(self) -> int:
        """Order of the derivative by which the cost is best conditioned."""
        if self.objective.smoothness:
            return self.objective.derivative_order
        return 2 if self.objective.energy else 1

    def value(self, points: Array, duration: float) -> float:
        """Return the cost of a motion."""
        objective = self.objective
        at = quadrature(self.num_control_points, _NODES)
        total = objective.time_weight * duration
        if objective.smoothness:
            total += objective.smoothness * self._smoothness(at, points, duration)[0]
        if objective.path_length:
            total += objective.path_length * float(at.weights @ _speeds(at, points)[1])
        if objective.energy:
            nodes = quadrature(self.num_control_points, _ENERGY_NODES)
            squares = (self.efforts(*nodes.states(points, duration)) ** 2).sum(axis=1)
            total += objective.energy * duration * float(nodes.weights @ squares)
        return total

    def gradient(self, points: Array, duration: float) -> tuple[float, Array, float]:
        """Return the cost, and its gradients by control points, shape (k, nq), and duration."""
        objective = self.objective
        at = quadrature(self.num_control_points, _NODES)
        total, by_time = objective.time_weight * duration, objective.time_weight
        by_points = np.zeros_like(points)
        if objective.smoothness:
            value, slopes, rate = self._smoothness(at, points, duration)
            total += objective.smoothness * value
            by_points += objective.smoothness * slopes
            by_time += objective.smoothness * rate
        if objective.path_length:
            directions, speeds = _speeds(at, points)
            total += objective.path_length * float(at.weights @ speeds)
            slopes = at.weights[:, None] * directions / speeds[:, None]
            by_points += objective.path_length * (at.by_order[1].T @ slopes)
        if objective.energy:
            value, slopes, rate = self._energy(points, duration)
            total += objective.energy * value
            by_points += objective.energy * slopes
            by_time += objective.energy * rate
        return total, by_points, by_time

    def _smoothness(
        self, at: SplineMatrices, points: Array, duration: float
    ) -> tuple[float, Array, float]:
        order = self.objective.derivative_order
        power = 1 - 2 * order
        rates = at.by_order[order] @ points
        weighted = at.weights[:, None] * rates
        value = float((weighted * rates).sum()) * duration**power
        slopes = 2 * (at.by_order[order].T @ weighted) * duration**power
        return value, slopes, power * value / duration

    def _energy(self, points: Array, duration: float) -> tuple[float, Array, float]:
        at = quadrature(self.num_control_points, _ENERGY_NODES)
        q, v, vdot = at.states(points, duration)
        efforts = self.efforts(q, v, vdot)
        jacobians = difference_quotients(self.efforts, q, v, vdot)
        value = duration * float(at.weights @ (efforts**2).sum(axis=1))
        # d(cost)/d(tau), then through tau to q, v and vdot, shape (3, m, nq).
        slopes = 2 * duration * at.weights[:, None] * efforts
        by_state = np.einsum("mj,amjk->amk", slopes, jacobians)
        by_points = (
            at.by_order[0].T @ by_state[0]
            + at.by_order[1].T @ by_state[1] / duration
            + at.by_order[2].T @ by_state[2] / duration**2
        )
        slowing = float((by_state[1] * v).sum() + 2 * (by_state[2] * vdot).sum())
        return value, by_points, (value - slowing) / duration

    def efforts(self, q: Array, v: Array, vdot: Array) -> Array:
        """Return the torques and forces of a motion at instants, shape (m, nq)."""
        if self.dynamics is None:
            return np.zeros_like(v)
        return self.dynamics.efforts(q, v, vdot)


def _speeds(at: SplineMatrices, points: Array) -> tuple[Array, Array]:
    """Return r' and its length at the nodes, smooth at rest."""
    first = at.by_order[1] @ points
    return first, np.sqrt((first**2).sum(axis=1) + _LEAST_SPEED**2)
