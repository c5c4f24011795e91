"""Speed profiles: cutting and composing change nothing."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from planning.domain.curves.curve import JointSpline
from planning.domain.robot.joints import JointType
from planning.retime.compose import compose
from planning.retime.line_profile import LineLimits, line_profile, profile_between
from planning.retime.profile import SpeedProfile
from tests.conftest import group_of


def place(profile: SpeedProfile, t: np.ndarray) -> np.ndarray:
    """Return s(t) by each phase's own formula."""
    starts = np.concatenate([[0.0], np.cumsum(profile.h)])
    i = np.clip(np.searchsorted(starts, t, side="right") - 1, 0, len(profile.h) - 1)
    x = t - starts[i]
    return profile.s[i] + x * (profile.v[i] + x * (profile.a[i] / 2 + x * profile.j[i] / 6))


@given(st.floats(0.1, 5.0), st.floats(0.1, 5.0), st.lists(st.floats(0.0, 1.0), max_size=6))
def test_splitting_keeps_the_motion(speed: float, push: float, places: list[float]) -> None:
    profile = line_profile(0.0, 1.0, speed, push)
    cuts = np.unique(places)
    split = profile.split_at(cuts)
    times = np.linspace(0, profile.duration, 201)
    assert np.isclose(split.duration, profile.duration)
    assert np.abs(place(split, times) - place(profile, times)).max() < 1e-9
    assert (split.h > 0).all()
    # A place that is reached within a moment of another boundary may share it.
    assert all(np.abs(split.s - cut).min() < 1e-9 for cut in cuts)


@given(st.integers(0, 10_000))
def test_composition_is_exact(seed: int) -> None:
    rng = np.random.default_rng(seed)
    group = group_of(JointType.REVOLUTE, JointType.PRISMATIC)
    breaks = np.array([0.0, 0.3, 1.0])
    spline = JointSpline(group.joints, breaks, np.zeros((2, 2)), rng.normal(size=(2, 4, 2)))
    profile = SpeedProfile(
        np.array([0.0, 0.3, 1.0]),
        np.array([0.0, 0.6]),
        np.array([1.2, 0.2]),
        np.array([0.0, -0.3]),
        np.array([np.sqrt(0.5), 1.0]),
    )
    profile = SpeedProfile(np.array([0.0, 0.3, 0.95]), profile.v, profile.a, profile.j, profile.h)
    trajectory = compose(spline, profile)
    times = np.linspace(0, profile.duration, 101)
    # Both sides of the break are the spline's own pieces, which do not meet here.
    times = times[np.abs(times - profile.h[0]) > 1e-9]
    wanted = spline.positions(place(profile, times))
    assert np.abs(trajectory.positions(times) - wanted).max() < 1e-12


@given(
    seed=st.integers(0, 10_000),
    speeds=st.lists(st.sampled_from([0.0, 0.3, 0.7, 1.0]), min_size=2, max_size=6),
)
def test_cells_are_passed_with_the_speeds_at_their_edges(seed: int, speeds: list[float]) -> None:
    rng = np.random.default_rng(seed)
    count = len(speeds) - 1
    edges = np.concatenate([[0.0], np.cumsum(rng.uniform(0.1, 1.0, count))])
    v = np.array(speeds)
    is_line = (rng.random(count) < 0.5) | (v[:-1] + v[1:] == 0)
    speed, up, down = rng.choice([1.0, 1.5], count), *rng.uniform(0.5, 20.0, (2, count))
    lines = LineLimits(is_line, speed, up, rng.choice([up, down]))
    profile = profile_between(edges, v**2, lines)
    assert (profile.h > 0).all()
    # Places and speeds go on where the phase before ends, and edges are where phases begin.
    steps = profile.h * (profile.v + profile.h * profile.a / 2)
    assert np.abs(profile.s[:-1] + steps - profile.s[1:]).max() < 1e-9
    begins = np.searchsorted(profile.s, edges)
    assert np.array_equal(profile.s[begins], edges)
    assert np.abs(np.append(profile.v, v[-1])[begins] - v).max() < 1e-9
    after = profile.v + profile.h * profile.a
    assert np.abs(after[:-1] - profile.v[1:]).max(initial=0.0) < 1e-9
    owners = np.clip(np.searchsorted(edges, profile.s[:-1], side="right") - 1, 0, count - 1)
    on_line = is_line[owners]
    assert (np.maximum(profile.v, after)[on_line] <= lines.speed[owners][on_line] + 1e-9).all()
    needed = (np.abs(np.diff(v**2)) / (2 * np.diff(edges)))[owners]
    for sign, pushes in ((1, lines.acceleration), (-1, lines.braking)):
        allowed = np.maximum(np.where(on_line, pushes[owners], 0.0), needed)
        assert (sign * profile.a <= allowed * (1 + 1e-9)).all()


@given(
    before=st.floats(0.0, 1.0),
    after=st.floats(0.0, 1.0),
    pushes=st.tuples(st.floats(0.6, 30.0), st.floats(0.6, 30.0)),
    speed=st.floats(1.0, 3.0),
)
def test_a_line_between_two_speeds_takes_the_least_time(
    before: float, after: float, pushes: tuple[float, float], speed: float
) -> None:
    up, down = pushes
    lines = LineLimits(np.array([True]), *(np.array([x]) for x in (speed, up, down)))
    squares = np.array([before**2, after**2])
    profile = profile_between(np.array([0.0, 1.0]), squares, lines)
    # The least time is that at the greatest speed that can be reached and left again.
    s = np.linspace(0.0, 1.0, 20_001)
    top = np.minimum(squares[0] + 2 * up * s, squares[1] + 2 * down * (1 - s))
    v = np.sqrt(np.minimum(top, speed**2))
    least = float((2 * np.diff(s) / (v[1:] + v[:-1])).sum())
    assert np.isclose(profile.duration, least, rtol=1e-4)
