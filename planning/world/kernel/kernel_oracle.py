"""Collision checks by the native kernel where it is certain, and by Drake where it is not."""

from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Bool, Float64, UInt8
from pydrake.planning import SceneGraphCollisionChecker

from planning.domain.arrays import Array, Flags, Indices
from planning.domain.curves import motion_samples
from planning.domain.robot.joints import JointGroup
from planning.domain.robot.manifold import Manifold
from planning.kernel.native import native, verdict_numbers
from planning.world.collision.collision_check import DrakeCollisionOracle
from planning.world.collision.margins import PairMargins
from planning.world.drake_model import DrakeModel
from planning.world.kernel.connect_trees import ConnectTrees
from planning.world.kernel.kernel_scene import KernelScene


class KernelCollisionOracle:
    """Collision checker with Drake's results: free or colliding by the kernel is the same by Drake.

    For separate boxes both use the true distance, which Drake overstates now and then.

    Attributes:
        num_undecided: Configurations that were left to Drake so far.
    """

    def __init__(
        self,
        model: DrakeModel,
        scene: KernelScene,
        group: JointGroup,
        state: Float64[np.ndarray, " num_positions"],
        margins: PairMargins,
        make_checker: Callable[[], SceneGraphCollisionChecker] | None = None,
    ) -> None:
        """Prepare the kernel for a group, with `margins` of every pair.

        `make_checker` makes Drake's checker of the model without margins.
        """
        self.num_undecided = 0
        self._drake_arguments = model, group, state, margins, make_checker
        self._manifold = Manifold.of(group.joints)
        module: Any = native()
        # As numbers: comparisons of enum members would cost as much as a check.
        self._free, self._colliding, self._undecided = verdict_numbers(module)
        self._checker = module.Checker(
            scene.native,
            model.position_indices(group).astype(np.int64),
            model.velocity_indices(group).astype(np.int64),
            model.apply_couplings(np.array(state)),
            pair_thresholds(scene, margins),
        )
        self._has_linear_motions = group.num_positions == group.num_velocities

    @property
    def native_checker(self) -> Any | None:
        """The kernel's checker, where motions are straight lines of q."""
        return self._checker if self._has_linear_motions else None

    def is_free(self, q: Float64[np.ndarray, " nq"]) -> bool:
        """Return whether all pairs keep their margins with the group at q, shape (nq,)."""
        verdict = self._checker.check_one(q)
        if verdict == self._undecided:
            self.num_undecided += 1
            return self._drake_oracle.is_free(q)
        return verdict == self._free

    def are_free(self, qs: Float64[np.ndarray, "m nq"]) -> Bool[np.ndarray, " m"]:
        """Return the same for each row."""
        free, undecided = self._checker.check_free(qs)
        if len(undecided):
            self.num_undecided += len(undecided)
            free[undecided] = self._drake_oracle.are_free(qs[undecided])
        return free

    def verdicts(self, qs: Float64[np.ndarray, "m nq"]) -> UInt8[np.ndarray, " m"]:
        """Return the kernel's own verdicts, as numbers of its Verdict."""
        return self._checker.check(qs)

    def is_motion_free(
        self,
        origin: Float64[np.ndarray, " nq"],
        displacement: Float64[np.ndarray, " nv"],
        resolution: float,
    ) -> bool:
        """Return whether every sample of a motion is free, as `motion_samples` defines them."""
        if self._has_linear_motions:
            verdict = self._checker.check_motion(origin, displacement, resolution)
            if verdict != self._undecided:
                return verdict == self._free
        return bool(self.are_motions_free(origin[None], displacement[None], resolution)[0])

    def is_edge_free(self, q0: list[float], q1: list[float], resolution: float) -> tuple[bool, int]:
        """Return whether the straight edge between two configurations is free, and its steps.

        Both ends are checked. For joints that do not float.
        """
        verdict, steps = self._checker.check_edge(q0, q1, resolution)
        if verdict != self._undecided:
            return verdict == self._free, steps
        begin, end = np.array(q0), np.array(q1)
        return self.is_free(begin) and self.is_motion_free(begin, end - begin, resolution), steps

    def are_motions_free(
        self,
        origins: Float64[np.ndarray, "m nq"],
        displacements: Float64[np.ndarray, "m nv"],
        resolution: float,
    ) -> Bool[np.ndarray, " m"]:
        """Return the same for each pair of rows."""
        if not self._has_linear_motions:
            motions = origins, displacements
            return motion_samples.are_motions_free(
                self._manifold, self.are_free, motions, resolution
            )
        verdicts, undecided = self._checker.check_motions(origins, displacements, resolution)
        free = verdicts != self._colliding
        if len(undecided):
            self._decide(free, undecided, origins, displacements)
        return free

    def are_edges_free(
        self,
        q0s: Float64[np.ndarray, "m nq"],
        q1s: Float64[np.ndarray, "m nq"],
        resolution: float,
        max_steps: int,
    ) -> tuple[Bool[np.ndarray, " m"], int] | None:
        """Return whether each straight edge is free, as its motion, and how many steps all have.

        None if these are more than `max_steps`. For joints that do not float.
        """
        found = self._checker.check_edges(q0s, q1s, resolution, max_steps)
        if found is None:
            return None
        free, undecided, num_steps = found
        if len(undecided):
            self._decide(free, undecided, q0s, q1s - q0s)
        return free, num_steps

    def first_free_edge(
        self,
        q0s: Float64[np.ndarray, "m nq"],
        q1s: Float64[np.ndarray, "m nq"],
        resolution: float,
        max_steps: int,
    ) -> tuple[int, bool, int]:
        """Return the first straight edge that is free: its index, if that is sure, and the steps.

        The index is the number of edges if none is free. An edge that is not sure, or has more than
        `max_steps`, ends the search as well, and its steps do not count. For joints that do not
        float.

        Args:
            q0s: Where edges begin, one row for all or for each.
            q1s: Where they end, likewise.
            resolution: Largest length of a step.
            max_steps: Largest number of steps of an edge.
        """
        return self._checker.first_edge(q0s, q1s, resolution, max_steps)

    def _decide(
        self, free: Flags, undecided: Indices, origins: Array, displacements: Array
    ) -> None:
        """Have Drake decide samples of motions, in rows of motion, i and n."""
        for motion in np.unique(undecided[:, 0]):
            rows = undecided[undecided[:, 0] == motion]
            fractions = rows[:, 1] / rows[:, 2]
            qs = origins[motion] + fractions[:, None] * displacements[motion]
            self.num_undecided += len(qs)
            free[motion] = self._drake_oracle.are_free(qs).all()

    def connect_trees(
        self,
        start: Float64[np.ndarray, " nq"],
        goals: Float64[np.ndarray, "n nq"],
        bounds: tuple[Float64[np.ndarray, " nq"], Float64[np.ndarray, " nq"]],
        max_step: float,
        resolution: float,
        seed: int,
    ) -> ConnectTrees | None:
        """Return the trees of RRTConnect; None for joints that float.

        Args:
            start: Configuration inside the bounds.
            goals: Configurations inside the bounds, at least one.
            bounds: Lower and upper bounds of samples.
            max_step: Greatest length of an edge.
            resolution: Greatest distance of two checked samples.
            seed: Seed of a Mersenne twister of 32 bits.
        """
        if not self._has_linear_motions:
            return None
        module: Any = native()
        trees = module.RrtConnect(self._checker, start, goals, *bounds, max_step, resolution, seed)
        return ConnectTrees(
            trees, lambda q0, q1: self.is_free(q0) and self.is_motion_free(q0, q1 - q0, resolution)
        )

    @cached_property
    def _drake_oracle(self) -> DrakeCollisionOracle:
        """Drake's checker, made at its first use: that takes longer than most searches."""
        return DrakeCollisionOracle(*self._drake_arguments)


def pair_thresholds(scene: KernelScene, margins: PairMargins) -> Array:
    """Return margin and touching distance of every pair [m], shape (n, 2)."""
    return np.repeat(scene.pair_margins(margins)[:, None], 2, axis=1)
