"""The kernel relaxes paths as numpy does: the same waypoints after the same checks."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planning.domain.robot.joints import JointType
from planning.domain.robot.manifold import Manifold
from planning.kernel.native import native
from planning.search.collision_oracle import WatchedOracle
from planning.search.edges import EdgeChecker
from planning.search.shortcut.polyline import path_length
from planning.search.shortcut.relax import relax, relax_in_numpy
from tests.clocks import no_hurry
from tests.profiles import num_cases
from tests.search.conftest import Oracle, group_of, limits_of

pytestmark = pytest.mark.skipif(native() is None, reason="the native kernel is not built")

# Sums of the two may be rounded differently where numpy adds in other lanes than on x86-64.
ROUNDING = 1e-12


def checker(num_joints: int, centre: np.ndarray, radius: float) -> tuple[EdgeChecker, Oracle]:
    """Return a checker of edges around a ball in joint space, and its oracle."""
    group = group_of(*[JointType.REVOLUTE] * num_joints)
    oracle = Oracle(lambda qs: np.linalg.norm(qs - centre, axis=1) > radius, group)
    watched = WatchedOracle(oracle, group, limits_of(group, 10.0), no_hurry())
    return EdgeChecker(Manifold.of(group.joints), watched, 0.05), oracle


@settings(max_examples=num_cases(60))
@given(
    seed=st.integers(0, 2**32 - 1),
    num_joints=st.integers(1, 9),
    num_waypoints=st.integers(2, 14),
    radius=st.sampled_from([0.0, 0.3, 0.8]),
)
def test_the_path_is_the_one_of_numpy(
    seed: int, num_joints: int, num_waypoints: int, radius: float
) -> None:
    rng = np.random.default_rng(seed)
    path = np.cumsum(rng.normal(0, 0.5, (num_waypoints, num_joints)), axis=0)
    centre = path.mean(axis=0) + rng.normal(0, 0.2, num_joints)
    found, asked, counts = [], [], []
    for function in (relax, relax_in_numpy):
        edges, oracle = checker(num_joints, centre, radius)
        found.append(function(path, edges, lambda: False))
        asked.append(np.concatenate([np.empty((0, num_joints)), *oracle.asked]))
        counts.append(edges.num_motions)
    assert counts[0] == counts[1]
    assert asked[0].shape == asked[1].shape
    np.testing.assert_allclose(asked[0], asked[1], rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(found[0], found[1], rtol=0, atol=ROUNDING)


def test_the_path_becomes_shorter_and_its_ends_stay() -> None:
    path = np.array([[-1.0, 0.0], [-0.6, 0.9], [0.1, 1.2], [0.7, 0.8], [1.0, 0.0]])
    edges, _ = checker(2, np.zeros(2), 0.5)
    assert edges.is_euclidean
    shorter = relax(path, edges, lambda: False)
    assert path_length(shorter, edges.manifold) < 0.95 * path_length(path, edges.manifold)
    assert shorter[[0, -1]].tolist() == path[[0, -1]].tolist()
    assert edges.are_free(shorter[:-1], shorter[1:]).all()


def test_no_time_leaves_the_path_as_it_is() -> None:
    path = np.array([[-1.0, 0.0], [0.0, 1.2], [1.0, 0.0]])
    edges, oracle = checker(2, np.zeros(2), 0.5)
    assert relax(path, edges, lambda: True).tolist() == path.tolist()
    assert not oracle.asked


def test_joints_that_wrap_are_left_to_numpy() -> None:
    group = group_of(JointType.CONTINUOUS, JointType.REVOLUTE)
    watched = WatchedOracle(
        Oracle(lambda qs: np.ones(len(qs), dtype=bool), group), group, limits_of(group), no_hurry()
    )
    assert not EdgeChecker(Manifold.of(group.joints), watched, 0.05).is_euclidean
