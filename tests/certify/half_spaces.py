"""Robots over and with half spaces, and the heights of their shapes by closed formulas."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from pydrake.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Role,
    Shape,
    Sphere,
)
from pydrake.math import RigidTransform

from planning.domain.curves.curve import TimedTrajectory
from tests.certify.chains import KINDS, Builder, Robot, random_pose, random_shape
from tests.profiles import num_cases

# Of a motion.
_SAMPLES = num_cases(400, 2000)


def depth_of(shape: Shape, n: np.ndarray) -> float:
    """Return max n . x over the points x of a shape, n a unit vector in its frame [m]."""
    match shape:
        case Box():
            return float(np.abs(shape.size() / 2) @ np.abs(n))
        case Sphere():
            return shape.radius()
        case Cylinder():
            return float(shape.radius() * np.hypot(n[0], n[1]) + shape.length() / 2 * abs(n[2]))
        case Capsule():
            return float(shape.radius() + shape.length() / 2 * abs(n[2]))
        case Ellipsoid():
            return float(np.linalg.norm(np.array([shape.a(), shape.b(), shape.c()]) * n))
        case Convex():
            hull = shape.GetConvexHull()
            return max(float(hull.vertex(i) @ n) for i in range(hull.num_vertices()))
        case _:
            raise AssertionError(shape)


class Heights:
    """Heights of all pairs with one half space, at given configurations."""

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self._inspector: Any = robot.model.scene_graph.model_inspector()
        ids = self._inspector.GetAllGeometryIds(Role.kProximity)
        flat = {i for i in ids if isinstance(self._inspector.GetShape(i), HalfSpace)}
        self.pairs = [
            (a, b) if a in flat else (b, a)
            for a, b in sorted(self._inspector.GetCollisionCandidates())
            if (a in flat) != (b in flat)
        ]
        self._context: Any = robot.model.plant.CreateDefaultContext()

    def at(self, q: np.ndarray) -> np.ndarray:
        """Return the signed distance of every pair [m]."""
        model = self.robot.model
        full = model.embed(self.robot.group, q, self.robot.state)
        model.plant.SetPositions(self._context, full)
        return np.array([self._height(*pair) for pair in self.pairs])

    def along(self, trajectory: TimedTrajectory, count: int = _SAMPLES) -> float:
        """Return the smallest one at many samples of a motion."""
        times = np.linspace(0.0, trajectory.duration, count)
        return min(float(self.at(q).min()) for q in trajectory.positions(times))

    def _height(self, ground: Any, other: Any) -> float:
        (R_H, p_H), (R_G, p_G) = self._pose(ground), self._pose(other)
        up = R_H[:, 2]
        return float(up @ (p_G - p_H)) - depth_of(self._inspector.GetShape(other), -R_G.T @ up)

    def _pose(self, geometry: Any) -> tuple[np.ndarray, np.ndarray]:
        plant = self.robot.model.plant
        body = plant.GetBodyFromFrameId(self._inspector.GetFrameId(geometry))
        pose = body.EvalPoseInWorld(self._context) @ self._inspector.GetPoseInFrame(geometry)
        return pose.rotation().matrix(), pose.translation()


class PlainBuilder(Builder):
    """Names without colons, which Drake's collision checker does not accept here."""

    def body(self, name: str, shape: Shape, x_bg: RigidTransform | None = None) -> Any:
        return super().body(name.replace("::", "_"), shape, x_bg)


@dataclass(frozen=True)
class Place:
    """Where a random half space is.

    Attributes:
        seed: Of everything.
        is_carried: By a link; else it stands in the world.
        lowered: By so much along its normal [m].
    """

    seed: int
    is_carried: bool
    lowered: float = 0.0

    def robot(self) -> Robot:
        """Return a tree of random joints of which only the pairs with a half space are checked."""
        rng = np.random.default_rng(self.seed)
        builder = PlainBuilder()
        for i in range(3):
            pose = random_pose(rng, 0.05)
            axis = rng.normal(size=3)
            builder.link(
                KINDS[int(rng.integers(len(KINDS)))],
                random_shape(rng, 0.1),
                None if i == 0 or self.is_carried else i - 1,
                random_pose(rng, 0.3),
                axis / np.linalg.norm(axis),
                random_pose(rng, 0.1),
                pose,
            )
        links = builder.links
        builder.filtered = [(a, b) for i, a in enumerate(links) for b in links[:i]]
        at = random_pose(rng, 0.3) @ RigidTransform(np.array([0.0, 0.0, -self.lowered]))
        if self.is_carried:
            parent = int(rng.integers(3))
            axis = rng.normal(size=3)
            builder.link(
                KINDS[int(rng.integers(len(KINDS)))],
                HalfSpace(),
                parent,
                random_pose(rng, 0.2),
                axis / np.linalg.norm(axis),
                x_bg=at,
            )
        else:
            builder.obstacle("ground", HalfSpace(), at)
        return builder.build()
