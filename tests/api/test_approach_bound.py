"""Bodies come no nearer than the bound says, wherever a robot is."""

import numpy as np

from planning.api.approach_bound import approach_bound
from planning.domain.curves.interpolation import trajectory_through
from tests.conftest import bundled_world
from tests.profiles import num_cases, rng_of


def test_no_point_of_the_arm_moves_further_than_the_bound() -> None:
    world = bundled_world("ur5e_pickup")
    group = world.group("arm")
    home = world.positions(group)
    motion = trajectory_through(group.joints, np.array([0.0, 1.0]), np.array([home, home + 0.1]))
    rng, plant = rng_of(3), world.drake.plant
    deviations = np.array([2e-3, 1e-3, 1e-3, 5e-4, 0.0, 1e-3])
    bound = approach_bound(world, "arm", motion, deviations)
    assert 1e-3 < bound < 0.02
    context = plant.CreateDefaultContext()
    bodies = [plant.get_body(index) for index in world.drake.bodies.values()]

    def origins(q: np.ndarray) -> np.ndarray:
        plant.SetPositions(context, world.drake.embed(group, q, world.state))
        return np.array([plant.EvalBodyPoseInWorld(context, b).translation() for b in bodies])

    for _ in range(num_cases(50)):
        q = rng.uniform(-3, 3, 6)
        moved = q + deviations * rng.choice([-1.0, 1.0], 6)
        assert np.linalg.norm(origins(moved) - origins(q), axis=1).max() <= bound
    assert approach_bound(world, "arm", motion, np.zeros(6)) == 0.0
