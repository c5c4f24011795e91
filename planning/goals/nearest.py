"""The nearest free pose that a tool frame can take to one that it cannot."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.deadline import Deadline
from planning.domain.goal_configurations import NearestPose
from planning.domain.pose import Pose
from planning.goals.goal_query import GoalQuery
from planning.goals.nearest_program import Target, pulled, to_pose
from planning.goals.pose_tries import PoseTries
from planning.goals.tool_target import ToolTarget
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
# What is nearer by less than this share is no news.
_NEWS = 0.999
# Obstacles that cost less than this share are not to blame: so near a minimum the search ends too.
_OWED = 0.99
# A pair or a joint within this of its bound is at it [m, rad].
_AT_BOUND = 1e-4


@dataclass(frozen=True)
class _Found:
    """A free configuration and what it misses the goal by."""

    cost: float
    q: Array
    pose: Pose
    index: int


class NearestSearch:
    """Random configurations, then gradients, then poses nearer than the best one, over again.

    Every answer is within limits and free; that there is no nearer one is likely, not proven.
    """

    def __init__(
        self,
        world: World,
        query: GoalQuery,
        targets: list[ToolTarget] | list[Any],
        rng: np.random.Generator,
        deadline: Deadline,
    ) -> None:
        """Look until the deadline at most."""
        self._world = world
        self._query = query
        self._targets: list[Target] = list(targets)
        self._rng = rng
        self._deadline = deadline
        self._limits = world.limits(query.group)
        self._tries = PoseTries(world, query, self._targets[0].frame, rng, deadline)
        self._best: _Found | None = None

    def run(self, hints: Float64[np.ndarray, "n nq"]) -> NearestPose | None:
        """Return the nearest pose, None if no configuration was found free.

        Args:
            hints: Configurations that reach the goal, or nearly, but collide.
        """
        self._tries.hints = self._rng.permutation(hints)
        rows = np.concatenate([hints, self._tries.random(_NUM_RANDOM)])
        begun = self._begin(rows, len(hints))
        for i, q in begun:
            if self._deadline.is_over and self._best is not None:
                break
            self._consider(self._pulled(self._targets[i], q)[None], [i])
        for _ in range(_MAX_ROUNDS):
            if self._best is None or self._deadline.is_over or not self._nearer(self._best):
                break
        if self._best is None:
            return None
        return self._report(self._best, is_reached=len(hints) > 0)

    def _begin(self, rows: Array, num_hints: int) -> list[tuple[int, Array]]:
        """Take the best free row, and return which to pull, and to which target."""
        full = self._world.embed(self._query.group, rows)
        reached = [Pose.from_matrix(x) for x in self._frame_poses(full)]
        targets = self._promising(reached)
        costs = np.array([[self._cost(pose, i) for i in targets] for pose in reached])
        free = self._tries.are_feasible(rows)
        nearest = costs.argmin(axis=1)
        costs = costs.min(axis=1)
        order = np.argsort(costs, kind="stable")
        for k in order[free[order]][:1]:
            index = targets[int(nearest[k])]
            self._best = _Found(float(costs[k]), rows[k], reached[k], index)
        first = [k for k in order if k < num_hints][:_NUM_PULLED]
        then = [k for k in order if k >= num_hints][:_NUM_PULLED]
        freest = list(order[free[order]][:_NUM_PULLED])
        chosen = dict.fromkeys(int(k) for k in [*first, *then, *freest])
        return [(targets[int(nearest[k])], rows[k]) for k in chosen]

    def _promising(self, reached: list[Pose]) -> list[int]:
        """Return the targets that some of the poses are nearest to."""
        if len(self._targets) <= _MAX_TARGETS:
            return list(range(len(self._targets)))
        places = np.array([pose.position for pose in reached])
        gaps = [
            float(np.linalg.norm(places - target.pose.position, axis=1).min())
            for target in self._targets
        ]
        return [int(i) for i in np.argsort(gaps, kind="stable")[:_MAX_TARGETS]]

    def _nearer(self, best: _Found) -> bool:
        """Try random poses that are nearer than the best; return whether any is to be had."""
        target = self._targets[best.index]
        rows = self._tries.reach(target.closest(best.pose), best.cost * self._moves(), best.q)
        self._consider(rows, [best.index] * len(rows))
        if self._best is None or self._best.cost >= _NEWS * best.cost:
            return False
        q = self._pulled(target, self._best.q)
        self._consider(q[None], [best.index])
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
        """Keep the nearest of some configurations, if it is free and nearer than the best."""
        free = self._tries.are_feasible(rows)
        reached = self._frame_poses(self._world.embed(self._query.group, rows[free]))
        kept = [i for i, is_free in zip(indices, free, strict=True) if is_free]
        for q, x_wt, i in zip(rows[free], reached, kept, strict=True):
            pose = Pose.from_matrix(x_wt)
            cost = self._cost(pose, i)
            if self._best is None or cost < self._best.cost:
                self._best = _Found(cost, np.array(q), pose, i)

    def _pulled(self, target: Target, q: Array, *, is_apart: bool = True) -> Array:
        pull = to_pose(self._world, self._query, target)
        return pulled(self._world, self._query, pull, q, is_apart=is_apart)

    def _frame_poses(self, full: Array) -> Array:
        return self._world.frame_poses(self._targets[0].frame, full)

    def _cost(self, pose: Pose, index: int) -> float:
        metric = self._query.options.pose_metric
        shift, turn = pose.distance(self._targets[index].closest(pose))
        return float(np.hypot(metric.translation * shift, metric.rotation * turn))

    def _report(self, best: _Found, *, is_reached: bool) -> NearestPose:
        """Say what binds: bodies at their margins, else joints at their limits, else the reach.

        Bodies that only happen to be at their margins, because the goal is reached in no collision
        either and without them the pose would be no nearer, are not blamed.
        """
        group = self._query.group
        shift, turn = best.pose.distance(self._targets[best.index].closest(best.pose))
        pairs = self._touching(best.q)
        if pairs and not is_reached and not self._is_kept_off(best):
            pairs = ()
        gaps = np.minimum(best.q - self._limits.lower, self._limits.upper - best.q)
        joints = tuple(
            name for name, gap in zip(group.position_names, gaps, strict=True) if gap < _AT_BOUND
        )
        binding = "collision" if pairs else "limits" if joints else "reach"
        return NearestPose(best.pose, best.q, shift, turn, best.index, binding, joints, pairs)

    def _touching(self, q: Array) -> tuple[tuple[str, str], ...]:
        """Return the pairs of bodies that are at their margins."""
        margins = self._query.margins
        probe = self._world.distance_probe(margins)
        full = self._world.embed(self._query.group, q)
        near = probe.pairs_within(full, margins.largest + _AT_BOUND)
        return tuple(
            pair.bodies for pair in near if pair.distance < margins.of(*pair.bodies) + _AT_BOUND
        )

    def _is_kept_off(self, best: _Found) -> bool:
        """Whether the best comes nearer once bodies may touch."""
        target = self._targets[best.index]
        q = self._pulled(target, best.q, is_apart=False)
        (x_wt,) = self._frame_poses(self._world.embed(self._query.group, q[None]))
        return self._cost(Pose.from_matrix(x_wt), best.index) < _OWED * best.cost
