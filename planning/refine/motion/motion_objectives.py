"""MotionObjectives: the objectives of a timed motion, and of the same motion at other durations.

A motion that takes k times as long has q(t / k): of its rates the d-th is k^-d as large, and its
torques are tau_m / k^2 + tau_d / k + tau_g, of inertia, damping and gravity.
"""

from dataclasses import dataclass

import numpy as np

from planning.domain.arrays import Array
from planning.domain.curves.curve import TimedTrajectory, derivative
from planning.domain.report.objective_values import ObjectiveValues
from planning.domain.request.refine_objective import QUICKEST, RefineObjective
from planning.domain.robot.joints import JointGroup
from planning.domain.robot.manifold import Manifold
from planning.domain.robot.payload import Payload
from planning.domain.robot.steering import steering_of
from planning.world.mechanics.dynamics import GroupDynamics
from planning.world.world import World

# Nodes per piece for integrals of squared rates: exact up to degree 7 of the rate.
_NODES = 8
# Instants at which torques are evaluated, at least; and in every piece.
_MIN_TORQUE_NODES, _TORQUE_NODES = 160, 2
# Step of difference quotients of accelerations, as a share of a piece.
_DIFFERENCE_STEP = 1e-3
# Jump of accelerations that counts as none, as a share of the largest one.
_JUMP_TOLERANCE = 1e-6
# Factors of the duration that are compared, from coarse to fine.
_SLOWDOWNS = np.geomspace(1.0, 100.0, 400)
_FINE_STEPS = 41


@dataclass(frozen=True)
class MotionObjectives:
    """Objectives of one motion.

    Attributes:
        objective: Weights, and which derivative counts as smoothness.
        duration: [s].
        smoothness: Integral of the squared rate; None where it is infinite.
        path_length: Joint-space length [rad or m].
        torque_products: Integrals over time of tau_i . tau_j for the parts of inertia, damping and
            gravity, shape (3, 3); None if unknown.
    """

    objective: RefineObjective
    duration: float
    smoothness: float | None
    path_length: float
    torque_products: Array | None

    @classmethod
    def of(
        cls,
        world: World,
        group: JointGroup,
        trajectory: TimedTrajectory,
        objective: RefineObjective | None,
        payload: Payload | None,
    ) -> "MotionObjectives":
        """Measure a motion.

        Args:
            world: The scene, loaded.
            group: The group that moves.
            trajectory: The motion.
            objective: The request's; None for the duration.
            payload: Mass that the group carries and the scene does not contain.
        """
        stated = objective or QUICKEST
        speeds = np.sqrt(_squared_rates(trajectory, 1))
        return cls(
            stated,
            trajectory.duration,
            _smoothness(trajectory, stated.derivative_order),
            float((_node_widths(trajectory) * speeds).sum()),
            _torque_products(world, group, trajectory, payload),
        )

    def values(self, slowdown: float = 1.0) -> ObjectiveValues:
        """Return the values for the motion that takes `slowdown` times as long."""
        smoothness, energy = self.smoothness, None
        if smoothness is not None:
            smoothness *= slowdown ** (1 - 2 * self.objective.derivative_order)
        if self.torque_products is not None:
            parts = np.array([slowdown**-2, 1 / slowdown, 1.0])
            energy = float(slowdown * parts @ self.torque_products @ parts)
        return ObjectiveValues(self.duration * slowdown, smoothness, energy, self.path_length)

    def cost(self, slowdown: float = 1.0) -> float:
        """Return the weighted sum for the motion that takes `slowdown` times as long."""
        return self.values(slowdown).cost(self.objective)

    @property
    def best_slowdown(self) -> float:
        """The factor of the duration, at least 1, at which the motion costs the least."""
        longest = (self.objective.max_duration or np.inf) / self.duration
        if not self.objective.is_gentle or longest <= 1 or not np.isfinite(self.cost()):
            return 1.0
        factors = [*_SLOWDOWNS[longest > _SLOWDOWNS], min(longest, float(_SLOWDOWNS[-1]))]
        best = min(range(len(factors)), key=lambda i: self.cost(float(factors[i])))
        low, high = factors[max(best - 1, 0)], factors[min(best + 1, len(factors) - 1)]
        return min(np.linspace(low, high, _FINE_STEPS).tolist(), key=self.cost)


def _smoothness(trajectory: TimedTrajectory, order: int) -> float | None:
    """Return the integral of the squared rate of an order; None for jerks where rates jump."""
    if order > 2 and not _is_acceleration_continuous(trajectory):
        return None
    return float((_node_widths(trajectory) * _squared_rates(trajectory, order)).sum())


def _is_acceleration_continuous(trajectory: TimedTrajectory) -> bool:
    """Return whether accelerations have no jumps, from rest to rest."""
    edges = trajectory.widths[:, None] * np.array([0.0, 1.0])
    begins, ends = np.moveaxis(_rates(trajectory, edges, 2), 1, 0)
    jumps = [begins[0], ends[-1], *(b - a for a, b in zip(ends[:-1], begins[1:], strict=True))]
    return float(np.abs(jumps).max()) <= _JUMP_TOLERANCE * max(float(np.abs(begins).max()), 1e-12)


def _nodes(count: int = _NODES) -> tuple[Array, Array]:
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return (nodes + 1) / 2, weights / 2


def _node_widths(trajectory: TimedTrajectory) -> Array:
    """Return the weights of all nodes in an integral over time, shape (pieces, nodes)."""
    return trajectory.widths[:, None] * _nodes()[1]


def _squared_rates(trajectory: TimedTrajectory, order: int) -> Array:
    """Return the squared norm of the rate of an order at all nodes, shape (pieces, nodes)."""
    rates = _rates(trajectory, trajectory.widths[:, None] * _nodes()[0], order)
    return (rates**2).sum(axis=2)


def _rates(trajectory: TimedTrajectory, local: Array, order: int) -> Array:
    """Return velocities, accelerations or jerks in each piece, shape (pieces, m, nv).

    Those of floating bodies are of Drake's velocities: the derivatives of a piece's own coordinates
    are others away from its base.

    Args:
        trajectory: The motion.
        local: Times after the begin of each piece [s], shape (pieces, m).
        order: 1, 2 or 3.
    """
    if trajectory.manifold.is_flat:
        return _tangents(trajectory, local, order)
    if order > 2:
        step = _DIFFERENCE_STEP * trajectory.widths[:, None]
        ends = (_rates(trajectory, local + sign * step, 2) for sign in (1.0, -1.0))
        return (next(ends) - next(ends)) / (2 * step[:, :, None])
    delta, *rates = (_tangents(trajectory, local, k) for k in range(order + 1))
    q = trajectory.manifold.plus(trajectory.bases[:, None], delta)
    if order == 1:
        return trajectory.manifold.generalized_velocity(q, delta, rates[0])
    return trajectory.manifold.generalized_acceleration(q, delta, rates[0], rates[1])


def _tangents(trajectory: TimedTrajectory, local: Array, order: int) -> Array:
    """Return the derivative of an order of each piece's coordinates, shape (pieces, m, nv)."""
    rates = derivative(trajectory.coefficients, order)
    powers = local[:, :, None] ** np.arange(rates.shape[1])
    return np.einsum("nmk,nkj->nmj", powers, rates)


def _torque_products(
    world: World, group: JointGroup, trajectory: TimedTrajectory, payload: Payload | None
) -> Array | None:
    """Return the integrals of products of the parts of the torques.

    They jump with the accelerations, from piece to piece, so each piece is integrated by itself.
    """
    if not Manifold(group.joints).is_flat or steering_of(group):
        return None
    nodes, node_weights = _nodes(max(_TORQUE_NODES, -(-_MIN_TORQUE_NODES // trajectory.num_pieces)))
    times = (trajectory.breaks[:-1, None] + trajectory.widths[:, None] * nodes).ravel()
    q, v = trajectory.positions(times), trajectory.velocities(times)
    dynamics = GroupDynamics(world, group, payload)
    damping = dynamics.damping * v
    gravity = dynamics.efforts(q, np.zeros_like(v), np.zeros_like(v))
    inertia = dynamics.efforts(q, v, trajectory.accelerations(times)) - damping - gravity
    parts = np.stack([inertia, damping, gravity])
    weights = (trajectory.widths[:, None] * node_weights).ravel()
    return np.einsum("amj,bmj,m->ab", parts, parts, weights)
