"""Motions of several groups as one: at each instant each is where it would be alone."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planning.domain.curves.combined import combined
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.robot.joints import Joint, JointType

KINDS = [JointType.REVOLUTE, JointType.PRISMATIC, JointType.PLANAR, JointType.FLOATING]


@st.composite
def motions(draw: st.DrawFn, name: str) -> TimedTrajectory:
    """Draw a motion of some joints; its pieces need not meet, as nothing here asks for that."""
    seed = draw(st.integers(0, 2**32 - 1))
    kinds = draw(st.lists(st.sampled_from(KINDS), min_size=1, max_size=3))
    count, degree = draw(st.integers(1, 5)), draw(st.integers(0, 5))
    rng = np.random.default_rng(seed)
    joints = tuple(Joint(f"{name}::{i}", kind) for i, kind in enumerate(kinds))
    nv = sum(joint.num_velocities for joint in joints)
    nq = sum(joint.num_positions for joint in joints)
    bases = rng.normal(size=(count, nq))
    at = 0
    for joint in joints:
        if joint.type is JointType.FLOATING:
            bases[:, at : at + 4] /= np.linalg.norm(bases[:, at : at + 4], axis=1)[:, None]
        at += joint.num_positions
    breaks = np.append(0.0, np.cumsum(rng.uniform(0.05, 1.0, count)))
    return TimedTrajectory(joints, breaks, bases, rng.normal(size=(count, degree + 1, nv)))


@given(first=motions("a"), second=motions("b"), third=motions("c"), data=st.data())
def test_each_is_where_it_would_be_alone(
    first: TimedTrajectory, second: TimedTrajectory, third: TimedTrajectory, data: st.DataObject
) -> None:
    parts = [first, second, third]
    begins = [data.draw(st.floats(0.0, 3.0)) for _ in parts]
    whole = combined(parts, begins)
    ends = [begin + part.duration for begin, part in zip(begins, parts, strict=True)]
    assert whole.duration == max(ends)
    assert whole.breaks[0] == 0
    assert (np.diff(whole.breaks) > 0).all()
    all_breaks = np.concatenate([b + p.breaks for b, p in zip(begins, parts, strict=True)])
    times = np.linspace(0.0, whole.duration, 301)
    # Where pieces of a drawn motion do not meet, an instant there is of either.
    times = times[np.abs(times[:, None] - all_breaks).min(axis=1) > 1e-9]
    q, v, a = (f(times) for f in (whole.positions, whole.velocities, whole.accelerations))
    iq = iv = 0
    for part, begin in zip(parts, begins, strict=True):
        local = times - begin
        is_moving = (local > 0) & (local < part.duration)
        at = np.clip(local, 0.0, part.duration)
        nq, nv = part.bases.shape[1], part.coefficients.shape[2]
        expected = part.positions(at)
        expected[local <= 0], expected[local >= part.duration] = part.start, part.end
        assert q[:, iq : iq + nq] == pytest.approx(expected, abs=1e-11)
        for actual, alone in ((v, part.velocities(at)), (a, part.accelerations(at))):
            alone[~is_moving] = 0.0
            assert actual[:, iv : iv + nv] == pytest.approx(alone, abs=1e-9)
        iq, iv = iq + nq, iv + nv


@given(motion=motions("a"))
def test_one_alone_is_itself_bit_for_bit(motion: TimedTrajectory) -> None:
    assert combined([motion], [0.0]) == motion


@given(motion=motions("a"), other=motions("b"))
def test_pieces_that_none_divides_are_the_same_bit_for_bit(
    motion: TimedTrajectory, other: TimedTrajectory
) -> None:
    after = combined([motion, other], [0.0, motion.duration])
    n, terms, nv = motion.coefficients.shape
    assert after.coefficients[:n, :terms, :nv].tobytes() == motion.coefficients.tobytes()
    assert (after.coefficients[:n, terms:, :nv] == 0).all()
    assert after.bases[:n, : motion.bases.shape[1]].tobytes() == motion.bases.tobytes()


def test_instants_that_rounding_parts_are_one() -> None:
    joints = [Joint("a::x", JointType.PRISMATIC)], [Joint("b::x", JointType.PRISMATIC)]
    rising = np.array([[[0.0], [1.0]], [[0.1 + 0.2], [1.0]]])
    first, second = (
        TimedTrajectory(tuple(own), np.array([0.0, at, 1.0]), np.zeros((2, 1)), rising)
        for own, at in zip(joints, (0.1 + 0.2, 0.3), strict=True)
    )
    whole = combined([first, second], [0.0, 0.0])
    assert whole.num_pieces == 2
    times = np.linspace(0, 1, 11)
    assert whole.positions(times) == pytest.approx(np.stack([times, times], axis=1), abs=1e-12)
