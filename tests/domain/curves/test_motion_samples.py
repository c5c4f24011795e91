"""A motion is sampled on its geodesic, finely enough, collisions first."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planning.domain.curves.motion_samples import (
    are_motions_free,
    fraction_batches,
    is_motion_free,
    num_steps,
    sample_batches,
    steps_of,
)
from planning.domain.robot.joints import JointType
from planning.domain.robot.manifold import Manifold
from tests.conftest import group_of, random_waypoints


@given(st.one_of(st.integers(1, 300), st.integers(4000, 9000)))
def test_every_fraction_comes_once_and_the_far_end_first(steps: int) -> None:
    fractions = np.concatenate(list(fraction_batches(steps)))
    assert fractions[0] == 1.0
    assert np.array_equal(np.sort(fractions), np.arange(1, steps + 1) / steps)


@given(st.integers(2, 3000))
def test_the_largest_gap_shrinks_with_every_doubling_of_samples(steps: int) -> None:
    fractions = np.concatenate(list(fraction_batches(steps)))
    for power in range(int(np.log2(len(fractions)))):
        seen = np.sort(np.concatenate([[0.0], fractions[: 2**power]]))
        assert np.diff(seen).max() <= 2.0 / 2**power + 2.0 / steps


@given(st.floats(0.0, 100.0), st.floats(1e-3, 1.0))
def test_steps_are_as_few_as_the_resolution_allows(length: float, resolution: float) -> None:
    (n,) = steps_of(np.array([[length]]), resolution)
    assert length / n <= resolution * (1 + 1e-8)
    assert n == num_steps(np.array([length]), resolution)
    if n > 1:
        assert length / (n - 1) > resolution * (1 - 1e-8)


@given(seed=st.integers(0, 10_000), num_joints=st.integers(1, 12))
def test_lengths_are_sums_in_the_order_of_the_coordinates(seed: int, num_joints: int) -> None:
    displacements = np.random.default_rng(seed).uniform(-1, 1, (5, num_joints))
    for counted, displacement in zip(steps_of(displacements, 1e-6), displacements, strict=True):
        squares = 0.0
        for x in displacement.tolist():
            squares += x * x
        assert counted == num_steps(displacement, 1e-6)
        assert counted == max(1, np.ceil(np.sqrt(squares) / 1e-6 - 1e-9))


@given(seed=st.integers(0, 10_000))
def test_samples_of_joints_that_do_not_float_are_these_very_numbers(seed: int) -> None:
    group = group_of(JointType.REVOLUTE, JointType.CONTINUOUS, JointType.PLANAR)
    origin, displacement = np.random.default_rng(seed).uniform(-2, 2, (2, 5))
    (n,) = steps_of(displacement[None], 0.05).tolist()
    samples = np.concatenate(
        list(sample_batches(Manifold(group.joints), (origin, displacement), 0.05))
    )
    fractions = np.concatenate(list(fraction_batches(n)))
    for qs, fraction in zip(samples, fractions, strict=True):
        i = round(fraction * n)
        expected = [
            o + (i / n) * d for o, d in zip(origin.tolist(), displacement.tolist(), strict=True)
        ]
        assert qs.tolist() == expected


@pytest.mark.parametrize("kind", [JointType.FLOATING, JointType.PLANAR, JointType.REVOLUTE])
@given(seed=st.integers(0, 10_000))
def test_many_motions_are_judged_as_one_by_one(kind: JointType, seed: int) -> None:
    group = group_of(kind, JointType.CONTINUOUS)
    manifold = Manifold(group.joints)
    origins, ends = random_waypoints(group, seed, 8), random_waypoints(group, seed + 1, 8)
    motions = origins, manifold.minus(ends, origins)

    def are_free(qs: np.ndarray) -> np.ndarray:
        return np.sin(3 * qs.sum(axis=1) + seed) < 0.9

    many = are_motions_free(manifold, are_free, motions, 0.1)
    assert many.shape == (8,)
    for motion, verdict in zip(zip(*motions, strict=True), many, strict=True):
        assert is_motion_free(manifold, are_free, motion, 0.1) == verdict
        samples = np.concatenate(list(sample_batches(manifold, motion, 0.1)))
        assert bool(are_free(samples).all()) == verdict


def test_no_motions_are_no_verdicts() -> None:
    manifold = Manifold(group_of(JointType.REVOLUTE).joints)
    none = np.empty((0, 1)), np.empty((0, 1))
    assert are_motions_free(manifold, lambda qs: qs[:, 0] > 0, none, 0.1).shape == (0,)
