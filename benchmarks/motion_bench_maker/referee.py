"""Referee: Drake's checker on the exact model, built here and from the data's own files.

It shares no code with what it judges: the plant is built from the URDF, the SRDF's pairs and the
problem's objects, and the trajectory's polynomials are evaluated here. Only their numbers are
taken from the plan.
"""

import logging
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydrake.common import Parallelism
from pydrake.common.eigen_geometry import Quaternion
from pydrake.geometry import Box, Cylinder, Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.plant import CoulombFriction
from pydrake.multibody.tree import SpatialInertia
from pydrake.planning import (
    CollisionCheckerParams,
    RobotDiagramBuilder,
    SceneGraphCollisionChecker,
)

from benchmarks.motion_bench_maker.problems import Obstacle, Problem
from benchmarks.motion_bench_maker.robots import RobotFiles
from planning.domain.arrays import Array

# Drake warns of every URDF tag that it does not need.
logging.getLogger("drake").setLevel(logging.ERROR)


# Largest distance between two samples, as a Euclidean norm over the joints [rad].
STEP = 0.002
# How far a motion may begin or end from where it was asked to [rad, m].
_AT_ENDS = 1e-4
_CHUNK = 2000


@dataclass(frozen=True)
class Polynomials:
    """A delivered motion: q(t) = bases[i] + sum_k coefficients[i, k] (t - breaks[i])^k.

    Attributes:
        joints: Names without a robot's prefix, in the order of the columns.
        breaks: Instants, shape (n + 1,) [s].
        bases: Shape (n, nq).
        coefficients: Lowest power first, shape (n, degree + 1, nq).
    """

    joints: tuple[str, ...]
    breaks: Array
    bases: Array
    coefficients: Array

    def samples(self, step: float = STEP) -> Array:
        """Return configurations along the motion, shape (m, nq), at most `step` apart.

        The arc between two samples is at most `step` long, because the speed on a piece of
        duration h is at most sum_k k |c_k| h^(k - 1).
        """
        rows: list[Array] = []
        for i, duration in enumerate(np.diff(self.breaks)):
            powers = np.arange(self.coefficients.shape[1])
            norms = np.linalg.norm(self.coefficients[i], axis=1)
            arc = float(np.sum(powers[1:] * norms[1:] * duration ** powers[1:]))
            count = max(1, int(np.ceil(arc / step)))
            local = np.linspace(0.0, duration, count + 1)
            rows.append(self.bases[i] + (local[:, None] ** powers) @ self.coefficients[i])
        return np.concatenate(rows)

    @classmethod
    def through(
        cls, joints: tuple[str, ...], times: Array, positions: Array, velocities: Array
    ) -> "Polynomials":
        """Return the cubic Hermite curve of setpoints: it has their positions and velocities.

        Args:
            joints: Names, in the order of the columns.
            times: Instants, strictly increasing, shape (n,) [s].
            positions: Shape (n, nq) [rad].
            velocities: Shape (n, nq) [rad/s].
        """
        h = np.diff(times)[:, None]
        slope, before, after = np.diff(positions, axis=0) / h, velocities[:-1], velocities[1:]
        rows = [
            np.zeros_like(slope),
            before,
            (3 * slope - 2 * before - after) / h,
            (before + after - 2 * slope) / h**2,
        ]
        return cls(joints, times, positions[:-1], np.stack(rows, axis=1))

    def velocities(self, instants: Array) -> Array:
        """Return the velocities at some instants, shape (m, nq) [rad/s]."""
        last = len(self.bases) - 1
        pieces = np.clip(np.searchsorted(self.breaks, instants, side="right") - 1, 0, last)
        local = (instants - self.breaks[pieces])[:, None]
        powers = np.arange(1, self.coefficients.shape[1])
        factors = powers * local ** (powers - 1)
        return np.einsum("mk,mkn->mn", factors, self.coefficients[pieces][:, 1:])


class Referee:
    """Judges configurations and motions of one problem."""

    def __init__(self, files: RobotFiles, problem: Problem) -> None:
        """Build the exact model."""
        self._problem = problem
        builder: Any = RobotDiagramBuilder(time_step=0.0)
        plant = builder.plant()
        (robot,) = builder.parser().AddModels(str(files.urdf))
        base = plant.GetBodyByName(files.root_link, robot)
        plant.WeldFrames(plant.world_frame(), base.body_frame())
        for thing in problem.obstacles:
            _add(plant, thing)
        plant.Finalize()
        self._plant = plant
        self._tool = plant.GetFrameByName(files.spec.tool, robot)
        self._checker: Any = SceneGraphCollisionChecker(
            CollisionCheckerParams(
                model=builder.Build(),
                robot_model_instances=[robot],
                edge_step_size=STEP,
                implicit_context_parallelism=Parallelism(1),
            )
        )
        for pair in files.disabled_pairs:
            if all(plant.HasBodyNamed(name, robot) for name in pair):
                a, b = (plant.GetBodyByName(name, robot).index() for name in pair)
                self._checker.SetCollisionFilteredBetween(a, b, True)  # noqa: FBT003
        self._rest = np.array(plant.GetPositions(self._checker.plant_context()))

    @property
    def is_valid(self) -> bool:
        """Whether neither the start nor the goal collides."""
        return self._are_free(np.array([self._problem.start, self._problem.goal]))

    @property
    def goal_pose(self) -> Array:
        """X_WT of the tool at the goal, shape (4, 4)."""
        return self._tool_pose(np.array(self._problem.goal))

    def is_free(self, motion: Polynomials) -> bool:
        """Return whether the motion touches nothing, from its first sample to its last."""
        return self._are_free(self._columns(motion, motion.samples()))

    def is_from_start_to_goal(self, motion: Polynomials, *, pose: bool) -> bool:
        """Return whether the motion begins at the start and ends at the goal, or at its pose."""
        ends = self._columns(motion, motion.samples()[[0, -1]])
        at_start = np.abs(ends[0] - self._problem.start).max() <= _AT_ENDS
        if pose:
            miss = np.abs(self._tool_pose(ends[1]) - self.goal_pose).max()
        else:
            miss = np.abs(ends[1] - self._problem.goal).max()
        return bool(at_start and miss <= _AT_ENDS)

    def _columns(self, motion: Polynomials, qs: Array) -> Array:
        return qs[:, [motion.joints.index(joint) for joint in self._problem.joints]]

    def _full(self, qs: Array) -> Array:
        full = np.tile(self._rest, (len(qs), 1))
        for column, joint in enumerate(self._problem.joints):
            full[:, self._plant.GetJointByName(joint).position_start()] = qs[:, column]
        return full

    def _are_free(self, qs: Array) -> bool:
        full = self._full(qs)
        return all(
            all(self._checker.CheckConfigsCollisionFree(list(full[i : i + _CHUNK]), Parallelism(1)))
            for i in range(0, len(full), _CHUNK)
        )

    def _tool_pose(self, q: Array) -> Array:
        context = self._plant.CreateDefaultContext()
        self._plant.SetPositions(context, self._full(q[None])[0])
        return np.array(self._tool.CalcPoseInWorld(context).GetAsMatrix4())


def _add(plant: Any, thing: Obstacle) -> None:
    match thing.kind:
        case "box":
            shape = Box(*thing.dims)
        case "cylinder":
            length, radius = thing.dims
            shape = Cylinder(radius, length)
        case _:
            shape = Sphere(*thing.dims)
    body = plant.AddRigidBody(thing.name, plant.AddModelInstance(thing.name), SpatialInertia.NaN())
    identity = RigidTransform.Identity()
    plant.RegisterCollisionGeometry(body, identity, shape, thing.name, CoulombFriction(1.0, 1.0))
    unit = np.array(thing.quaternion) / np.linalg.norm(thing.quaternion)
    x_wo = RigidTransform(Quaternion(unit), np.array(thing.position))
    plant.WeldFrames(plant.world_frame(), body.body_frame(), x_wo)
