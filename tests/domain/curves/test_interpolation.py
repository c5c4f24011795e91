"""Trajectories through samples meet the samples and are as smooth as they are said to be."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planning.domain.curves.curve import TimedTrajectory
from planning.domain.curves.interpolation import polyline_through, trajectory_through
from planning.domain.robot.joints import Joint, JointType
from planning.errors import ProblemInvalid

JOINTS = (
    Joint("r::a", JointType.REVOLUTE),
    Joint("r::b", JointType.CONTINUOUS),
    Joint("r::c", JointType.PLANAR),
)


def random_times(rng: np.random.Generator, count: int) -> np.ndarray:
    return np.concatenate([[0.0], np.cumsum(rng.uniform(0.05, 0.5, count - 1))])


def sides(trajectory: TimedTrajectory, order: int) -> tuple[np.ndarray, np.ndarray]:
    """Return a derivative just before and after each inner break."""
    inner = trajectory.breaks[1:-1]
    width = np.diff(trajectory.breaks).min()
    before, after = inner - 1e-9 * width, inner + 1e-9 * width
    return trajectory.tangents(before, order), trajectory.tangents(after, order)


@given(seed=st.integers(0, 2**32 - 1), count=st.integers(2, 12))
def test_samples_are_met(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    times, qs = random_times(rng, count), rng.uniform(-1.5, 1.5, (count, 5))
    vs, accelerations = rng.normal(size=(count, 5)), rng.normal(size=(count, 5))
    for given_vs, given_as in ((None, None), (vs, None), (vs, accelerations)):
        made = trajectory_through(JOINTS, times, qs, given_vs, given_as)
        assert np.abs(made.manifold.minus(made.positions(times), qs)).max() < 1e-9
        ends = times[[0, -1]]
        if given_vs is None:
            np.testing.assert_allclose(made.velocities(ends), 0, atol=1e-9)
            for order in (1, 2):
                np.testing.assert_allclose(*sides(made, order), atol=1e-5)
        else:
            np.testing.assert_allclose(made.velocities(times), vs, atol=1e-8)
            np.testing.assert_allclose(*sides(made, 1), atol=1e-6)
        if given_as is not None:
            np.testing.assert_allclose(made.accelerations(times), accelerations, atol=1e-6)


@given(seed=st.integers(0, 2**32 - 1), degree=st.sampled_from([3, 5]))
def test_polynomials_of_the_same_degree_are_found_again(seed: int, degree: int) -> None:
    rng = np.random.default_rng(seed)
    joints = JOINTS[:1]
    powers = np.polynomial.Polynomial(rng.normal(size=degree + 1))
    times = random_times(rng, 6)
    column = [powers.deriv(k)(times)[:, None] if k else powers(times)[:, None] for k in range(3)]
    made = trajectory_through(
        joints, times, column[0], column[1], column[2] if degree == 5 else None
    )
    between = np.linspace(0, times[-1], 200)
    np.testing.assert_allclose(made.positions(between)[:, 0], powers(between), atol=1e-9)


@pytest.mark.parametrize("kind", [JointType.CONTINUOUS, JointType.REVOLUTE])
def test_positions_are_numbers_and_not_angles_on_a_circle(kind: JointType) -> None:
    joints = (Joint("r::b", kind),)
    for q0, q1 in ((0.0, 4.0), (3.0, -3.0), (-1.0, 20.0)):
        made = trajectory_through(joints, np.array([0.0, 1.0]), np.array([[q0], [q1]]))
        ways = made.positions(np.array([0.0, 0.5, 1.0]))[:, 0]
        np.testing.assert_allclose(ways, [q0, (q0 + q1) / 2, q1], atol=1e-12)


BAD_SAMPLES = [
    ({"times": [0.0, 2.0, 1.0]}, "times must be at least two, and increase"),
    ({"times": [0.0, 1.0, 1.0]}, "times must be at least two, and increase"),
    ({"times": [0.0, np.nan, 1.0]}, "times has numbers that are not finite"),
    ({"times": [0.0], "positions": [[0.0]]}, "times must be at least two, and increase"),
    ({"positions": [[0.0], [np.inf], [1.0]]}, "positions has numbers that are not finite"),
    ({"positions": [[0.0], [1.0]]}, "positions has 2 samples, not 3 as times"),
]


@pytest.mark.parametrize("through", [trajectory_through, polyline_through])
@pytest.mark.parametrize(("bad", "message"), BAD_SAMPLES)
def test_bad_samples_are_refused_by_name(through, bad, message):
    good = {"times": [0.0, 1.0, 2.0], "positions": [[0.0], [0.5], [1.0]]}
    samples = {name: np.array(rows) for name, rows in {**good, **bad}.items()}
    joint = Joint("j", JointType.REVOLUTE)
    with pytest.raises(ProblemInvalid, match=message) as refusal:
        through((joint,), **samples)
    assert refusal.value.evidence["field"] in message


def test_bad_rates_are_refused_by_name():
    times, positions = np.array([0.0, 1.0]), np.zeros((2, 1))
    joints = (Joint("j", JointType.REVOLUTE),)
    with pytest.raises(ProblemInvalid, match="velocities has numbers"):
        trajectory_through(joints, times, positions, np.array([[0.0], [np.nan]]))
    with pytest.raises(ProblemInvalid, match="accelerations has 3 samples"):
        trajectory_through(joints, times, positions, np.zeros((2, 1)), np.zeros((3, 1)))
