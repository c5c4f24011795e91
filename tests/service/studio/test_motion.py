"""Motions between their keyframes, the colours of traces, and texts that are no markup."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from service.studio import texts
from service.studio.motion import Motion, clearance_colors


def motion(num=5):
    rng = np.random.default_rng(5)
    quaternions = rng.normal(size=(num, 4))
    quaternions /= np.linalg.norm(quaternions, axis=1, keepdims=True)
    poses = np.hstack([rng.uniform(-1, 1, (num, 3)), quaternions])
    times = np.cumsum(rng.uniform(0.1, 1.0, num))
    nothing = np.zeros((num, 1))
    return Motion("p", times - times[0], nothing, nothing, {"a": poses}, None, {}, ["j"])


def test_at_its_keyframes_it_is_where_they_are():
    shown = motion()
    for time, pose in zip(shown.times, shown.poses["a"], strict=True):
        found = shown.at(time)["a"]
        np.testing.assert_allclose(found[:3], pose[:3], atol=1e-12)
        assert abs(abs(found[3:] @ pose[3:]) - 1) < 1e-9  # q and -q are one rotation


@given(st.floats(-1.0, 10.0))
def test_between_them_it_moves_on_a_line_with_unit_quaternions(time):
    shown = motion()
    found = shown.at(time)["a"]
    assert abs(np.linalg.norm(found[3:]) - 1) < 1e-9
    lower, upper = shown.poses["a"][:, :3].min(axis=0), shown.poses["a"][:, :3].max(axis=0)
    assert np.all(found[:3] >= lower - 1e-12)
    assert np.all(found[:3] <= upper + 1e-12)


def test_it_turns_the_short_way():
    poses = np.array([[0, 0, 0, 1, 0, 0, 0], [0, 0, 0, -1, 0, 0, 0.0]])  # one rotation, two signs
    nothing = np.zeros((2, 1))
    same = Motion("p", np.array([0.0, 1.0]), nothing, nothing, {"a": poses}, None, {}, ["j"])
    np.testing.assert_allclose(np.abs(same.at(0.5)["a"][3:]), [1, 0, 0, 0], atol=1e-12)


def test_a_touch_is_red_what_is_far_is_green_and_nothing_to_hit_too():
    red, far, nothing = clearance_colors(np.array([-0.01, 0.2, np.inf]))
    assert red[0] > 2 * red[1]
    np.testing.assert_array_equal(far, nothing)
    assert far[1] > far[0]


def test_what_a_server_says_is_no_markup():
    evil = "<img src=x onerror=alert(1)>"
    check = {"name": evil, "passed": False, "value": 1.0, "bound": 2.0, "unit": evil}
    certificate = {"proven": True, "min_clearance": 0.1, "pair": [evil, evil], "checks": [check]}
    pair = {"bodies": [evil, evil], "depth": 0.1}
    said = [texts.told(evil), texts.failure(evil, evil), texts.pairs([pair])]
    for text in (*said, texts.verdict(certificate, 1.0)):
        assert "<img" not in text
        assert "&lt;img" in text
