"""Edges are sampled on the geodesic, finely enough, collisions first."""

import numpy as np
import pytest

from planning.domain.robot.joints import JointType
from planning.domain.robot.manifold import Manifold
from planning.errors import Canceled
from planning.search.collision_oracle import WatchedOracle
from planning.search.edges import EdgeChecker
from tests.clocks import no_hurry


def checker(group, limits, oracle, resolution, deadline):
    watched = WatchedOracle(oracle, group, limits, deadline)
    return EdgeChecker(Manifold(group.joints), watched, resolution), watched


def test_samples_lie_on_the_geodesic_at_most_the_resolution_apart(
    make_group, make_limits, make_oracle, soon
):
    group = make_group(JointType.FLOATING, JointType.CONTINUOUS, JointType.REVOLUTE)
    oracle = make_oracle(lambda qs: np.ones(len(qs), dtype=bool), group)
    edges, watched = checker(group, make_limits(group), oracle, 0.05, soon)
    rng = np.random.default_rng(0)
    q0, q1 = edges.manifold.normalized(rng.uniform(-1, 1, (2, 9)))
    assert edges.is_free(q0, q1)
    seen = np.concatenate(oracle.asked)
    assert watched.num_states == len(seen)
    distances = edges.manifold.distance(seen, q0)
    order = np.argsort(distances)
    path = np.concatenate([q0[None], seen[order]])
    gaps = edges.manifold.distance(path[1:], path[:-1])
    assert gaps.max() <= 0.05 + 1e-9
    assert gaps.sum() == pytest.approx(edges.manifold.distance(q1, q0))


def test_a_wall_wider_than_the_resolution_blocks_wherever_it_stands(plane, make_oracle, soon):
    rng = np.random.default_rng(1)
    for x in rng.uniform(0.0, 1.0, 50):
        oracle = make_oracle(lambda qs, x=x: np.abs(qs[:, 0] - x) > 0.006)
        edges, _ = checker(*plane, oracle, 0.01, soon)
        assert not edges.is_free(np.array([-0.3, 0.0]), np.array([1.3, 0.1]))


def test_a_blocked_middle_costs_two_checks(plane, make_oracle, soon):
    oracle = make_oracle(lambda qs: np.abs(qs[:, 0]) > 0.05)
    edges, watched = checker(*plane, oracle, 0.001, soon)
    assert not edges.is_free(np.array([-0.5, 0.0]), np.array([0.5, 0.0]))
    assert sum(map(len, oracle.asked)) == 2
    assert watched.num_states == 1000


def test_a_forbidden_arc_of_a_circle_blocks(make_group, make_limits, make_oracle, soon):
    group = make_group(JointType.CONTINUOUS)
    limits = make_limits(group)
    limits = type(limits)(np.array([-2.0]), np.array([2.0]), *[limits.velocity] * 4, limits.blocks)
    oracle = make_oracle(lambda qs: np.ones(len(qs), dtype=bool))
    edges, _ = checker(group, limits, oracle, 0.05, soon)
    assert edges.is_free(np.array([-1.9]), np.array([1.0]))
    assert edges.is_free(np.array([-1.9 + 2 * np.pi]), np.array([1.0]))
    # The shortest path from -1.9 to 1.9 leads through pi.
    assert not edges.is_free(np.array([-1.9]), np.array([1.9]))


def test_a_cancel_ends_a_long_edge(plane, make_oracle):
    asked = []

    def are_free(qs):
        asked.append(len(qs))
        return np.ones(len(qs), dtype=bool)

    deadline = no_hurry(60.0, lambda: len(asked) > 3)
    edges, _ = checker(*plane, make_oracle(are_free), 1e-5, deadline)
    with pytest.raises(Canceled):
        edges.is_free(np.array([-1.0, 0.0]), np.array([1.0, 0.0]))
    assert sum(asked) < 1000
