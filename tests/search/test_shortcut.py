"""Shortcuts shorten, stay free, and keep the ends."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from planning.domain.joints import JointType
from planning.domain.manifold import Manifold
from planning.search.densify import densified
from planning.search.edges import EdgeChecker
from planning.search.oracle import WatchedOracle
from planning.search.shortcut import path_length, shortcut

DETOUR = np.array([
    [-0.8, -0.8],
    [-0.9, 0.0],
    [-0.5, 0.9],
    [-0.4, 0.7],
    [0.3, 0.95],
    [0.6, 0.2],
    [0.8, -0.8],
])


def never():
    return False


@pytest.fixture
def edges(plane, wall, soon):
    group, limits = plane
    watched = WatchedOracle(wall, group, limits, soon)
    return EdgeChecker(Manifold(group.joints), watched, 0.01)


@pytest.mark.parametrize("seed", range(10))
def test_the_path_gets_shorter_and_keeps_its_ends(edges, seed):
    shorter = shortcut(DETOUR, edges, np.random.default_rng(seed), never)
    assert np.array_equal(shorter[[0, -1]], DETOUR[[0, -1]])
    assert path_length(shorter, edges) < 0.9 * path_length(DETOUR, edges)
    # Around the wall's top there is no shorter way than this.
    corners = np.array([[-0.8, -0.8], [-0.1, 0.6], [0.1, 0.6], [0.8, -0.8]])
    assert path_length(shorter, edges) > path_length(corners, edges) - 0.05
    # What is left of an edge was checked elsewhere: it may graze the wall, but by less than a step.
    for q0, q1 in pairwise(shorter):
        along = edges.geodesic(q0, q1, np.linspace(0.0, 1.0, 1000))
        assert not ((np.abs(along[:, 0]) < 0.09) & (along[:, 1] < 0.59)).any()


def test_the_same_generator_gives_the_same_path(edges):
    a, b = (shortcut(DETOUR, edges, np.random.default_rng(3), never) for _ in range(2))
    assert a.tobytes() == b.tobytes()


def test_an_early_end_leaves_the_path_whole(edges):
    kept = shortcut(DETOUR, edges, np.random.default_rng(0), lambda: True)
    assert np.array_equal(kept, DETOUR)


@given(seed=st.integers(0, 10_000))
@settings(max_examples=6, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_never_longer_on_any_manifold(make_oracle, seed):
    import time

    from planning.domain.deadline import Deadline
    from planning.domain.joints import Joint, JointGroup, JointLimits

    kinds = (JointType.FLOATING, JointType.PLANAR, JointType.CONTINUOUS, JointType.REVOLUTE)
    group = JointGroup("r", tuple(Joint(f"r::{i}", k) for i, k in enumerate(kinds)), ())
    free, one = np.full(group.num_positions, np.inf), np.ones(len(group.blocks))
    blocks = tuple(indices for _, indices in group.blocks)
    limits = JointLimits(-free, free, one, one, one, one, blocks)
    rng = np.random.default_rng(seed)
    manifold = Manifold(group.joints)

    # Thin shells are blocked, so that some edges are free and some are not.
    sieve = make_oracle(lambda qs: np.sin(7 * qs.sum(axis=1) + seed) < 0.9, group)
    watched = WatchedOracle(sieve, group, limits, Deadline.after(10.0, time.perf_counter))
    edges = EdgeChecker(manifold, watched, 0.1)
    path = manifold.normalized(rng.uniform(-2, 2, (8, group.num_positions)))
    shorter = shortcut(path, edges, rng, never)
    assert path_length(shorter, edges) <= path_length(path, edges) + 1e-9
    assert np.array_equal(shorter[[0, -1]], path[[0, -1]])


@pytest.mark.parametrize("count", [2, 7, 8, 50, 333])
def test_more_waypoints_on_the_same_path(edges, count):
    dense = densified(edges, DETOUR, count)
    assert len(dense) >= count
    assert len(dense) <= max(count + len(DETOUR), len(DETOUR))
    assert path_length(dense, edges) == pytest.approx(path_length(DETOUR, edges))
    rows = {row.tobytes() for row in dense}
    assert all(corner.tobytes() in rows for corner in DETOUR)


def test_no_more_waypoints_than_needed_on_one_edge(edges):
    assert len(densified(edges, DETOUR[:2], 17)) == 17
