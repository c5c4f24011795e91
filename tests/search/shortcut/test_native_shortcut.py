"""The kernel shortens paths as numpy does: the same waypoints after as many checks, bit by bit."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planning.domain.arrays import Array
from planning.domain.robot.joints import JointGroup, JointType
from planning.domain.robot.manifold import Manifold
from planning.errors import DeadlineExceeded
from planning.kernel.native import native
from planning.search.collision_oracle import CollisionOracle, WatchedOracle
from planning.search.edges import EdgeChecker
from planning.search.shortcut.backtracking import backtrack, backtrack_in_numpy
from planning.search.shortcut.corners import cut_corners, cut_corners_in_numpy
from planning.search.shortcut.relax import relax, relax_in_numpy
from planning.search.shortcut.vertex_skipping import (
    skip_vertices,
    skip_vertices_in_numpy,
    tighten,
    tighten_in_numpy,
)
from tests.clocks import after_looks, no_hurry
from tests.conftest import bundled_world
from tests.profiles import num_cases, rng_of
from tests.search.conftest import Oracle, group_of, limits_of

pytestmark = pytest.mark.skipif(native() is None, reason="the native kernel is not built")

RESOLUTION = 0.05
# Sums of the two may be rounded differently where numpy adds in other lanes than on x86-64.
ROUNDING = 1e-12

type Step = Callable[[Array, EdgeChecker], Array | None]


def never() -> bool:
    return False


# The kernel's function and numpy's; `backtrack` goes back from a path that is shifted.
PAIRS: dict[str, tuple[Step, Step]] = {
    "skip": (
        lambda path, edges: skip_vertices(path, edges, never),
        lambda path, edges: skip_vertices_in_numpy(path, edges, never),
    ),
    "tighten": (tighten, tighten_in_numpy),
    "relax": (
        lambda path, edges: relax(path, edges, never),
        lambda path, edges: relax_in_numpy(path, edges, never),
    ),
    "backtrack": (
        lambda path, edges: backtrack(shifted(path), path, edges),
        lambda path, edges: backtrack_in_numpy(shifted(path), path, edges),
    ),
    "cut": (cut_corners, cut_corners_in_numpy),
}


def shifted(path: Array) -> Array:
    """Return a path whose inner waypoints, but for every third, are nearer to its middle."""
    moved = path.copy()
    inner = np.arange(1, len(path) - 1)
    inner = inner[inner % 3 > 0]
    moved[inner] += 0.6 * (path.mean(axis=0) - path[inner])
    return moved


def edges_of(group: JointGroup, oracle: CollisionOracle) -> EdgeChecker:
    limits = limits_of(group, 10.0)
    watched = WatchedOracle(oracle, group, limits, no_hurry())
    return EdgeChecker(Manifold.of(group.joints), watched, RESOLUTION)


def free_path(edges: EdgeChecker, waypoints: Array) -> Array:
    """Return the waypoints up to the first blocked edge."""
    free = edges.are_free(waypoints[:-1], waypoints[1:])
    return waypoints[: len(free) if free.all() else int(np.argmin(free)) + 1]


def assert_same(name: str, path: Array, make: Callable[[], EdgeChecker]) -> None:
    """Check that both functions find the same, after the same number of checks."""
    found, counts = list[Array | None](), list[tuple[int, int]]()
    for function in PAIRS[name]:
        edges = make()
        found.append(function(path, edges))
        counts.append((edges.num_motions, edges._oracle.num_states))
    assert counts[0] == counts[1]
    assert (found[0] is None) == (found[1] is None)
    if found[0] is not None and found[1] is not None:
        assert found[0].shape == found[1].shape
        np.testing.assert_allclose(found[0], found[1], rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("name", PAIRS)
@settings(max_examples=num_cases(40))
@given(
    seed=st.integers(0, 2**32 - 1),
    num_joints=st.integers(1, 9),
    num_waypoints=st.integers(2, 14),
    radius=st.sampled_from([0.0, 0.3, 0.8]),
)
def test_the_path_is_the_one_of_numpy(
    name: str, seed: int, num_joints: int, num_waypoints: int, radius: float
) -> None:
    rng = np.random.default_rng(seed)
    path = np.cumsum(rng.normal(0, 0.5, (num_waypoints, num_joints)), axis=0)
    centre = path.mean(axis=0) + rng.normal(0, 0.2, num_joints)
    group = group_of(*[JointType.REVOLUTE] * num_joints)

    def make() -> EdgeChecker:
        return edges_of(group, Oracle(lambda qs: np.linalg.norm(qs - centre, axis=1) > radius))

    if name != "skip":  # the others begin with a path that is free
        path = free_path(make(), path)
    if len(path) > 1:
        assert_same(name, path, make)


@pytest.mark.parametrize("name", PAIRS)
@pytest.mark.parametrize("scene", ["panda_shelf", "ur5e_pickup"])
def test_so_it_is_with_the_kernels_own_verdicts(name: str, scene: str) -> None:
    world = bundled_world(scene)
    group = world.groups[0]
    limits, oracle = world.limits(group), world.collision_oracle(group, world.margins(0.01))
    rng = rng_of(5)
    manifold = Manifold.of(group.joints)
    num_paths = 0
    while num_paths < num_cases(12):
        ends = rng.uniform(limits.lower, limits.upper, (2, len(limits.lower)))
        path = ends[0] + np.linspace(0, 1, 9)[:, None] * (ends[1] - ends[0])
        path[1:-1] += rng.normal(0, 0.15, path[1:-1].shape)

        def make() -> EdgeChecker:
            watched = WatchedOracle(oracle, group, limits, no_hurry())
            return EdgeChecker(manifold, watched, RESOLUTION)

        assert make()._oracle.native_checker is not None
        if name != "skip":
            path = free_path(make(), path)
        if len(path) > 2:
            num_paths += 1
            assert_same(name, path, make)


def test_the_end_of_the_time_comes_through_and_the_checks_before_it_count() -> None:
    world = bundled_world("panda_shelf")
    group = world.groups[0]
    limits, oracle = world.limits(group), world.collision_oracle(group, world.margins())
    path = world.positions(group) + 0.01 * np.arange(200)[:, None]
    watched = WatchedOracle(oracle, group, limits, after_looks(2))
    edges = EdgeChecker(Manifold.of(group.joints), watched, RESOLUTION)

    def shorten() -> None:
        for _ in range(5):
            skip_vertices(path[::-1], edges, never)

    with pytest.raises(DeadlineExceeded):
        shorten()
    assert edges.num_motions > 0
    assert watched.num_states > 0
