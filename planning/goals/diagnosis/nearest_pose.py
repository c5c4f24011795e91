"""NearestSearch: feasible tool pose nearest to an unreachable goal pose, in the pose metric."""

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.geometry.pose import Pose
from planning.domain.goals.goal_configurations import Bounds, NearestPose
from planning.domain.request.deadline import Deadline
from planning.goals.diagnosis.active_constraints_pose import barrier, bounds_at
from planning.goals.diagnosis.nearest_program import Target, moved_along, pulled, to_pose
from planning.goals.diagnosis.pose_perturbations import PosePerturbations
from planning.goals.goal_query import GoalQuery
from planning.goals.ik.pose_attempts import PoseAttempts
from planning.goals.targets.tool_target import ToolTarget
from planning.world.world import World

# Initial random configurations, and how many of the best start a gradient descent.
_NUM_RANDOM = 64
_NUM_PULLED = 3
# Largest number of target poses that are searched, the nearest ones.
_MAX_TARGETS = 4
# Random poses per round of improvement, nearer than the best so far, and rounds at most.
_NUM_TRIES = 320
_MAX_ROUNDS = 8
# Rounds at most where lines or path constraints matter, which gradients see little of; and rounds
# without improvement after which the search ends.
_MAX_CLOSE_ROUNDS, _PATIENCE = 30, 3
# First search radius around a goal, its growth factor after each round without result, and the
# largest one [m, in the pose metric].
_FIRST, _FARTHER, _FAR = 1e-3, 3.0, 3.0
# Share of the time that the search for the nearest pose may take.
_SHARE = 0.7
# Largest ratio of the new to the old distance that counts as an improvement.
_NEWS = 0.999
# Largest ratio of the distances without and with obstacles at which obstacles are active; the
# search is no more accurate.
_OWED = 0.99


@dataclass(frozen=True)
class _Found:
    """Feasible configuration, its tool pose X_WT and its distance `cost` to target `index`."""

    cost: float
    q: Array
    pose: Pose
    index: int


class NearestSearch:
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
        self._whole, self._deadline = deadline, deadline.share(_SHARE)
        self._tries = PoseAttempts(world, query, self._targets, rng, self._deadline)
        self._nearby = PosePerturbations(world, query.group, self._targets[0].frame, rng)
        self._best: _Found | None = None

    def run(self, hints: Float64[np.ndarray, "n nq"]) -> NearestPose | None:
        """Return the nearest pose; None if no feasible configuration was found.

        Args:
            hints: Infeasible configurations that reach the goal, or nearly.
        """
        self._tries.hints = self._rng.permutation(hints)
        rows = np.concatenate([hints, self._tries.random(_NUM_RANDOM)])
        begun = self._begin(rows, len(hints))
        for i, q in begun:
            if self._deadline.is_over:
                break
            self._consider(self._pulled(self._targets[i], q)[None], [i])
        if self._is_close_work:
            self._look_around(sorted({i for i, _ in begun}) or [0])
        missed, patience = 0, _PATIENCE if self._is_close_work else 1
        for _ in range(_MAX_CLOSE_ROUNDS if self._is_close_work else _MAX_ROUNDS):
            if self._best is None or self._deadline.is_over or missed >= patience:
                break
            missed = 0 if self._nearer(self._best) else missed + 1
        if self._best is None:
            return None
        return self._report(self._best, is_reached=len(hints) > 0)

    @property
    def is_late(self) -> bool:
        """Whether the time of the search is used up."""
        return self._deadline.is_over

    @property
    def _is_close_work(self) -> bool:
        """Whether lines or path constraints matter, besides limits and collisions."""
        return self._tries.lines is not None or self._query.rules is not None

    def _begin(self, rows: Array, num_hints: int) -> list[tuple[int, Array]]:
        """Store the best feasible row, and return (target index, q) to start descents from."""
        reached = self._poses_of(rows)
        targets = self._promising(reached)
        costs = np.stack([self._costs(reached, i) for i in targets], axis=1)
        free = self._tries.are_feasible(rows)
        nearest = costs.argmin(axis=1)
        costs = costs.min(axis=1)
        order = np.argsort(costs, kind="stable")
        ordered = order[free[order]]
        for k in ordered[self._tries.lined(rows[ordered], np.array(targets)[nearest[ordered]])][:1]:
            index = targets[int(nearest[k])]
            self._best = _Found(float(costs[k]), rows[k], Pose.from_matrix(reached[k]), index)
        first = [k for k in order if k < num_hints][:_NUM_PULLED]
        then = [k for k in order if k >= num_hints][:_NUM_PULLED]
        freest = list(order[free[order]][:_NUM_PULLED])
        chosen = dict.fromkeys(int(k) for k in [*first, *then, *freest])
        return [(targets[int(nearest[k])], rows[k]) for k in chosen]

    def _promising(self, reached: Array) -> list[int]:
        """Return the indices of up to `_MAX_TARGETS` targets, those nearest to the poses."""
        if len(self._targets) <= _MAX_TARGETS:
            return list(range(len(self._targets)))
        places = reached[:, :3, 3]
        gaps = [
            float(np.linalg.norm(places - target.pose.position, axis=1).min())
            for target in self._targets
        ]
        return [int(i) for i in np.argsort(gaps, kind="stable")[:_MAX_TARGETS]]

    def _look_around(self, indices: list[int]) -> None:
        """Sample poses around some targets at growing distance until one is feasible."""
        radius = _FIRST
        while radius < min(_FAR, self._cost_so_far) and not self._deadline.is_over:
            for i in indices:
                base = self._targets[i].closest(self._targets[i].pose)
                rows = self._tries.reach(base, radius * self._moves(), None, i)
                self._consider(rows, [i] * len(rows))
            radius *= _FARTHER

    @property
    def _cost_so_far(self) -> float:
        return np.inf if self._best is None else self._best.cost

    def _nearer(self, best: _Found) -> bool:
        """Sample random poses nearer than the best; return whether one improves on it."""
        target = self._targets[best.index]
        closest = target.closest(best.pose)
        rows = self._tries.reach(closest, best.cost * self._moves(), best.q, best.index)
        self._consider(rows, [best.index] * len(rows))
        if self._is_close_work and self._best is not None:
            rows = self._nearby.drawn(self._best.q, closest)
            self._consider(rows, [best.index] * len(rows))
        if self._best is None or self._best.cost >= _NEWS * best.cost:
            return False
        if self._tries.lines is None:
            self._consider(self._pulled(target, self._best.q)[None], [best.index])
        return True

    def _moves(self) -> Array:
        """Return displacements of cost at most 1: along axes, translations, and general ones.

        Those along axes, to which faces of obstacles are often orthogonal, are denser near length
        1. The shape is (n, 6): translation [m], rotation vector [rad].
        """
        third = _NUM_TRIES // 3
        numbers = np.arange(third)
        along = np.zeros((third, 6))
        along[numbers, numbers % 6 // 2] = np.where(numbers % 2, 1, -1)
        along *= 1 - ((numbers[:, None] // 6 + 0.5) / (third // 6 + 1)) ** 2
        aside = self._rng.normal(size=(_NUM_TRIES - third, 6))
        aside[:third, 3:] = 0.0
        aside /= np.linalg.norm(aside, axis=1, keepdims=True)
        aside *= self._rng.uniform(size=(len(aside), 1)) ** (1 / 6)
        metric = self._query.options.pose_metric
        weights = np.repeat([metric.translation, metric.rotation], 3)
        return np.asarray(self._rng.permutation(np.concatenate([along, aside]))) / weights

    def _consider(self, rows: Array, indices: list[int]) -> None:
        """Update the best configuration by the nearest feasible row, if that is nearer."""
        feasible = np.flatnonzero(self._tries.are_feasible(rows))
        reached, kept = self._poses_of(rows[feasible]), np.array(indices, dtype=np.int64)[feasible]
        costs = np.zeros(len(kept))
        for i in set(kept.tolist()):
            costs[kept == i] = self._costs(reached[kept == i], i)
        nearer = np.flatnonzero(costs < self._cost_so_far)
        order = nearer[np.argsort(costs[nearer], kind="stable")]
        for k in order[self._tries.lined(rows[feasible[order]], kept[order])][:1]:
            q, pose = np.array(rows[feasible[k]]), Pose.from_matrix(reached[k])
            self._best = _Found(float(costs[k]), q, pose, int(kept[k]))

    def _pulled(self, target: Target, q: Array, *, is_apart: bool = True) -> Array:
        pull = to_pose(self._world, self._query, target)
        return pulled(self._world, self._query, pull, q, is_apart=is_apart, deadline=self._whole)

    def _poses_of(self, rows: Array) -> Array:
        """Return the tool pose X_WT at each row, shape (n, 4, 4)."""
        full = self._world.embed(self._query.group, rows)
        return self._world.frame_poses(self._targets[0].frame, full)

    def _costs(self, reached: Array, index: int) -> Array:
        metric = self._query.options.pose_metric
        shift, turn = self._targets[index].misses(reached)
        return np.hypot(metric.translation * shift, metric.rotation * turn)

    def _report(self, best: _Found, *, is_reached: bool) -> NearestPose:
        """Return the best pose with its errors, and its active constraints if time was left."""
        closest = self._targets[best.index].closest(best.pose)
        bounds = None if self.is_late else self._bounds(best, is_reached=is_reached)
        if self._whole.is_over:
            bounds = None
        return NearestPose(
            best.pose,
            best.q,
            *best.pose.distance(closest),
            best.index,
            moved_along(self._targets[best.index], best.pose),
            bounds,
        )

    def _bounds(self, best: _Found, *, is_reached: bool) -> Bounds:
        if self._is_close_work:
            target = self._targets[best.index]
            return barrier(self._world, self._query, target, best.q, self._whole)
        is_kept_off = partial(self._is_kept_off, best, is_reached=is_reached)
        return bounds_at(self._world, self._query, best.q, is_kept_off)

    def _is_kept_off(self, best: _Found, *, is_reached: bool) -> bool:
        """Return whether collision constraints keep the best from being nearer to its target.

        True without a test if colliding configurations reach the goal.
        """
        if is_reached:
            return True
        target = self._targets[best.index]
        q = self._pulled(target, best.q, is_apart=False)
        return bool(self._costs(self._poses_of(q[None]), best.index)[0] < _OWED * best.cost)
