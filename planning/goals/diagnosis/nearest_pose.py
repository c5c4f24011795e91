"""The nearest free pose that a tool frame can take to one that it cannot."""

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from jaxtyping import Float64

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

type Array = np.ndarray[Any, np.dtype[np.float64]]

# Random configurations that are looked at first, and how many of the best are pulled.
_NUM_RANDOM = 64
_NUM_PULLED = 3
# Of many poses, so many are looked at more closely.
_MAX_TARGETS = 4
# Poses near the target that are then tried, each time nearer than the best so far.
_NUM_TRIES = 320
_MAX_ROUNDS = 8
# The same where lines or rules decide, of which gradients know little; and how often in vain.
_MAX_CLOSE_ROUNDS, _PATIENCE = 30, 3
# Where looking around a goal begins, how many times farther it goes each time in vain, and where it
# ends [m, in the pose metric].
_FIRST, _FARTHER, _FAR = 1e-3, 3.0, 3.0
# Of the time, what looking for the nearest may take.
_SHARE = 0.7
# What is nearer by less than this share is no news.
_NEWS = 0.999
# Obstacles that cost less than this share are not to blame: so near a minimum the search ends too.
_OWED = 0.99


@dataclass(frozen=True)
class _Found:
    """A free configuration and what it misses the goal by."""

    cost: float
    q: Array
    pose: Pose
    index: int


class NearestSearch:
    """Random configurations, then gradients, then poses nearer than the best one, over again.

    Where the query has rules, or its goal lines, gradients know little of what decides: then it is
    also looked around the goal, farther and farther, and around the best configuration.

    Every answer is within limits and free, keeps the rules, and has the goal's lines; that there is
    no nearer one is likely, not proven.
    """

    def __init__(
        self,
        world: World,
        query: GoalQuery,
        targets: list[ToolTarget] | list[Any],
        rng: np.random.Generator,
        deadline: Deadline,
    ) -> None:
        """Look for most of the time until the deadline; the rest is for what binds."""
        self._world = world
        self._query = query
        self._targets: list[Target] = list(targets)
        self._rng = rng
        self._whole, self._deadline = deadline, deadline.share(_SHARE)
        self._tries = PoseAttempts(world, query, self._targets, rng, self._deadline)
        self._nearby = PosePerturbations(world, query.group, self._targets[0].frame, rng)
        self._best: _Found | None = None

    def run(self, hints: Float64[np.ndarray, "n nq"]) -> NearestPose | None:
        """Return the nearest pose, None if no configuration was found free.

        Args:
            hints: Configurations that reach the goal, or nearly, but will not do.
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
        """Whether there is no time for more."""
        return self._deadline.is_over

    @property
    def _is_close_work(self) -> bool:
        """Whether more decides than limits and bodies."""
        return self._tries.lines is not None or self._query.rules is not None

    def _begin(self, rows: Array, num_hints: int) -> list[tuple[int, Array]]:
        """Take the best free row, and return which to pull, and to which target."""
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
        """Return the targets that some of the poses are nearest to."""
        if len(self._targets) <= _MAX_TARGETS:
            return list(range(len(self._targets)))
        places = reached[:, :3, 3]
        gaps = [
            float(np.linalg.norm(places - target.pose.position, axis=1).min())
            for target in self._targets
        ]
        return [int(i) for i in np.argsort(gaps, kind="stable")[:_MAX_TARGETS]]

    def _look_around(self, indices: list[int]) -> None:
        """Try poses around some targets, farther and farther until one will do."""
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
        """Try random poses that are nearer than the best; return whether any is to be had."""
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
        """Return displacements of cost 1 at most: along axes, aside, and turned.

        Those along axes, where obstacles have their sides, lie denser near length 1.
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
        """Keep the nearest of some configurations, if it will do and is nearer than the best."""
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
        """Return X_WT at each row, shape (n, 4, 4)."""
        full = self._world.embed(self._query.group, rows)
        return self._world.frame_poses(self._targets[0].frame, full)

    def _costs(self, reached: Array, index: int) -> Array:
        metric = self._query.options.pose_metric
        shift, turn = self._targets[index].misses(reached)
        return np.hypot(metric.translation * shift, metric.rotation * turn)

    def _report(self, best: _Found, *, is_reached: bool) -> NearestPose:
        """Say what binds, if there was time to find out, and how far away it is."""
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
        """Whether the best comes nearer once bodies may touch; surely if the goal is reached."""
        if is_reached:
            return True
        target = self._targets[best.index]
        q = self._pulled(target, best.q, is_apart=False)
        return bool(self._costs(self._poses_of(q[None]), best.index)[0] < _OWED * best.cost)
