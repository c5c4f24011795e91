"""NearestJointSearch: feasible configuration nearest to infeasible given ones, in joint space."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array, Indices
from planning.domain.request.deadline import Deadline
from planning.domain.robot.manifold import Manifold
from planning.goals.diagnosis.joint_cost import to_configuration
from planning.goals.diagnosis.joint_perturbations import JointPerturbations
from planning.goals.diagnosis.nearest_program import pulled
from planning.goals.feasibility import Feasibility
from planning.goals.goal_query import GoalQuery
from planning.goals.ik.seeds import Seeds
from planning.goals.joint_metric import JointMetric
from planning.world.world import World

# Configurations per batch.
_NUM_TRIES = 2048
# First sampling radius [rad or m], and its growth factor after each round without result.
_FIRST, _FARTHER = 1e-3, 1.6
# Rounds of improvement at most, and rounds without improvement after which the search ends.
_MAX_ROUNDS, _PATIENCE = 24, 4
# Largest number of gradient descents (nonlinear programs).
_MAX_PULLS = 5
# Largest ratio of the new to the old distance that counts as an improvement.
_NEWS = 0.999
# Samples of the geodesic to the best configuration, and number of refinements.
_NUM_STEPS, _NUM_LOOKS = 64, 3


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
        self._moves = JointPerturbations(query.group, self._metric, rng)
        self._seeds = Seeds(query.group, self._limits, query.start, rng)
        self._feasibility = Feasibility(world, query)
        self._inside = self._clipped(goals)
        self._best: NearestJoints | None = None
        self._num_pulls = 0

    def run(self) -> NearestJoints | None:
        """Return the nearest feasible configuration found; None if none was."""
        self._consider(self._inside)
        self._look_around()
        missed = 0
        for _ in range(_MAX_ROUNDS):
            best = self._best
            if best is None or best.cost <= 0 or missed >= _PATIENCE or self._deadline.is_over:
                break
            missed = 0 if self._nearer(best) else missed + 1
        return self._best

    def _look_around(self) -> None:
        """Find a first feasible configuration, at growing distance, and improve it by descent."""
        radius, largest = _FIRST, self._moves.largest
        while self._best is None and radius < largest and not self._deadline.is_over:
            self._consider(self._around(radius))
            radius *= _FARTHER
        if self._best is None:
            self._consider(self._seeds.take(_NUM_TRIES))
        if self._best is not None:
            self._straighten(self._best)
            order = np.argsort(self._costs(self._inside)[0], kind="stable")
            self._pull(self._inside[order[0]], int(order[0]))
            self._pull(self._best.q, self._best.index)

    def _nearer(self, best: NearestJoints) -> bool:
        """Sample configurations nearer than the best; return whether one improves on it."""
        reach = np.sqrt(max(best.cost**2 - self._costs(self._inside)[0].min() ** 2, 0.0))
        self._consider(self._around(float(reach)))
        goal = self._goals[best.index]
        towards = self._manifold.minus(goal[None], best.q[None])
        share = 10 ** (-4 * np.linspace(0.0, 1.0, _NUM_TRIES))[:, None]
        moves = self._moves.about(best.cost, _NUM_TRIES) + share * towards
        self._consider(self._manifold.plus(best.q[None], moves))
        if self._best is None or self._best.cost >= _NEWS * best.cost:
            return False
        self._straighten(self._best)
        self._pull(self._best.q, self._best.index)
        return True

    def _around(self, radius: float) -> Array:
        """Return random configurations around the given ones, in turn."""
        moves = self._moves.within(radius, _NUM_TRIES)
        centres = self._inside[np.arange(_NUM_TRIES) % len(self._inside)]
        return self._manifold.plus(centres, moves)

    def _straighten(self, found: NearestJoints) -> None:
        """Find the first feasible point on the geodesic from a given configuration to `found`."""
        begin, end = self._inside[found.index], found.q
        for _ in range(_NUM_LOOKS):
            shares = np.linspace(0.0, 1.0, _NUM_STEPS + 1)
            along = self._manifold.interpolate(begin, end, shares)
            found_at = self._feasibility.first(along[:-1])
            first = len(along) - 1 if found_at is None else found_at
            self._consider(along[first][None])
            begin, end = along[max(first - 1, 0)], along[first]

    def _pull(self, q: Array, index: int) -> None:
        """Minimize the distance to a given configuration from q, by nonlinear programming."""
        if self._num_pulls >= _MAX_PULLS or (self._deadline.is_over and self._best is not None):
            return
        self._num_pulls += 1
        pull = to_configuration(self._world, self._query.group, self._metric, self._goals[index])
        self._consider(pulled(self._world, self._query, pull, q)[None])

    def _consider(self, rows: Array) -> None:
        """Update the best configuration by the nearest feasible row, if that is nearer."""
        rows = self._clipped(rows)
        costs, index = self._costs(rows)
        nearer = np.flatnonzero(costs < (np.inf if self._best is None else self._best.cost))
        order = nearer[np.argsort(costs[nearer], kind="stable")]
        first = self._feasibility.first(rows[order])
        if first is not None:
            k = order[first]
            self._best = NearestJoints(float(costs[k]), np.array(rows[k]), int(index[k]))

    def _costs(self, rows: Array) -> tuple[Array, Indices]:
        """Return each row's distance to the nearest given configuration, and the index of that."""
        costs = np.stack([self._metric.distance(rows, goal) for goal in self._goals])
        index = costs.argmin(axis=0)
        return costs[index, np.arange(len(rows))], index

    def _clipped(self, rows: Array) -> Array:
        unit = self._manifold.normalized(rows)
        return np.clip(unit, self._limits.lower, self._limits.upper)
