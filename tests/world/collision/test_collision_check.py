"""Drake's oracle judges motions by their samples."""

import numpy as np
import pytest

from planning.domain.curves.motion_samples import sample_batches
from planning.domain.robot.manifold import Manifold
from tests.conftest import bundled_world


@pytest.mark.parametrize("scene", ["ur5e_pickup", "maze_2d", "window_3d"])
def test_motions_are_free_where_all_their_samples_are(scene: str) -> None:
    world = bundled_world(scene)
    group = world.groups[0]
    manifold = Manifold(group.joints)
    oracle = world.collision_oracle(group, world.margins(0.01))
    rng = np.random.default_rng(0)
    origin = world.positions(group)
    origins = manifold.plus(origin, rng.uniform(-0.7, 0.7, (40, manifold.num_velocities)))
    displacements = rng.uniform(-0.7, 0.7, (40, manifold.num_velocities))
    verdicts = oracle.are_motions_free(origins, displacements, 0.1)
    assert verdicts.any()
    assert not verdicts.all()
    for motion, verdict in zip(zip(origins, displacements, strict=True), verdicts, strict=True):
        samples = np.concatenate(list(sample_batches(manifold, motion, 0.1)))
        assert all(oracle.is_free(q) for q in samples) == verdict
        assert oracle.is_motion_free(*motion, 0.1) == verdict
