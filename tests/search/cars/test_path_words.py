"""Dubins and Reeds-Shepp words: OMPL's lengths, known cases, and geodesic properties."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from ompl import base as ob

from planning.search.cars.dubins import dubins_words
from planning.search.cars.path_words import end_poses
from planning.search.cars.reeds_shepp import reeds_shepp_words

PI = np.pi
SHIFT = 2 * np.arctan2(2.0, np.sqrt(96.0)) + np.sqrt(96.0)
BOTH = [dubins_words, reeds_shepp_words]
goals = st.tuples(
    st.one_of(st.floats(-8, 8), st.integers(-4, 4)),
    st.one_of(st.floats(-8, 8), st.integers(-4, 4)),
    st.one_of(st.floats(-4, 4), st.sampled_from([0.0, PI / 2, -PI / 2, PI])),
)


def lengths_of(words, rows):
    return np.abs(words(np.array(rows, dtype=float)).lengths).sum(axis=1)


def space_of(kind):
    space, bounds = kind(1.0), ob.RealVectorBounds(2)
    bounds.setLow(-100)
    bounds.setHigh(100)
    space.setBounds(bounds)
    space.setup()
    return space


def theirs(space, rows):
    """OMPL's lengths of the shortest curves from zero to each row."""
    here, there = space.allocState(), space.allocState()
    space.copyFromReals(here, [0.0, 0.0, 0.0])
    found = []
    for x, y, yaw in rows:
        space.copyFromReals(there, [x, y, np.remainder(yaw + PI, 2 * PI) - PI])
        found.append(space.distance(here, there))
    return np.array(found)


@pytest.mark.parametrize(
    ("words", "kind"),
    [(dubins_words, ob.DubinsStateSpace), (reeds_shepp_words, ob.ReedsSheppStateSpace)],
    ids=["dubins", "reeds_shepp"],
)
@pytest.mark.parametrize("scale", [0.1, 1.0, 4.0, 30.0])
def test_lengths_are_those_of_ompl(words, kind, scale):
    rng = np.random.default_rng(int(scale * 10))
    rows = rng.uniform([-scale, -scale, -PI], [scale, scale, PI], (400, 3))
    assert np.abs(lengths_of(words, rows) - theirs(space_of(kind), rows)).max() < 1e-9


@pytest.mark.parametrize("words", BOTH)
@given(goal=goals)
def test_every_word_ends_at_its_goal(words, goal):
    word = words(np.array([goal], dtype=float))
    x, y, yaw = end_poses(word.lengths, word.turns)
    assert np.hypot(x - goal[0], y - goal[1])[0] < 1e-7
    assert abs(np.exp(1j * yaw[0]) - np.exp(1j * goal[2])) < 1e-7
    assert set(np.unique(word.turns)) <= {-1.0, 0.0, 1.0}
    if words is dubins_words:
        assert (word.lengths >= 0).all()


@pytest.mark.parametrize(
    ("goal", "dubins", "reeds_shepp"),
    [
        ((3.0, 0.0, 0.0), 3.0, 3.0),  # straight ahead
        ((0.0, 2.0, PI), PI, PI),  # half a turn
        ((1.0, 1.0, PI / 2), PI / 2, PI / 2),  # a quarter
        ((0.0, 4.0, 0.0), 2 * PI, None),  # half a turn each way, and no line between
        ((-2.0, 0.0, 0.0), 2 + 2 * PI, 2.0),  # straight back
        ((0.0, 0.0, 0.0), 0.0, 0.0),  # nowhere
        ((0.0, 0.0, PI), 7 * PI / 3, PI),  # about face: four times a sixth of a turn is too much
        # A parallel shift: two equal turns about circles that a line touches on its way across.
        ((10.0, 2.0, 0.0), SHIFT, SHIFT),
    ],
)
def test_known_lengths(goal, dubins, reeds_shepp):
    assert lengths_of(dubins_words, [goal])[0] == pytest.approx(dubins)
    either = lengths_of(reeds_shepp_words, [goal])[0]
    assert either < dubins if reeds_shepp is None else either == pytest.approx(reeds_shepp)


@given(goal=goals)
def test_a_reversing_car_never_drives_farther(goal):
    forwards, either = (lengths_of(words, [goal])[0] for words in BOTH)
    assert either <= forwards + 1e-9
    assert either >= np.hypot(*goal[:2]) - 1e-9


@given(goal=goals)
def test_the_reverse_path_of_a_reversing_car_is_as_long(goal):
    x, y, yaw = goal
    c, s = np.cos(yaw), np.sin(yaw)
    back = (-c * x - s * y, s * x - c * y, -yaw)
    there, again = lengths_of(reeds_shepp_words, [goal, back])
    assert there == pytest.approx(again, abs=1e-8)


@pytest.mark.parametrize("words", BOTH)
@given(seed=st.integers(0, 10_000), share=st.floats(0.02, 0.98))
def test_distance_adds_up_along_the_path(words, seed, share):
    """A point on the path divides its length: the path is a geodesic of the space."""
    goal = np.random.default_rng(seed).uniform([-6, -6, -PI], [6, 6, PI])
    word = words(np.array([goal], dtype=float))
    sizes = np.abs(word.lengths[0])
    before = np.cumsum(sizes) - sizes
    part = np.clip(share * sizes.sum() - before, 0.0, sizes) * np.sign(word.lengths[0])
    x, y, yaw = (value[0] for value in end_poses(part[None], word.turns))
    dx, dy = goal[0] - x, goal[1] - y
    c, s = np.cos(yaw), np.sin(yaw)
    rest = (c * dx + s * dy, c * dy - s * dx, goal[2] - yaw)
    total = lengths_of(words, [(x, y, yaw)])[0] + lengths_of(words, [rest])[0]
    assert total == pytest.approx(sizes.sum(), abs=1e-6)
