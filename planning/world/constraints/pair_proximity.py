"""PairProximity: proximity test of some pairs of bodies, by the kernel or by Drake."""

from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Bool, Float64

from planning.domain.curves.motion_samples import sample_batches
from planning.domain.robot.joints import JointGroup
from planning.domain.robot.manifold import Manifold
from planning.kernel.native import native, verdict_numbers
from planning.world.collision.margins import PairMargins
from planning.world.kernel.kernel_scene import kernel_scene_of
from planning.world.world import CollisionChecker, World


class PairProximity:
    """Test of collision-free configurations: whether a pair is nearer than a distance.

    It is a collision check with that distance as the pairs' margin, and margin 0 for all other
    pairs. A collision checker gives Drake's results, so it leaves separate boxes to Drake
    (docs/decisions/0006); here the kernel decides by itself whether they are near.
    """

    def __init__(
        self, world: World, group: JointGroup, pairs: frozenset[tuple[str, str]], distance: float
    ) -> None:
        """Prepare for pairs, by full names in sorted order, and a distance [m]."""
        self._world, self._group = world, group
        self._manifold = Manifold(group.joints)
        self._has_linear_motions = group.num_positions == group.num_velocities
        self._margins = PairMargins(0.0, dict.fromkeys(sorted(pairs), distance))
        scene, module = kernel_scene_of(world.drake), native()
        self._checker: Any = None
        if scene is not None and module is not None:
            self._free, self._colliding, self._undecided = verdict_numbers(module)
            thresholds = scene.pair_margins(self._margins)
            self._checker = module.Checker(
                scene.native,
                world.drake.position_indices(group).astype(np.int64),
                world.drake.velocity_indices(group).astype(np.int64),
                world.drake.apply_couplings(np.array(world.state)),
                np.column_stack([thresholds, thresholds]),
            )

    def are_near(self, qs: Float64[np.ndarray, "m nq"]) -> Bool[np.ndarray, " m"]:
        """Return whether a pair is near at each row; undefined for a row in collision."""
        if self._checker is None:
            return ~self._exact_checker.are_free(qs)
        verdicts = self._checker.check(np.ascontiguousarray(qs))
        is_near = verdicts == self._colliding
        undecided = verdicts == self._undecided
        if undecided.any():
            is_near[undecided] = ~self._exact_checker.are_free(qs[undecided])
        return is_near

    def is_motion_clear(
        self,
        origin: Float64[np.ndarray, " nq"],
        displacement: Float64[np.ndarray, " nv"],
        resolution: float,
    ) -> bool:
        """Return whether no pair is near at any sample of a motion."""
        if self._checker is None:
            return self._exact_checker.is_motion_free(origin, displacement, resolution)
        if self._has_linear_motions:
            verdict = self._checker.check_motion(origin, displacement, resolution)
            if verdict != self._undecided:
                return verdict == self._free
        batches = sample_batches(self._manifold, (origin, displacement), resolution)
        return not any(self.are_near(qs).any() for qs in batches)

    @cached_property
    def _exact_checker(self) -> CollisionChecker:
        return self._world.collision_oracle(self._group, self._margins)
