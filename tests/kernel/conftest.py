"""The kernel's verdicts beside Drake's, on robots made up at random."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from planning.domain.robot.manifold import Manifold
from planning.kernel.native import native
from planning.world.collision.margins import PairMargins
from planning.world.kernel.kernel_oracle import pair_thresholds
from planning.world.kernel.kernel_scene import KernelScene, kernel_scene
from tests.certify.chains import FLOATING, Robot

FREE, COLLIDING, UNSURE = 0, 1, 2


@pytest.fixture(autouse=True)
def _only_with_kernel() -> None:
    if native() is None:
        pytest.skip("the native kernel is not built")


@dataclass(frozen=True)
class ComparedRobot:
    """A robot in both."""

    robot: Robot
    scene: KernelScene

    @classmethod
    def of(cls, robot: Robot) -> "ComparedRobot":
        scene = kernel_scene(robot.model)
        assert scene is not None
        return cls(robot, scene)

    def margins(self, margin: float) -> PairMargins:
        """Return that margin for every pair, those within the robot as well."""
        return PairMargins(margin, {(min(p), max(p)): margin for p in self.scene.bodies})

    def checker(self, margin: float, kernel: str = "") -> Any:
        model, group = self.robot.model, self.robot.group
        module: Any = native()
        return module.Checker(
            self.scene.native,
            model.position_indices(group).astype(np.int64),
            model.velocity_indices(group).astype(np.int64),
            model.apply_couplings(np.array(self.robot.state)),
            pair_thresholds(self.scene, self.margins(margin)),
            kernel,
        )

    def drake(self, qs: np.ndarray, margin: float) -> np.ndarray:
        """Return Drake's verdicts by its own distances: True where every pair keeps the margin."""
        model = self.robot.model
        context = model.diagram.CreateDefaultContext()
        plant_context = model.plant.GetMyMutableContextFromRoot(context)
        query_context = model.scene_graph.GetMyContextFromRoot(context)
        free = []
        for q in qs:
            full = model.embed(self.robot.group, q, self.robot.state)
            model.plant.SetPositions(plant_context, full)
            query: Any = model.scene_graph.get_query_output_port().Eval(query_context)
            found = query.ComputeSignedDistancePairwiseClosestPoints(margin + 1e-9)
            free.append(all(pair.distance > margin for pair in found))
        return np.array(free)

    def configurations(self, rng: np.random.Generator, count: int, spread: float) -> np.ndarray:
        group = self.robot.group
        q = np.zeros(group.num_positions)
        begin = 0
        for joint in group.joints:
            if joint.type is FLOATING:
                q[begin] = 1.0
            begin += joint.num_positions
        manifold = Manifold(group.joints)
        steps = rng.normal(0.0, spread, (count, manifold.num_velocities))
        return manifold.plus(np.repeat(q[None], count, axis=0), steps)
