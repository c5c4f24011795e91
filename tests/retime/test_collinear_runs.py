"""However finely a path was cut, it is the same path."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planning.domain.curves.path import JointPath
from planning.domain.request.options import RetimeOptions
from planning.domain.robot.joints import JointType
from planning.domain.robot.manifold import Manifold
from planning.retime.blend import blend_corners
from planning.retime.collinear_runs import COLLINEAR_TOLERANCE, without_collinear_waypoints
from planning.retime.retimer import RETIMERS, retime
from tests.conftest import group_of, limits_of, random_waypoints
from tests.profiles import num_cases

GROUPS = {
    "joints": group_of(*[JointType.REVOLUTE] * 4),
    "circle": group_of(JointType.CONTINUOUS, JointType.REVOLUTE),
    "plane": group_of(JointType.PLANAR),
    "space": group_of(JointType.FLOATING),
}


def cut(path: JointPath, seed: int, most: int = 20) -> JointPath:
    """Return the path with up to so many waypoints more on each of its lines, some repeated."""
    manifold, rng = Manifold(path.group.joints), np.random.default_rng(seed)
    rows = [path.waypoints[:1]]
    for a, b in zip(path.waypoints[:-1], path.waypoints[1:], strict=True):
        fractions = np.sort(rng.uniform(0, 1, int(rng.integers(0, most))))
        fractions = np.repeat(fractions, rng.integers(1, 3, len(fractions)))
        rows += [manifold.interpolate(a, b, fractions), b[None]]
    return JointPath(path.group, np.concatenate(rows))


@pytest.mark.parametrize("method", sorted(RETIMERS))
@pytest.mark.parametrize("deviation", [0.0, 0.05])
@pytest.mark.parametrize("name", GROUPS)
@settings(max_examples=num_cases(2))
@given(seed=st.integers(0, 10_000))
def test_cutting_lines_changes_no_motion(
    name: str, deviation: float, method: str, seed: int
) -> None:
    group, retimer = GROUPS[name], RETIMERS[method]
    path = JointPath(group, random_waypoints(group, seed, 4))
    options = RetimeOptions("ruckig" if method == "ruckig" else "toppra")
    motions = [
        retime(blend_corners(some, deviation, retimer.smoothness), limits_of(group), options)[0]
        for some in (path, cut(path, seed))
    ]
    assert motions[1].duration == pytest.approx(motions[0].duration, rel=1e-9)
    times = np.linspace(0.0, motions[0].duration, 50)
    away = Manifold(group.joints).distance(motions[1].positions(times), motions[0].positions(times))
    assert away.max() < 1e-7


@given(seed=st.integers(0, 10_000))
def test_the_remaining_waypoints_are_the_same_polyline(seed: int) -> None:
    group = GROUPS["joints"]
    path = JointPath(group, random_waypoints(group, seed, 5))
    kept = without_collinear_waypoints(
        cut(path, seed).waypoints, Manifold(group.joints), COLLINEAR_TOLERANCE
    )
    np.testing.assert_allclose(kept, path.waypoints, atol=2 * COLLINEAR_TOLERANCE)


def test_turning_back_on_a_line_is_a_corner() -> None:
    manifold = Manifold(GROUPS["circle"].joints)
    waypoints = np.array([[0.0, 0.0], [0.5, 0.0], [0.3, 0.0], [0.4, 0.0], [1.0, 0.0]])
    kept = without_collinear_waypoints(waypoints, manifold, COLLINEAR_TOLERANCE)
    np.testing.assert_array_equal(kept, waypoints[[0, 1, 2, 4]])


def test_a_whole_turn_is_not_nothing() -> None:
    """Between waypoints joints turn by half a turn at most: longer runs stay in parts."""
    manifold = Manifold(GROUPS["circle"].joints)
    waypoints = np.stack([np.linspace(0.0, 7.0, 30), np.linspace(0.0, 1.0, 30)], axis=1)
    kept = without_collinear_waypoints(waypoints, manifold, COLLINEAR_TOLERANCE)
    steps = manifold.minus(kept[1:], kept[:-1])
    np.testing.assert_allclose(steps.sum(axis=0), [7.0, 1.0], atol=1e-12)
    assert len(kept) < 8


def test_a_gentle_curve_keeps_its_waypoints() -> None:
    manifold = Manifold(GROUPS["joints"].joints)
    angles = np.linspace(0.0, 0.01, 200)[:, None]
    waypoints = np.concatenate([np.sin(angles), np.cos(angles), angles, -angles], axis=1)
    away = without_collinear_waypoints(waypoints, manifold, COLLINEAR_TOLERANCE)
    coarse = without_collinear_waypoints(waypoints, manifold, 1e-6)
    assert len(away) > 150
    assert 2 < len(coarse) < 20
