"""Where the replay's camera stands."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from planning.domain.geometry.pose import Pose
from planning.world.replay.camera import SolidBox, WatchedPoint, num_visible, place_camera
from tests.profiles import num_cases

CLOUD = np.random.default_rng(3).uniform(-0.5, 0.5, (40, 3))


def wall(x: float) -> SolidBox:
    """Return a large wall across the x axis."""
    pose = Pose.from_parts((x, 0, 0)).matrix
    return SolidBox(pose, np.array([0.02, 5.0, 5.0]))


def test_with_nothing_in_the_way_it_looks_from_the_front_and_sees_all() -> None:
    camera, target = place_camera(CLOUD, [])
    assert camera[0] > target[0]
    assert num_visible(camera, CLOUD, []) == len(CLOUD)
    above, target = place_camera(CLOUD, [], from_above=True)
    assert above[2] - target[2] > 3 * abs(above[0] - target[0])


def test_it_goes_around_a_wall() -> None:
    camera, _ = place_camera(CLOUD, [wall(0.6)])
    assert camera[0] < 0.6
    assert num_visible(camera, CLOUD, [wall(0.6)]) == len(CLOUD)
    behind, _ = place_camera(CLOUD, [wall(-0.6)])
    assert behind[0] > -0.6


def test_what_is_watched_is_seen_before_all_else_and_from_within_its_own_box() -> None:
    tool = np.array([0.0, 0.0, 0.4])
    free, _ = place_camera(CLOUD, [])
    lid = SolidBox(Pose.from_parts((0.1, 0.0, 0.45)).matrix, np.array([0.02, 0.3, 0.3]))
    assert num_visible(free, tool[None], [lid]) == 0
    # no wall for the others, so that they alone would leave the camera where it is
    camera, _ = place_camera(CLOUD, [], [WatchedPoint(tool, [lid])])
    assert num_visible(camera, tool[None], [lid]) == 1
    around = SolidBox(Pose.from_parts((0.0, 0.0, 0.4)).matrix, np.array([0.1, 0.1, 0.1]))
    np.testing.assert_array_equal(place_camera(CLOUD, [], [WatchedPoint(tool, [around])])[0], free)


def test_what_is_behind_the_camera_or_its_point_hides_nothing() -> None:
    camera, point = np.zeros(3), np.array([[1.0, 0.1, 0.1]])
    assert num_visible(camera, point, [wall(-0.5), wall(1.1)]) == 1
    assert num_visible(camera, point, [wall(0.5)]) == 0


@settings(max_examples=num_cases(6))
@given(st.integers(0, 10_000))
def test_a_point_is_hidden_where_its_sight_line_has_a_point_in_the_box(seed: int) -> None:
    rng = np.random.default_rng(seed)
    pose = Pose.from_parts(rng.uniform(-1, 1, 3), rpy=rng.uniform(-3, 3, 3))
    box = SolidBox(pose.matrix, rng.uniform(0.1, 0.8, 3))
    camera, point = rng.uniform(-2, 2, 3), rng.uniform(-2, 2, 3)
    # the sight line ends 3 % short of its point
    line = camera + np.linspace(0, 0.97, 4001)[:, None] * (point - camera)
    local = np.abs((line - box.pose[:3, 3]) @ box.pose[:3, :3])
    excess = float(np.min(np.max(local - box.half_width, axis=1)))
    if abs(excess) > 0.002:  # sampling decides only what is not a near miss
        assert num_visible(camera, point[None], [box]) == int(excess > 0)
