"""NearestJointSearch: feasible configuration nearest to infeasible given ones, in joint space."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array, Indices
from planning.domain.request.deadline import Deadline
from planning.domain.robot.manifold import Manifold
from planning.goals.diagnosis.joint_cost import joint_distance_cost
from planning.goals.diagnosis.joint_perturbations import JointPerturbations
from planning.goals.diagnosis.nearest_program import minimize_cost
from planning.goals.feasibility import Feasibility
from planning.goals.goal_query import GoalQuery
from planning.goals.ik.seeds import Seeds
from planning.goals.joint_metric import JointMetric
from planning.world.world import World

# Configurations per batch.
_BATCH_SIZE = 2048
# First sampling radius [rad or m], and its growth factor after each round without result.
_INITIAL_RADIUS, _RADIUS_GROWTH = 1e-3, 1.6
# Rounds of improvement at most, and rounds without improvement after which the search ends.
_MAX_ROUNDS, _PATIENCE = 24, 4
# Largest number of gradient descents (nonlinear programs).
_MAX_DESCENTS = 5
# Largest ratio of the new to the old distance that counts as an improvement.
_IMPROVEMENT_RATIO = 0.999
# Samples of the geodesic to the best configuration, and number of refinements.
_NUM_GEODESIC_SAMPLES, _NUM_REFINEMENTS = 64, 3


@dataclass(frozen=True)
class NearestJoints:
    """Feasible configuration and its distance to the nearest given one.

    Attributes:
        cost: Distance in the joint metric [rad or m].
        q: Configuration, shape (nq,).
        index: Index of the nearest given configuration.
    """

    cost: float
    q: Float64[np.ndarray, " nq"]
    index: int


class NearestJointSearch:
    """Search by random samples at growing distance, gradient descent, then local random samples.

    Every result is feasible. Not promised: that it is the nearest one.
    """

    def __init__(
        self,
        world: World,
        query: GoalQuery,
        goals: Float64[np.ndarray, "n nq"],
        rng: np.random.Generator,
        deadline: Deadline,
    ) -> None:
        """Prepare a search around `goals`.

        Args:
            world: Loaded scene, with the joint limits under the query's path constraints.
            query: Goal query.
            goals: Given configurations.
            rng: Random generator of the samples.
            deadline: Time limit of the search.
        """
        self._world, self._query, self._deadline = world, query, deadline
        self._goals = goals
        self._limits = world.limits(query.group)
        self._metric = JointMetric.from_names(query.group, query.options.joint_weights)
        self._manifold = Manifold(query.group.joints)
        self._perturbations = JointPerturbations(query.group, self._metric, rng)
        self._seeds = Seeds(query.group, self._limits, query.start, rng)
        self._feasibility = Feasibility(world, query)
        self._clipped_goals = self._clip_to_limits(goals)
        self._best: NearestJoints | None = None
        self._num_descents = 0

    def run(self) -> NearestJoints | None:
        """Return the nearest feasible configuration found; None if none was."""
        self._update_best(self._clipped_goals)
        self._find_first()
        num_failed_rounds = 0
        for _ in range(_MAX_ROUNDS):
            best = self._best
            if best is None or best.cost <= 0:
                break
            if num_failed_rounds >= _PATIENCE or self._deadline.is_over:
                break
            num_failed_rounds = 0 if self._improve(best) else num_failed_rounds + 1
        return self._best

    def _find_first(self) -> None:
        """Find a first feasible configuration, at growing distance, and improve it by descent."""
        radius, max_radius = _INITIAL_RADIUS, self._perturbations.max_radius
        while self._best is None and radius < max_radius and not self._deadline.is_over:
            self._update_best(self._sample_around(radius))
            radius *= _RADIUS_GROWTH
        if self._best is None:
            self._update_best(self._seeds.take(_BATCH_SIZE))
        if self._best is not None:
            self._refine_on_geodesic(self._best)
            order = np.argsort(self._costs(self._clipped_goals)[0], kind="stable")
            self._descend(self._clipped_goals[order[0]], int(order[0]))
            self._descend(self._best.q, self._best.index)

    def _improve(self, best: NearestJoints) -> bool:
        """Sample configurations nearer than the best; return whether one improves on it."""
        radius = np.sqrt(max(best.cost**2 - self._costs(self._clipped_goals)[0].min() ** 2, 0.0))
        self._update_best(self._sample_around(float(radius)))
        goal = self._goals[best.index]
        to_goal = self._manifold.minus(goal[None], best.q[None])
        fractions = 10 ** (-4 * np.linspace(0.0, 1.0, _BATCH_SIZE))[:, None]
        displacements = (
            self._perturbations.sample_multiscale(best.cost, _BATCH_SIZE) + fractions * to_goal
        )
        self._update_best(self._manifold.plus(best.q[None], displacements))
        if self._best is None or self._best.cost >= _IMPROVEMENT_RATIO * best.cost:
            return False
        self._refine_on_geodesic(self._best)
        self._descend(self._best.q, self._best.index)
        return True

    def _sample_around(self, radius: float) -> Array:
        """Return random configurations around the given ones, in turn."""
        displacements = self._perturbations.sample_ball(radius, _BATCH_SIZE)
        centers = self._clipped_goals[np.arange(_BATCH_SIZE) % len(self._clipped_goals)]
        return self._manifold.plus(centers, displacements)

    def _refine_on_geodesic(self, nearest: NearestJoints) -> None:
        """Find the first feasible point on the geodesic from a given configuration to `nearest`."""
        begin, end = self._clipped_goals[nearest.index], nearest.q
        for _ in range(_NUM_REFINEMENTS):
            fractions = np.linspace(0.0, 1.0, _NUM_GEODESIC_SAMPLES + 1)
            samples = self._manifold.interpolate(begin, end, fractions)
            first_feasible = self._feasibility.first_feasible(samples[:-1])
            first = len(samples) - 1 if first_feasible is None else first_feasible
            self._update_best(samples[first][None])
            begin, end = samples[max(first - 1, 0)], samples[first]

    def _descend(self, q: Array, index: int) -> None:
        """Minimize the distance to a given configuration from q, by nonlinear programming."""
        if self._num_descents >= _MAX_DESCENTS or (
            self._deadline.is_over and self._best is not None
        ):
            return
        self._num_descents += 1
        add_cost = joint_distance_cost(
            self._world, self._query.group, self._metric, self._goals[index]
        )
        self._update_best(minimize_cost(self._world, self._query, add_cost, q)[None])

    def _update_best(self, rows: Array) -> None:
        """Update the best configuration by the nearest feasible row, if that is nearer."""
        rows = self._clip_to_limits(rows)
        costs, index = self._costs(rows)
        nearer_indices = np.flatnonzero(costs < (np.inf if self._best is None else self._best.cost))
        order = nearer_indices[np.argsort(costs[nearer_indices], kind="stable")]
        first = self._feasibility.first_feasible(rows[order])
        if first is not None:
            k = order[first]
            self._best = NearestJoints(float(costs[k]), np.array(rows[k]), int(index[k]))

    def _costs(self, rows: Array) -> tuple[Array, Indices]:
        """Return each row's distance to the nearest given configuration, and the index of that."""
        costs = np.stack([self._metric.distance(rows, goal) for goal in self._goals])
        index = costs.argmin(axis=0)
        return costs[index, np.arange(len(rows))], index

    def _clip_to_limits(self, rows: Array) -> Array:
        unit = self._manifold.normalized(rows)
        return np.clip(unit, self._limits.lower, self._limits.upper)
