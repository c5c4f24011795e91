"""Speed profiles: cutting and composing change nothing."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from planning.domain.curve import JointSpline
from planning.domain.joints import JointType
from planning.retime.compose import compose
from planning.retime.line_profile import line_profile
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
