"""Shortcuts shorten, keep the ends, and deliver only edges that are free at the fine resolution."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from planning.domain.curves.motion_samples import sample_batches, steps_of
from planning.domain.robot.joints import JointType
from planning.domain.robot.manifold import Manifold
from planning.errors import DeadlineExceeded
from planning.search.collision_oracle import WatchedOracle
from planning.search.edges import EdgeChecker
from planning.search.shortcut.backtracking import backtrack
from planning.search.shortcut.corners import cut_corners
from planning.search.shortcut.polyline import length_by_norm, subdivide
from planning.search.shortcut.relax import relax
from planning.search.shortcut.resampling import resample
from planning.search.shortcut.shortcut_path import shortcut
from planning.search.shortcut.vertex_skipping import skip_vertices, tighten
from tests.clocks import after_looks, no_hurry
from tests.profiles import num_cases, rng_of, seeds

DETOUR = np.array([
    [-0.8, -0.8],
    [-0.9, 0.0],
    [-0.5, 0.9],
    [-0.4, 0.7],
    [0.3, 0.95],
    [0.6, 0.2],
    [0.8, -0.8],
])
# The shortest path around the wall's top.
TAUT = np.array([[-0.8, -0.8], [-0.1, 0.6], [0.1, 0.6], [0.8, -0.8]])

KINDS = {
    "arm": (JointType.REVOLUTE,) * 4,
    "mixed": (JointType.FLOATING, JointType.PLANAR, JointType.CONTINUOUS, JointType.REVOLUTE),
}
WITH_FIXTURES = settings(
    max_examples=num_cases(6), suppress_health_check=[HealthCheck.function_scoped_fixture]
)


def never():
    return False


@pytest.fixture
def watched(plane, wall, soon):
    return WatchedOracle(wall, *plane, soon)


@pytest.fixture
def checkers(plane, watched):
    """At the resolution of a search, and four times as fine."""
    manifold = Manifold(plane[0].joints)
    return EdgeChecker(manifold, watched, 0.04), EdgeChecker(manifold, watched, 0.01)


@pytest.fixture
def sieve(make_group, make_limits, make_oracle, soon):
    """Thin shells are blocked, so that some edges are free and some are not."""

    def make(kinds, seed):
        group = make_group(*kinds)
        oracle = make_oracle(lambda qs: np.sin(7 * qs.sum(axis=1) + seed) < 0.9, group)
        watched = WatchedOracle(oracle, group, make_limits(group, 100.0), soon)
        manifold = Manifold(group.joints)
        return EdgeChecker(manifold, watched, 0.2), EdgeChecker(manifold, watched, 0.05)

    return make


def is_sound(path, fine):
    """Whether every edge is free, looked at anew and one by one."""
    return all(fine.is_free(q0, q1) for q0, q1 in pairwise(path))


def free_walk(fine, rng, count):
    """A path of free edges, by going where it is free."""
    manifold = fine.manifold
    starts = manifold.normalized(rng.uniform(-1, 1, (20, manifold.num_positions)))
    rows = [next(q for q in starts if fine.is_free(q, q))]
    while len(rows) < count:
        near = manifold.plus(rows[-1], rng.normal(0, 0.08, manifold.num_velocities))
        if fine.is_free(rows[-1], near):
            rows.append(near)
    return np.array(rows)


def test_the_path_gets_shorter_and_keeps_its_ends(checkers):
    shorter = shortcut(DETOUR, *checkers, never)
    fine = checkers[1]
    assert shorter[[0, -1]].tobytes() == DETOUR[[0, -1]].tobytes()
    assert is_sound(shorter, fine)
    assert length_by_norm(TAUT, fine) - 0.01 < length_by_norm(shorter, fine)
    assert length_by_norm(shorter, fine) < 1.06 * length_by_norm(TAUT, fine)
    assert len(shorter) <= 6


def test_the_same_path_gives_the_same_path(checkers):
    a, b = (shortcut(DETOUR, *checkers, never) for _ in range(2))
    assert a.tobytes() == b.tobytes()


def test_an_early_end_leaves_the_path_whole(checkers):
    assert np.array_equal(shortcut(DETOUR, *checkers, lambda: True), DETOUR)


@pytest.mark.parametrize("kinds", KINDS)
@given(seed=st.integers(0, 10_000))
@WITH_FIXTURES
def test_never_longer_and_always_sound_on_any_manifold(sieve, kinds, seed):
    coarse, fine = sieve(KINDS[kinds], seed)
    path = free_walk(fine, np.random.default_rng(seed), 12)
    shorter = shortcut(path, coarse, fine, never)
    assert length_by_norm(shorter, fine) <= length_by_norm(path, fine) + 1e-9
    assert shorter[[0, -1]].tobytes() == path[[0, -1]].tobytes()
    assert is_sound(shorter, fine)


@pytest.mark.parametrize("kinds", KINDS)
@given(seed=st.integers(0, 10_000))
@settings(WITH_FIXTURES, max_examples=num_cases(4))
def test_every_stage_keeps_a_sound_path_sound_and_short(sieve, kinds, seed):
    coarse, fine = sieve(KINDS[kinds], seed)
    path = free_walk(fine, np.random.default_rng(seed), 8)
    bold = relax(path, coarse, never)
    assert bold.shape == path.shape
    if (bold != path).any():
        assert is_sound(bold, coarse)
    stages = {
        "skipped": skip_vertices(path, fine, never),
        "taut": tighten(path, fine),
        "relaxed": relax(path, fine, never),
        "cut": cut_corners(path, fine),
    }
    for new in stages.values():
        if new is not None:
            assert length_by_norm(new, fine) <= length_by_norm(path, fine) + 1e-9
            assert new[[0, -1]].tobytes() == path[[0, -1]].tobytes()
            assert is_sound(new, fine)
    assert is_sound(backtrack(bold, path, fine), fine)


@pytest.mark.campaign
def test_waypoints_move_only_where_both_edges_are_free(plane, make_oracle, soon):
    """Random free paths among balls: for some of them to see one neighbour is not enough."""
    manifold, tried = Manifold(plane[0].joints), 0
    for seed in seeds(100):
        rng = rng_of(seed)
        balls, radii = rng.uniform(-0.7, 0.7, (6, 2)), rng.uniform(0.05, 0.25, 6)

        def are_free(qs, balls=balls, radii=radii):
            return (np.linalg.norm(qs[:, None] - balls, axis=2) > radii).all(axis=1)

        fine = EdgeChecker(manifold, WatchedOracle(make_oracle(are_free), *plane, soon), 0.02)
        path = rng.uniform(-1, 1, (4, 2))
        if is_sound(path, fine):
            tried += 1
            bent = relax(path, fine, never)
            assert is_sound(bent, fine)
            assert length_by_norm(bent, fine) <= length_by_norm(path, fine) + 1e-9
    assert tried > 5


def test_an_edge_that_only_a_closer_look_finds_blocked_is_gone_around(plane, make_oracle, soon):
    """The edge from 1 to 2 hits a thin rod, that from 0 to 3 a ball; that from 1 to 3 is free."""

    def are_free(qs):
        is_in_rod = (np.abs(qs[:, 0] - 0.31) < 0.006) & (qs[:, 1] > 0.1)
        return ~is_in_rod & (np.linalg.norm(qs - [0.15, 0.0], axis=1) > 0.02)

    oracle = make_oracle(are_free)
    watched = WatchedOracle(oracle, *plane, soon)
    fine = EdgeChecker(Manifold(plane[0].joints), watched, 0.01)
    path = np.array([[-0.5, 0.5], [0.0, -0.5], [0.4, 0.5], [0.8, -0.5]])
    assert not fine.is_free(path[1], path[2])
    assert skip_vertices(path, fine, never).tolist() == path[[0, 1, 3]].tolist()
    assert skip_vertices(path[:3], fine, never) is None
    assert shortcut(path[:3], fine, fine, never) is None


def test_a_dead_end_is_left_again(plane, make_oracle, soon):
    """From the start 2 is the furthest in sight, but only 1 sees the end."""
    path = np.array([[-0.9, 0.0], [-0.5, -0.5], [0.0, 0.3], [0.5, -0.5]])
    blocks = np.array([[-0.2, -0.25], [0.25, -0.1]])

    def are_free(qs):
        return (np.linalg.norm(qs[:, None] - blocks, axis=2) > 0.12).all(axis=1)

    fine = EdgeChecker(
        Manifold(plane[0].joints), WatchedOracle(make_oracle(are_free), *plane, soon), 0.01
    )
    assert fine.is_free(path[0], path[2])
    assert not fine.is_free(path[2], path[3])
    assert skip_vertices(path, fine, never).tolist() == path[[0, 1, 3]].tolist()


def test_backtracking_moves_back_only_as_far_as_needed(checkers):
    fine = checkers[1]
    sound = np.array([[-0.8, -0.8], [-0.2, 0.9], [0.2, 0.9], [0.8, -0.8]])
    bold = np.array([[-0.8, -0.8], [-0.2, 0.58], [0.2, 0.58], [0.8, -0.8]])
    path = backtrack(bold, sound, fine)
    assert is_sound(path, fine)
    assert length_by_norm(path, fine) < 0.5 * (
        length_by_norm(sound, fine) + length_by_norm(bold, fine)
    )
    moved = np.add(TAUT, [0, 0.05])
    assert np.array_equal(backtrack(moved, moved, fine), moved)


def test_at_every_deadline_the_path_so_far_is_free(plane, wall):
    """By a clock that shows more at every look: the more it is looked at the shorter the path."""
    manifold, lengths = Manifold(plane[0].joints), []
    for looks in (3, 8, 12, 20, 40, 80, 10_000):
        watched = WatchedOracle(wall, *plane, after_looks(looks))
        coarse, fine = (EdgeChecker(manifold, watched, step) for step in (0.04, 0.01))
        try:
            path = shortcut(DETOUR, coarse, fine, never)
        except DeadlineExceeded:
            lengths.append(np.inf)
            continue
        with watched.with_deadline(no_hurry()):
            assert is_sound(path, fine)
        assert path[[0, -1]].tobytes() == DETOUR[[0, -1]].tobytes()
        lengths.append(length_by_norm(path, fine))
    assert lengths == sorted(lengths, reverse=True)
    assert lengths[0] == np.inf
    assert len(set(lengths)) > 4


@pytest.mark.parametrize("kinds", KINDS)
@given(seed=st.integers(0, 10_000), pieces=st.integers(1, 6))
@WITH_FIXTURES
def test_parts_of_an_edge_have_the_same_samples(sieve, kinds, seed, pieces):
    _, fine = sieve(KINDS[kinds], seed)
    manifold = fine.manifold
    q0, q1 = manifold.normalized(
        np.random.default_rng(seed).uniform(-1, 1, (2, manifold.num_positions))
    )
    points = subdivide(np.stack([q0, q1]), fine, pieces)
    assert np.array_equal(points.qs[[0, -1]], [q0, q1])
    delta = manifold.minus(points.qs[1:], points.qs[:-1])
    whole = manifold.minus(q1, q0)
    assert steps_of(delta, fine.resolution).sum() == steps_of(whole[None], fine.resolution).sum()
    samples = np.concatenate(list(sample_batches(manifold, (q0, whole), fine.resolution)))
    for start, step in zip(points.qs[:-1], delta, strict=True):
        for qs in sample_batches(manifold, (start, step), fine.resolution):
            gaps = manifold.distance(qs[:, None], samples[None]).min(axis=1)
            assert gaps.max() < 1e-7


def test_points_know_their_edges(checkers):
    points = subdivide(DETOUR, checkers[1], 3)
    assert len(points.qs) == 19
    for way in (points, points.in_reverse):
        assert [way.last_on_edge_of(i) for i in (0, 1, 2, 3, 15, 17)] == [3, 3, 3, 6, 18, 18]
        assert all(way.first_edge[way.last_on_edge_of(i)] <= way.last_edge[i] for i in range(18))
    assert np.array_equal(points.in_reverse.qs[-1], DETOUR[0])


@pytest.mark.parametrize("count", [2, 7, 8, 50, 333])
def test_more_waypoints_on_the_same_path(checkers, count):
    edges = checkers[1]
    dense = resample(edges, DETOUR, count)
    assert len(dense) >= count
    assert len(dense) <= max(count + len(DETOUR), len(DETOUR))
    assert length_by_norm(dense, edges) == pytest.approx(length_by_norm(DETOUR, edges))
    rows = {row.tobytes() for row in dense}
    assert all(corner.tobytes() in rows for corner in DETOUR)


def test_no_more_waypoints_than_needed_on_one_edge(checkers):
    assert len(resample(checkers[1], DETOUR[:2], 17)) == 17
