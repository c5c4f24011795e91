"""What the samples of a motion stand for keeps the limits that the motion keeps."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planning.domain.curves.curve import TimedTrajectory
from planning.domain.curves.interpolation import polyline_through, trajectory_through
from planning.domain.curves.sampling import Sampling, sample_trajectory
from planning.domain.robot.joints import Joint, JointType
from tests.profiles import num_cases

JOINTS = (Joint("r::a", JointType.REVOLUTE), Joint("r::b", JointType.PRISMATIC))
LIMITS = np.array([4.0, 2.0])
SEEDS = st.integers(0, 2**32 - 1)


def bang_bang(seed, widths=(0.02, 0.3), turns=0.0, most_between=0.0):
    """Return a motion of constant accelerations within the limits, some of them at a limit.

    Between its pieces, before and after them, lie others that take up to `most_between`, if that
    is not 0.
    """
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 9))
    h = rng.uniform(*widths, n)
    if most_between:
        short = most_between * 10.0 ** rng.uniform(-4, 0, n + 1)
        h = np.append(np.column_stack([short[:-1], h]).ravel(), short[-1])
        h = h[int(rng.integers(2)) : len(h) - int(rng.integers(2))]
        n = len(h)
    a = rng.choice([-1.0, -0.5, 0.0, 0.3, 1.0], (n, 2)) * LIMITS
    v = np.concatenate([np.zeros((1, 2)), np.cumsum(a * h[:, None], axis=0)])[:-1]
    steps = v * h[:, None] + a * h[:, None] ** 2 / 2
    q = rng.uniform(-3, 3, 2) + np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])[:-1]
    bases = q + turns * 2 * np.pi * rng.integers(-1, 2, (n, 1)) * [1, 0]
    breaks = np.concatenate([[0.0], np.cumsum(h)])
    return TimedTrajectory(JOINTS, breaks, bases, np.stack([np.zeros_like(v), v, a / 2], axis=1))


def read(samples, kind):
    rates = {"cubic": (samples.velocities,), "quintic": (samples.velocities, samples.accelerations)}
    if kind == "linear":
        return polyline_through(samples.joints, samples.times, samples.positions)
    return trajectory_through(samples.joints, samples.times, samples.positions, *rates[kind])


def looks(curve):
    """Return instants on both sides of every break, and between."""
    spans = np.linspace(0.0, 1.0, 12)[:, None] * np.diff(curve.breaks) * (1 - 1e-9)
    return np.sort((curve.breaks[:-1] + spans).ravel())


@given(SEEDS, st.floats(1e-3, 0.5))
@settings(max_examples=num_cases(40))
def test_accelerations_do_not_overshoot_where_they_jump(seed, period):
    motion = bang_bang(seed)
    samples = sample_trajectory(motion, Sampling(period), LIMITS)
    for kind in ("cubic", "quintic"):
        made = read(samples, kind)
        times = looks(made)
        assert (np.abs(made.accelerations(times)) <= LIMITS * (1 + 1e-6)).all()
        speeds = np.abs(motion.velocities(looks(motion))).max(axis=0)
        assert (np.abs(made.velocities(times)) <= speeds + 1e-6).all()
        np.testing.assert_allclose(made.positions(times), motion.positions(times), atol=1e-7)


def test_samples_that_are_evenly_apart_overshoot_by_eight_percent_of_the_jump():
    h, a = 0.35, 4.0
    rates = np.array([[0.0, a / 2], [a * h, -a / 2]])
    coefficients = np.stack([np.zeros((2, 2)), *np.stack([rates, rates], axis=2).swapaxes(0, 1)], 1)
    bases = np.array([[0.0, 0.0], [a * h**2 / 2] * 2])
    motion = TimedTrajectory(JOINTS, np.array([0.0, h, 2 * h]), bases, coefficients)
    for period in (1e-3, 1e-2):
        even = read(sample_trajectory(motion, Sampling(period, is_even=True), LIMITS), "quintic")
        at_pieces = read(sample_trajectory(motion, Sampling(period), np.full(2, a)), "quintic")
        peaks = [np.abs(made.accelerations(looks(made))).max() / a for made in (even, at_pieces)]
        assert peaks[0] > 1.05
        assert peaks[1] <= 1 + 1e-6


@given(SEEDS, st.floats(1e-3, 3.0))
@settings(max_examples=num_cases(20))
def test_samples_have_both_ends_as_they_are_and_no_longer_gap_than_asked(seed, period):
    motion = bang_bang(seed)
    samples = sample_trajectory(motion, Sampling(period), LIMITS)
    assert samples.times[0] == 0.0
    assert samples.times[-1] == motion.duration
    assert (np.diff(samples.times) > 0).all()
    assert samples.longest_gap <= period * (1 + 1e-9)
    for k, q in ((0, motion.start), (-1, motion.end)):
        np.testing.assert_allclose(samples.positions[k], q, atol=1e-14)
    np.testing.assert_allclose(samples.velocities[0], 0.0, atol=1e-15)
    ends = motion.velocities(motion.breaks[-1:])[0]
    np.testing.assert_allclose(samples.velocities[-1], ends, atol=1e-13)


@given(SEEDS, st.floats(1e-3, 0.1))
@settings(max_examples=num_cases(20))
def test_what_is_smooth_is_told_as_it_is(seed, period):
    """Without jumps there are no ramps: the polynomial of degree 5 is the motion, bit for bit."""
    rng = np.random.default_rng(seed)
    coefficients = np.zeros((1, 6, 2))
    coefficients[0] = rng.normal(size=(6, 2))
    motion = TimedTrajectory(JOINTS, np.array([0.0, 1.0]), rng.normal(size=(1, 2)), coefficients)
    # The same motion in two pieces: no jump at all.
    split = TimedTrajectory.joined([motion.until(0.4), motion.after(0.4)])
    samples = sample_trajectory(split, Sampling(period), np.full(2, 1e3))
    assert 0.4 in samples.times
    np.testing.assert_allclose(samples.positions, motion.positions(samples.times), atol=1e-13)
    made = read(samples, "quintic")
    times = np.linspace(0, 1, 777)
    np.testing.assert_allclose(made.positions(times), motion.positions(times), atol=1e-12)


@given(SEEDS)
@settings(max_examples=num_cases(20))
def test_pieces_too_short_to_tell_are_gone_over(seed):
    """However short pieces are, times increase and all numbers are near the motion's."""
    rng = np.random.default_rng(seed)
    motion = bang_bang(seed, widths=(1e-7, 10.0 ** rng.uniform(-5, -2)))
    samples = sample_trajectory(motion, Sampling(0.01), LIMITS)
    assert (np.diff(samples.times) > 0).all()
    np.testing.assert_allclose(samples.positions, motion.positions(samples.times), atol=1e-6)
    np.testing.assert_allclose(samples.positions[-1], motion.end, atol=1e-14)


@given(SEEDS, st.floats(1e-3, 0.5))
@settings(max_examples=num_cases(40))
def test_what_is_gone_over_changes_no_speed(seed, period):
    """Pieces too short for samples, between longer ones and at the ends, cost no limit."""
    motion = bang_bang(seed, widths=(0.3, 0.6), most_between=1.9e-4)
    samples = sample_trajectory(motion, Sampling(period), LIMITS)
    assert (np.diff(samples.times) > 0).all()
    speeds = np.abs(motion.velocities(looks(motion))).max(axis=0)
    for kind in ("cubic", "quintic"):
        made = read(samples, kind)
        times = looks(made)
        assert (np.abs(made.accelerations(times)) <= LIMITS * (1 + 1e-6)).all()
        assert (np.abs(made.velocities(times)) <= speeds + 1e-6).all()
        np.testing.assert_allclose(made.positions(times), motion.positions(times), atol=1e-7)


def test_whole_turns_between_anchors_are_no_jumps():
    joints = (Joint("r::a", JointType.CONTINUOUS), Joint("r::b", JointType.PRISMATIC))
    for seed in range(20):
        plain = bang_bang(seed)
        motion = TimedTrajectory(joints, plain.breaks, plain.bases, plain.coefficients)
        turned = bang_bang(seed, turns=1.0)
        other = TimedTrajectory(joints, turned.breaks, turned.bases, turned.coefficients)
        for made in (sample_trajectory(curve, Sampling(0.05), LIMITS) for curve in (motion, other)):
            off = motion.manifold.minus(made.positions, motion.positions(made.times))
            np.testing.assert_allclose(off, 0.0, atol=1e-7)


@pytest.mark.parametrize("count", [2, 3, 50])
def test_points_are_evenly_apart(count):
    motion = bang_bang(3)
    times = sample_trajectory(motion, Sampling(0.01, num_points=count), LIMITS).times
    np.testing.assert_allclose(times, np.linspace(0, motion.duration, count))


def test_a_piece_of_nothing_at_an_end_belongs_to_its_neighbour():
    motion = bang_bang(5)
    cut = TimedTrajectory.joined([motion.until(2e-8), motion.after(2e-8)])
    times = sample_trajectory(cut, Sampling(0.01), LIMITS).times
    np.testing.assert_allclose(
        times, sample_trajectory(motion, Sampling(0.01), LIMITS).times, atol=1e-7
    )
    assert np.diff(times).min() > 5e-5
