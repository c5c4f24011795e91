"""GroupProgram: Drake's InverseKinematics over the coordinates of a group."""

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from jaxtyping import Float64
from pydrake.geometry import GeometryId
from pydrake.multibody.inverse_kinematics import InverseKinematics
from pydrake.solvers import SnoptSolver, SolverOptions

from planning.domain.robot.joints import JointGroup
from planning.world.collision.near_static import MOST_SHOWN, NearStatic
from planning.world.drake_model import Coupling
from planning.world.world import World

type Ids = tuple[GeometryId, GeometryId]
type Array = np.ndarray[Any, np.dtype[np.float64]]


class GroupProgram:
    """The group moves within its limits, what follows it follows, all else stays as it is.

    Attributes:
        ik: Costs and constraints are added to it.
        context: The plant's, of the program's own.
        q_indices: Where the group's q is in the plant's.
    """

    def __init__(self, world: World, group: JointGroup, max_iterations: int) -> None:
        """Build the program; solving it again only changes the initial guess."""
        self._world = world
        drake = world.drake
        self._diagram_context = drake.diagram.CreateDefaultContext()
        self.context = drake.plant.GetMyMutableContextFromRoot(self._diagram_context)
        drake.plant.SetPositions(self.context, world.state)
        self.q_indices = drake.position_indices(group)
        followers = drake.following(group)
        moving = {*self.q_indices.tolist(), *(c.follower_position for c in followers)}
        for index in drake.joint_indices.values():
            joint: Any = drake.plant.get_joint(index)
            if joint.position_start() not in moving:
                joint.Lock(self.context)
        self.ik = InverseKinematics(drake.plant, self.context, with_joint_limits=True)
        self._bound(group)
        self._couple(followers)
        self._solver, self._options = SnoptSolver(), SolverOptions()
        self._options.SetOption(SnoptSolver.id(), "Major iterations limit", max_iterations)

    def solve(self, seed: Float64[np.ndarray, " nq"]) -> Float64[np.ndarray, " nq"]:
        """Return where the solver ends, which need not be a solution."""
        result = self._solver.Solve(self.ik.prog(), self.full(seed), self._options)
        return np.array(result.GetSolution(self.ik.q())[self.q_indices])

    def show(self, pairs: Iterable[Ids]) -> Callable[[Ids], bool]:
        """Have Drake's part of the program know what some pairs of shapes are.

        Args:
            pairs: By Drake's ids, as `DistanceProbe` has them.

        Returns:
            Whether it knows both shapes of a pair: it is shown the first few dozen objects that
            stand outside of Drake's model, no more.
        """
        near = NearStatic(self._world.drake, self._diagram_context)
        rows = sorted({row for pair in pairs for i in pair if (row := near.row(i)) is not None})
        shown = set(rows[:MOST_SHOWN])
        near.show(sorted(shown))
        return lambda pair: all((row := near.row(i)) is None or row in shown for i in pair)

    def full(self, q: Float64[np.ndarray, " nq"]) -> Array:
        """Return the plant's configuration with the group at q."""
        full = np.array(self._world.state)
        full[self.q_indices] = q
        return self._world.drake.follow(full)

    def _bound(self, group: JointGroup) -> None:
        """Bound what Drake's plant does not: planar and floating joints have limits of ours."""
        limits = self._world.limits(group)
        bounded = np.isfinite(limits.lower) & np.isfinite(limits.upper)
        if bounded.any():
            self.ik.get_mutable_prog().AddBoundingBoxConstraint(
                limits.lower[bounded], limits.upper[bounded], self.ik.q()[self.q_indices][bounded]
            )

    def _couple(self, followers: tuple[Coupling, ...]) -> None:
        q = self.ik.q()
        for c in followers:
            pair = q[[c.follower_position, c.leader_position]]
            row, value = np.array([[1.0, -c.multiplier]]), np.array([c.offset])
            self.ik.get_mutable_prog().AddLinearEqualityConstraint(row, value, pair)
