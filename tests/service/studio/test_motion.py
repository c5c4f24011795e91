"""Motions between their keyframes, the colours of traces, and texts that are no markup."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.studio import texts
from service.studio.motions.checks import words_of
from service.studio.motions.motion import Motion
from service.studio.motions.nearness import Nearness
from service.studio.motions.plot import with_cursor
from service.studio.motions.series import Bounds, Series, SeriesAnswer
from service.studio.motions.trace import BY_LIMIT, clearance_colors, legend, limit_colors
from service.studio.motions.verdict import Proof, verdict_of
from service.studio.plans.failure_words import failed


def series(**utilisation):
    """Of one joint at 0, 1 and 2 seconds."""
    rows = [[0.0], [1.0], [2.0]]
    kinds = ("positions", "velocities", "accelerations", "jerks", "torques")
    answer = SeriesAnswer(
        times=[0.0, 1.0, 2.0],
        position_names=["arm::j"],
        velocity_names=["arm::j"],
        **dict.fromkeys(kinds, rows),
        limits={"velocity": Bounds(lower=[-2.0], upper=[2.0])},
        tool_speeds={"arm::tcp": [0.0, 1.0, 0.0]},
        utilisation=utilisation or {"velocity": [0.0, 1.0, 0.5], "torque": [2.0, 2.0, 2.0]},
    )
    return Series(answer)


def motion(num=5):
    rng = np.random.default_rng(5)
    quaternions = rng.normal(size=(num, 4))
    quaternions /= np.linalg.norm(quaternions, axis=1, keepdims=True)
    poses = np.hstack([rng.uniform(-1, 1, (num, 3)), quaternions])
    times = np.cumsum(rng.uniform(0.1, 1.0, num))
    nothing = np.zeros((num, 1))
    return Motion("p", times - times[0], nothing, {"a": poses}, None, {}, series())


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
    same = Motion("p", np.array([0.0, 1.0]), nothing, {"a": poses}, None, {}, series())
    np.testing.assert_allclose(np.abs(same.at(0.5)["a"][3:]), [1, 0, 0, 0], atol=1e-12)


def test_a_touch_is_red_what_is_far_is_green_and_nothing_to_hit_too():
    red, far, nothing = clearance_colors(np.array([-0.01, 0.2, np.inf]))
    assert red[0] > 2 * red[1]
    np.testing.assert_array_equal(far, nothing)
    assert far[1] > far[0]


def test_what_a_server_says_is_no_markup():
    evil = "<img src=x onerror=alert(1)>"
    certificate = {"proven": True, "min_clearance": 0.1, "pair": [evil, evil]}
    proof = Proof(certificate, 1.0, revision=1, has_margin=False)
    pair = {"bodies": [evil, evil], "depth": 0.1}
    said = [texts.told(evil), failed(evil, evil), texts.pairs([pair])]
    for text in (
        *said,
        verdict_of(proof, 1),
        legend(series(**{evil: [1.0, 1.0, 1.0]}), BY_LIMIT),
    ):
        assert "<img" not in text
        assert "&lt;img" in text


@given(st.floats(0.0, 2.0))
def test_the_cursor_of_a_plot_is_at_its_time_and_bends_no_curve(time):
    times, rows = np.array([0.0, 1.0, 2.0]), np.array([[0.0], [3.0], [-1.0]])
    shown, curve, line = with_cursor(times, rows, time)
    assert np.all(np.diff(shown) >= 0)
    assert shown[np.argmax(line)] == time
    assert line.max() == 1
    assert np.count_nonzero(line) == 1
    expected = np.interp(shown, times, rows[:, 0])
    np.testing.assert_allclose(curve, expected, atol=1e-12)


def verdict(distance, a="x::a", b="b"):
    points = [[0, 0, 0], [distance, 0, 0]]
    return {"nearest": {"bodies": [a, b], "distance": distance, "points": points}}


def test_nearest_points_move_with_their_pair_and_jump_with_another():
    looks = Nearness(np.array([0.0, 1.0, 2.0]), [verdict(0.1), verdict(0.3), verdict(0.2, b="c")])
    assert looks.at(0.5).distance == pytest.approx(0.2)
    np.testing.assert_allclose(looks.at(0.5).points[1], [0.2, 0, 0])
    assert looks.at(1.4).bodies == ("x::a", "b")
    assert looks.at(1.6).bodies == ("x::a", "c")
    assert looks.at(5.0).distance == pytest.approx(0.2)
    assert Nearness(np.array([0.0, 1.0]), [{"nearest": None}] * 2).at(0.5) is None


def test_the_limit_that_binds_gives_its_colour_and_torque_that_is_not_limited_does_not():
    binds = series(velocity=[1.0, 0.2, 0.2], acceleration=[0.5, 1.0, 0.3], torque=[3.0, 3.0, 3.0])
    which, share = binds.binding()
    assert [binds.limit_names[i] for i in which[:2]] == ["velocity", "acceleration"]
    assert which[2] == -1
    np.testing.assert_allclose(share, [1.0, 1.0, 0.3])
    colors = limit_colors(binds, np.array([0.0, 1.0, 2.0]))
    assert len({tuple(color) for color in colors}) == 3
    assert "velocity 33%" in legend(binds, BY_LIMIT)


def test_a_check_says_how_much_when_and_which_curve_shows_it():
    check = {"name": "acceleration", "value": 0.913, "bound": 1.0, "unit": "1", "passed": True}
    words = words_of({**check, "where": "arm::wrist", "time": 0.512})
    assert (words.value, words.curve) == ("91 % at 0.51 s", "acceleration")
    assert "wrist" in words.hint
    near = {"name": "clearance", "value": -0.002, "bound": 0.0, "unit": "m", "passed": False}
    words = words_of({**near, "where": "arm::hand-can", "time": 1.0})
    assert (words.name, words.value) == ("✗ failed: clearance", "-2.0 mm at 1.00 s")
