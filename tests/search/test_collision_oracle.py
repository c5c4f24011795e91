"""The watched oracle counts states, checks long motions in batches, and keeps limits of angles."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from planning.domain.curves.motion_samples import sample_batches, steps_of
from planning.domain.request.deadline import Deadline
from planning.domain.robot.joints import JointType
from planning.domain.robot.manifold import Manifold
from planning.errors import DeadlineExceeded
from planning.search.collision_oracle import CollisionOracle, WatchedOracle


def stripes(qs):
    return np.sin(5 * qs.sum(axis=1)) < 0.9


@given(seed=st.integers(0, 10_000), resolution=st.sampled_from([0.3, 0.02, 1e-4]))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_motions_are_judged_by_their_samples(
    make_group, make_limits, make_oracle, soon, seed, resolution
):
    """One by one or many, in pieces or whole, with a forbidden arc or without."""
    group = make_group(JointType.CONTINUOUS, JointType.PRISMATIC)
    limits = make_limits(group)
    arc = np.array([2.5, 1.0])
    bounded = type(limits)(-arc, arc, *[limits.velocity] * 4, limits.blocks)
    rng = np.random.default_rng(seed)
    origins, displacements = rng.uniform(-1.0, 1.0, (2, 9, 2)) * np.array([2.5, 0.8])
    manifold = Manifold(group.joints)
    for given_limits, has_arc in ((limits, False), (bounded, True)):
        oracle = make_oracle(stripes, group)
        one, many = (WatchedOracle(oracle, group, given_limits, soon) for _ in range(2))
        verdicts = many.are_motions_free(origins, displacements, resolution)
        for k, (origin, displacement) in enumerate(zip(origins, displacements, strict=True)):
            motion = origin, displacement
            samples = np.concatenate(list(sample_batches(manifold, motion, resolution)))
            expected = stripes(samples).all()
            if has_arc:
                turned = np.remainder(samples[:, 0] + np.pi, 2 * np.pi) - np.pi
                expected &= (np.abs(turned) <= 2.5 + 1e-9).all()
            assert verdicts[k] == expected
            assert one.is_motion_free(origin, displacement, resolution) == expected
        assert many.num_states == one.num_states == steps_of(displacements, resolution).sum()


def test_a_late_answer_ends_the_search_between_pieces(plane, make_oracle):
    now = [0.0]

    def slow(qs):
        now[0] += 1e-3 * len(qs)
        return np.ones(len(qs), dtype=bool)

    oracle = make_oracle(slow)
    watched = WatchedOracle(oracle, *plane, Deadline.after(1.0, lambda: now[0]))
    motions = np.zeros((1000, 2)), np.full((1000, 2), 0.1)
    with pytest.raises(DeadlineExceeded):
        watched.are_motions_free(*motions, 0.001)
    # 142 samples each: 142 s in all. A piece is begun before the second is over.
    assert now[0] < 10.0


def test_oracles_of_tests_keep_the_protocol(wall):
    assert isinstance(wall, CollisionOracle)
