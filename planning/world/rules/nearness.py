"""PairNearness: whether any of some pairs of bodies is near, by the kernel or by Drake."""

from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Bool, Float64

from planning.domain.joints import JointGroup
from planning.kernel.native import native
from planning.world.kernel_scene import kernel_scene_of
from planning.world.margins import PairMargins
from planning.world.world import CollisionJudge, World

_COLLIDING, _UNSURE = 1, 2


class PairNearness:
    """Says of configurations without collision whether a pair is nearer than a distance.

    To be near is to collide where the distance is the pairs' margin, and the margin of all others
    is 0. A collision judge gives Drake's answers, so it asks Drake about every two separate boxes
    (docs/decisions/0006); that they are near the kernel knows by itself.
    """

    def __init__(
        self, world: World, group: JointGroup, pairs: frozenset[tuple[str, str]], distance: float
    ) -> None:
        """Ask about pairs, by full names in sorted order, and a distance [m]."""
        self._world, self._group = world, group
        self._margins = PairMargins(0.0, dict.fromkeys(sorted(pairs), distance))
        scene, module = kernel_scene_of(world.drake), native()
        self._checker: Any = None
        if scene is not None and module is not None:
            demands = scene.demands(self._margins)
            self._checker = module.Checker(
                scene.native,
                world.drake.position_indices(group).astype(np.int64),
                world.drake.velocity_indices(group).astype(np.int64),
                world.drake.follow(np.array(world.state)),
                np.column_stack([demands, demands]),
            )

    def are_near(self, qs: Float64[np.ndarray, "m nq"]) -> Bool[np.ndarray, " m"]:
        """Return whether a pair is near at each row; of a row that collides nothing is said."""
        if self._checker is None:
            return ~self._judge.are_free(qs)
        verdicts = self._checker.judge(np.ascontiguousarray(qs))
        near = verdicts == _COLLIDING
        unsure = verdicts == _UNSURE
        if unsure.any():
            near[unsure] = ~self._judge.are_free(qs[unsure])
        return near

    @cached_property
    def _judge(self) -> CollisionJudge:
        return self._world.collision_oracle(self._group, self._margins)
