"""Segments cover the trajectory, and it stays within their bounds."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from planning.certify.intervals.joint_deviation import Segment, Segments
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.robot.joints import JointType
from planning.domain.robot.manifold import Manifold
from tests.certify.chains import random_trajectory
from tests.conftest import group_of

GROUP = group_of(
    JointType.FLOATING,
    JointType.CONTINUOUS,
    JointType.PLANAR,
    JointType.PRISMATIC,
    JointType.REVOLUTE,
)


def check_bounds(trajectory: TimedTrajectory, segment: Segment) -> None:
    times = np.linspace(segment.begin, segment.end, 33)
    manifold = Manifold(GROUP.joints)
    away = manifold.minus(trajectory.positions(times), np.tile(segment.center, (33, 1)))
    turn = [slice(0, 3), slice(6, 7), slice(9, 10), None, slice(11, 12)]
    shift = [slice(3, 6), None, slice(7, 9), slice(10, 11), None]
    for bounds, parts in ((segment.max_rotation, turn), (segment.max_translation, shift)):
        for bound, part in zip(bounds, parts, strict=True):
            moved = 0.0 if part is None else np.linalg.norm(away[:, part], axis=1).max()
            assert moved <= bound + 1e-7


@given(seed=st.integers(0, 10_000), num_pieces=st.integers(1, 6))
def test_the_trajectory_stays_within_every_segments_bounds(seed: int, num_pieces: int) -> None:
    rng = np.random.default_rng(seed)
    trajectory = random_trajectory(rng, GROUP, num_pieces, 0.3)
    segments = Segments(trajectory)
    level = [segments.whole]
    for _ in range(5):
        for segment in level:
            check_bounds(trajectory, segment)
            assert segment.begin <= segment.time <= segment.end
        level = [half for segment in level for half in segments.halves(segment)]
        ends = np.array([[segment.begin, segment.end] for segment in level])
        assert ends[0, 0] == 0.0
        assert ends[-1, 1] == trajectory.duration
        assert (ends[1:, 0] == ends[:-1, 1]).all()


@given(seed=st.integers(0, 10_000))
def test_bounds_shrink_with_the_segments(seed: int) -> None:
    segments = Segments(random_trajectory(np.random.default_rng(seed), GROUP, 2, 0.3))
    segment = segments.whole
    for _ in range(16):
        segment = segments.halves(segment)[1]
    assert max(segment.max_rotation.max(), segment.max_translation.max()) < 1e-3
