"""NearestPoseSearch: feasible tool pose nearest to an unreachable goal, in the pose metric."""

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.geometry.pose import Pose
from planning.domain.goals.goal_configurations import ActiveConstraints, NearestPose
from planning.domain.request.deadline import Deadline
from planning.goals.diagnosis.active_constraints_pose import (
    active_constraints_at,
    blocking_constraints,
)
from planning.goals.diagnosis.nearest_program import (
    Target,
    displaced_target_pose,
    minimize_cost,
    pose_distance_cost,
)
from planning.goals.diagnosis.pose_perturbations import PosePerturbations
from planning.goals.goal_query import GoalQuery
from planning.goals.ik.pose_attempts import PoseAttempts
from planning.goals.targets.tool_target import ToolTarget
from planning.world.world import World

# Initial random configurations, and how many of the best start a gradient descent.
_NUM_RANDOM = 64
_NUM_DESCENTS = 3
# Largest number of target poses that are searched, the nearest ones.
_MAX_TARGETS = 4
# Random poses per round of improvement, nearer than the best so far, and rounds at most.
_POSES_PER_ROUND = 320
_MAX_ROUNDS = 8
# Rounds at most where lines or path constraints matter, which gradients see little of; and rounds
# without improvement after which the search ends.
_MAX_CONSTRAINED_ROUNDS, _PATIENCE = 30, 3
# First search radius around a goal, its growth factor after each round without result, and the
# largest one [m, in the pose metric].
_INITIAL_RADIUS, _RADIUS_GROWTH, _MAX_RADIUS = 1e-3, 3.0, 3.0
# Share of the time that the search for the nearest pose may take.
_SEARCH_TIME_FRACTION = 0.7
# Largest ratio of the new to the old distance that counts as an improvement.
_IMPROVEMENT_RATIO = 0.999
# Largest ratio of the distances without and with obstacles at which obstacles are active; the
# search is no more accurate.
_ACTIVE_OBSTACLE_RATIO = 0.99


@dataclass(frozen=True)
class _NearestResult:
    """Feasible configuration, its tool pose X_WT and its distance `cost` to target `index`."""

    cost: float
    q: Array
    pose: Pose
    index: int


class NearestPoseSearch:
    """Search by random samples, gradient descent, and random poses nearer than the best, repeated.

    With path constraints, or an approach or retreat, which gradients see little of, the search also
    samples poses around the goal at growing distance, and around the best configuration.

    Every result is within limits and free, satisfies the path constraints, and has the goal's
    approach and retreat. Not promised: that it is the nearest one.
    """

    def __init__(
        self,
        world: World,
        query: GoalQuery,
        targets: list[ToolTarget] | list[Any],
        rng: np.random.Generator,
        deadline: Deadline,
    ) -> None:
        """Prepare a search.

        Args:
            world: Loaded scene, with the joint limits under the query's path constraints.
            query: Goal query.
            targets: Targets of the goal, in world.
            rng: Random generator of the attempts.
            deadline: Time limit; a share of it is kept to determine the active constraints.
        """
        self._world = world
        self._query = query
        self._targets: list[Target] = list(targets)
        self._rng = rng
        self._full_deadline, self._deadline = deadline, deadline.at_fraction(_SEARCH_TIME_FRACTION)
        self._attempts = PoseAttempts(world, query, self._targets, rng, self._deadline)
        self._perturbations = PosePerturbations(world, query.group, self._targets[0].frame, rng)
        self._best: _NearestResult | None = None

    def run(self, hints: Float64[np.ndarray, "n nq"]) -> NearestPose | None:
        """Return the nearest pose; None if no feasible configuration was found.

        Args:
            hints: Infeasible configurations that reach the goal, or nearly.
        """
        self._attempts.hints = self._rng.permutation(hints)
        rows = np.concatenate([hints, self._attempts.next_seeds(_NUM_RANDOM)])
        descent_starts = self._initialize(rows, len(hints))
        for i, q in descent_starts:
            if self._deadline.is_over:
                break
            self._update_best(self._descend(self._targets[i], q)[None], [i])
        if self._is_constrained:
            self._find_first(sorted({i for i, _ in descent_starts}) or [0])
        num_failed_rounds, patience = 0, _PATIENCE if self._is_constrained else 1
        for _ in range(_MAX_CONSTRAINED_ROUNDS if self._is_constrained else _MAX_ROUNDS):
            if self._best is None or self._deadline.is_over or num_failed_rounds >= patience:
                break
            num_failed_rounds = 0 if self._improve(self._best) else num_failed_rounds + 1
        if self._best is None:
            return None
        return self._report(self._best, is_reached=len(hints) > 0)

    @property
    def is_out_of_time(self) -> bool:
        """Whether the time of the search is used up."""
        return self._deadline.is_over

    @property
    def _is_constrained(self) -> bool:
        """Whether lines or path constraints matter, besides limits and collisions."""
        return self._attempts.approach_check is not None or self._query.constraints is not None

    def _initialize(self, rows: Array, num_hints: int) -> list[tuple[int, Array]]:
        """Store the best feasible row, and return (target index, q) to start descents from."""
        poses = self._tool_poses(rows)
        targets = self._nearest_targets(poses)
        costs = np.stack([self._costs(poses, i) for i in targets], axis=1)
        is_feasible = self._attempts.are_feasible(rows)
        nearest = costs.argmin(axis=1)
        costs = costs.min(axis=1)
        order = np.argsort(costs, kind="stable")
        feasible = order[is_feasible[order]]
        with_approach = self._attempts.with_free_approach(
            rows[feasible], np.array(targets)[nearest[feasible]]
        )
        for k in feasible[with_approach][:1]:
            index = targets[int(nearest[k])]
            self._best = _NearestResult(float(costs[k]), rows[k], Pose.from_matrix(poses[k]), index)
        best_hints = [k for k in order if k < num_hints][:_NUM_DESCENTS]
        best_random = [k for k in order if k >= num_hints][:_NUM_DESCENTS]
        best_feasible = list(feasible[:_NUM_DESCENTS])
        selected = dict.fromkeys(int(k) for k in [*best_hints, *best_random, *best_feasible])
        return [(targets[int(nearest[k])], rows[k]) for k in selected]

    def _nearest_targets(self, poses: Array) -> list[int]:
        """Return the indices of up to `_MAX_TARGETS` targets, those nearest to the poses."""
        if len(self._targets) <= _MAX_TARGETS:
            return list(range(len(self._targets)))
        positions = poses[:, :3, 3]
        distances = [
            float(np.linalg.norm(positions - target.pose.position, axis=1).min())
            for target in self._targets
        ]
        return [int(i) for i in np.argsort(distances, kind="stable")[:_MAX_TARGETS]]

    def _find_first(self, indices: list[int]) -> None:
        """Sample poses around some targets at growing distance until one is feasible."""
        radius = _INITIAL_RADIUS
        while radius < min(_MAX_RADIUS, self._best_cost) and not self._deadline.is_over:
            for i in indices:
                base = self._targets[i].closest(self._targets[i].pose)
                rows = self._attempts.solve_displaced(base, radius * self._displacements(), None, i)
                self._update_best(rows, [i] * len(rows))
            radius *= _RADIUS_GROWTH

    @property
    def _best_cost(self) -> float:
        return np.inf if self._best is None else self._best.cost

    def _improve(self, best: _NearestResult) -> bool:
        """Sample random poses nearer than the best; return whether one improves on it."""
        target = self._targets[best.index]
        closest = target.closest(best.pose)
        rows = self._attempts.solve_displaced(
            closest, best.cost * self._displacements(), best.q, best.index
        )
        self._update_best(rows, [best.index] * len(rows))
        if self._is_constrained and self._best is not None:
            rows = self._perturbations.sample(self._best.q, closest)
            self._update_best(rows, [best.index] * len(rows))
        if self._best is None or self._best.cost >= _IMPROVEMENT_RATIO * best.cost:
            return False
        if self._attempts.approach_check is None:
            self._update_best(self._descend(target, self._best.q)[None], [best.index])
        return True

    def _displacements(self) -> Array:
        """Return displacements of cost at most 1: along axes, translations, and general ones.

        Those along axes, to which faces of obstacles are often orthogonal, are denser near length
        1. The shape is (n, 6): translation [m], rotation vector [rad].
        """
        third = _POSES_PER_ROUND // 3
        numbers = np.arange(third)
        axis_aligned = np.zeros((third, 6))
        axis_aligned[numbers, numbers % 6 // 2] = np.where(numbers % 2, 1, -1)
        axis_aligned *= 1 - ((numbers[:, None] // 6 + 0.5) / (third // 6 + 1)) ** 2
        general = self._rng.normal(size=(_POSES_PER_ROUND - third, 6))
        general[:third, 3:] = 0.0
        general /= np.linalg.norm(general, axis=1, keepdims=True)
        general *= self._rng.uniform(size=(len(general), 1)) ** (1 / 6)
        metric = self._query.options.pose_metric
        weights = np.repeat([metric.translation, metric.rotation], 3)
        return np.asarray(self._rng.permutation(np.concatenate([axis_aligned, general]))) / weights

    def _update_best(self, rows: Array, indices: list[int]) -> None:
        """Update the best configuration by the nearest feasible row, if that is nearer."""
        feasible = np.flatnonzero(self._attempts.are_feasible(rows))
        poses = self._tool_poses(rows[feasible])
        target_indices = np.array(indices, dtype=np.int64)[feasible]
        costs = np.zeros(len(target_indices))
        for i in set(target_indices.tolist()):
            costs[target_indices == i] = self._costs(poses[target_indices == i], i)
        nearer_indices = np.flatnonzero(costs < self._best_cost)
        order = nearer_indices[np.argsort(costs[nearer_indices], kind="stable")]
        with_approach = self._attempts.with_free_approach(
            rows[feasible[order]], target_indices[order]
        )
        for k in order[with_approach][:1]:
            q, pose = np.array(rows[feasible[k]]), Pose.from_matrix(poses[k])
            self._best = _NearestResult(float(costs[k]), q, pose, int(target_indices[k]))

    def _descend(self, target: Target, q: Array, *, is_collision_constrained: bool = True) -> Array:
        add_cost = pose_distance_cost(self._world, self._query, target)
        return minimize_cost(
            self._world,
            self._query,
            add_cost,
            q,
            is_collision_constrained=is_collision_constrained,
            deadline=self._full_deadline,
        )

    def _tool_poses(self, rows: Array) -> Array:
        """Return the tool pose X_WT at each row, shape (n, 4, 4)."""
        full = self._world.embed(self._query.group, rows)
        return self._world.frame_poses(self._targets[0].frame, full)

    def _costs(self, poses: Array, index: int) -> Array:
        metric = self._query.options.pose_metric
        shift, turn = self._targets[index].pose_errors(poses)
        return np.hypot(metric.translation * shift, metric.rotation * turn)

    def _report(self, best: _NearestResult, *, is_reached: bool) -> NearestPose:
        """Return the best pose with its errors, and its active constraints if time was left."""
        closest = self._targets[best.index].closest(best.pose)
        active_constraints = (
            None if self.is_out_of_time else self._active_constraints(best, is_reached=is_reached)
        )
        if self._full_deadline.is_over:
            active_constraints = None
        return NearestPose(
            best.pose,
            best.q,
            *best.pose.distance(closest),
            best.index,
            displaced_target_pose(self._targets[best.index], best.pose),
            active_constraints,
        )

    def _active_constraints(self, best: _NearestResult, *, is_reached: bool) -> ActiveConstraints:
        if self._is_constrained:
            target = self._targets[best.index]
            return blocking_constraints(
                self._world, self._query, target, best.q, self._full_deadline
            )
        is_blocked_by_collision = partial(
            self._is_blocked_by_collision, best, is_reached=is_reached
        )
        return active_constraints_at(self._world, self._query, best.q, is_blocked_by_collision)

    def _is_blocked_by_collision(self, best: _NearestResult, *, is_reached: bool) -> bool:
        """Return whether collision constraints keep the best from being nearer to its target.

        True without a test if colliding configurations reach the goal.
        """
        if is_reached:
            return True
        target = self._targets[best.index]
        q = self._descend(target, best.q, is_collision_constrained=False)
        return bool(
            self._costs(self._tool_poses(q[None]), best.index)[0]
            < _ACTIVE_OBSTACLE_RATIO * best.cost
        )
