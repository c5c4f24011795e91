"""GroupProgram: Drake's InverseKinematics (a nonlinear program) over a group's coordinates."""

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from jaxtyping import Float64
from pydrake.geometry import GeometryId
from pydrake.multibody.inverse_kinematics import InverseKinematics
from pydrake.solvers import SnoptSolver, SolverOptions

from planning.domain.arrays import Array
from planning.domain.robot.joints import JointGroup
from planning.world.collision.near_static import MAX_REGISTERED, NearStatic
from planning.world.drake_model import Coupling
from planning.world.world import World

type GeometryPair = tuple[GeometryId, GeometryId]


class GroupProgram:
    """Nonlinear program over a group within its limits; mimic joints follow, all else is locked.

    Attributes:
        ik: Drake's InverseKinematics, to which costs and constraints are added.
        context: Context of the plant, owned by the program.
        q_indices: Indices of the group's q in the plant's q.
    """

    def __init__(self, world: World, group: JointGroup, max_iterations: int) -> None:
        """Build the program; solving it again only changes the initial guess."""
        self._world = world
        drake = world.drake
        self._diagram_context = drake.diagram.CreateDefaultContext()
        self.context = drake.plant.GetMyMutableContextFromRoot(self._diagram_context)
        drake.plant.SetPositions(self.context, world.state)
        self.q_indices = drake.position_indices(group)
        followers = drake.followers_of(group)
        moving = {*self.q_indices.tolist(), *(c.follower_position for c in followers)}
        for index in drake.joint_indices.values():
            joint: Any = drake.plant.get_joint(index)
            if joint.position_start() not in moving:
                joint.Lock(self.context)
        self.ik = InverseKinematics(drake.plant, self.context, with_joint_limits=True)
        self._add_joint_limits(group)
        self._add_mimic_constraints(followers)
        self._solver, self._options = SnoptSolver(), SolverOptions()
        self._options.SetOption(SnoptSolver.id(), "Major iterations limit", max_iterations)

    def solve(self, seed: Float64[np.ndarray, " nq"]) -> Float64[np.ndarray, " nq"]:
        """Return the final iterate of the solver (SNOPT), which need not be a solution."""
        result = self._solver.Solve(self.ik.prog(), self.embed(seed), self._options)
        return np.array(result.GetSolution(self.ik.q())[self.q_indices])

    def register_geometries(self, pairs: Iterable[GeometryPair]) -> Callable[[GeometryPair], bool]:
        """Register the geometries of some pairs in Drake's scene graph for this program.

        Args:
            pairs: Geometry ids, as of `DistanceProbe`.

        Returns:
            Predicate: whether both geometries of a pair are registered. Of the objects outside of
            Drake's model at most `MAX_REGISTERED` are.
        """
        near = NearStatic(self._world.drake, self._diagram_context)
        rows = sorted({row for pair in pairs for i in pair if (row := near.row(i)) is not None})
        registered = set(rows[:MAX_REGISTERED])
        near.register(sorted(registered))
        return lambda pair: all((row := near.row(i)) is None or row in registered for i in pair)

    def embed(self, q: Float64[np.ndarray, " nq"]) -> Array:
        """Return the plant's configuration with the group at q."""
        full = np.array(self._world.state)
        full[self.q_indices] = q
        return self._world.drake.apply_couplings(full)

    def _add_joint_limits(self, group: JointGroup) -> None:
        """Add the group's bounds: the plant has none for planar and floating joints."""
        limits = self._world.limits(group)
        bounded = np.isfinite(limits.lower) & np.isfinite(limits.upper)
        if bounded.any():
            self.ik.get_mutable_prog().AddBoundingBoxConstraint(
                limits.lower[bounded], limits.upper[bounded], self.ik.q()[self.q_indices][bounded]
            )

    def _add_mimic_constraints(self, followers: tuple[Coupling, ...]) -> None:
        q = self.ik.q()
        for c in followers:
            pair = q[[c.follower_position, c.leader_position]]
            row, value = np.array([[1.0, -c.multiplier]]), np.array([c.offset])
            self.ik.get_mutable_prog().AddLinearEqualityConstraint(row, value, pair)
