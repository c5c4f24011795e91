"""The utilization is the peak: never below that of samples, and hardly above."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planning.domain.curves.curve import TimedTrajectory
from planning.domain.robot.joints import JointGroup, JointType
from planning.retime import limit_utilization
from planning.retime.limit_utilization import max_utilization
from planning.retime.polynomials import bisected_form, halved, to_bernstein
from tests.conftest import group_of, limits_of, random_waypoints

GROUPS = [
    group_of(*[JointType.REVOLUTE] * 3),
    group_of(JointType.PLANAR, JointType.PRISMATIC),
    group_of(JointType.FLOATING),
]


def random_curve(group: JointGroup, seed: int) -> TimedTrajectory:
    rng = np.random.default_rng(seed)
    breaks = np.concatenate([[0.0], np.cumsum(rng.uniform(0.1, 0.5, 4))])
    coefficients = rng.normal(0.0, 0.3, (4, 7, group.num_velocities))
    return TimedTrajectory(group.joints, breaks, random_waypoints(group, seed, 4), coefficients)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("group", GROUPS)
@given(seed=st.integers(0, 10_000))
def test_use_is_the_peak_over_the_limit(group: JointGroup, order: int, seed: int) -> None:
    curve = random_curve(group, seed)
    limits = limits_of(group, velocity=0.7, acceleration=3.0)
    times = np.linspace(0, curve.duration, 4001)
    # The audit bounds angular velocity by |delta'|.
    rates = curve.tangents(times, 1) if order == 1 else curve.accelerations(times)
    sizes = np.stack([np.linalg.norm(rates[:, list(ix)], axis=1) for _, ix in group.blocks], axis=1)
    sampled = sizes / (limits.velocity if order == 1 else limits.acceleration)
    use = max_utilization(curve, limits, order)
    assert sampled.max() <= use.fraction * (1 + 1e-9)
    assert use.fraction <= sampled.max() * (1 + 1e-2)
    assert sampled[:, use.block].max() >= sampled.max() * (1 - 1e-2)


def test_a_peak_between_ends_is_met_to_nine_digits() -> None:
    group = GROUPS[0]
    # delta' = 1 - (t - 1/3)^2 on the last joint: its peak is 1 inside the piece.
    coefficients = np.zeros((1, 4, 3))
    coefficients[0, 1:, 2] = [1 - 1 / 9, 1 / 3, -1 / 3]
    curve = TimedTrajectory(group.joints, np.array([0.0, 1.0]), np.zeros((1, 3)), coefficients)
    use = max_utilization(curve, limits_of(group, velocity=2.0), 1)
    assert use.block == 2
    assert 0.5 <= use.fraction <= 0.5 * (1 + 2e-9)


@pytest.mark.parametrize("order", [1, 2, 3])
@given(seed=st.integers(0, 10_000))
def test_the_kernel_finds_the_same_peak(order: int, seed: int) -> None:
    group = GROUPS[0]
    curve, limits = random_curve(group, seed), limits_of(group, velocity=0.7, jerk=40.0)
    by_kernel = max_utilization(curve, limits, order)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(limit_utilization, "native", lambda: None)
        in_numpy = max_utilization(curve, limits, order)
    assert by_kernel.fraction == pytest.approx(in_numpy.fraction, rel=2e-9)
    assert by_kernel.block == in_numpy.block


@given(seed=st.integers(0, 10_000), degree=st.integers(0, 6))
def test_parts_have_the_form_that_halving_gives(seed: int, degree: int) -> None:
    rng = np.random.default_rng(seed)
    coefficients, widths = rng.normal(size=(3, degree + 1, 2)), rng.uniform(0.1, 2.0, 3)
    form = to_bernstein(coefficients, widths)
    for _ in range(2 if degree > 1 else 0):
        form = halved(form)
    found = bisected_form(coefficients, widths, 2)
    np.testing.assert_allclose(found.reshape(form.shape), form, rtol=1e-13, atol=1e-13)
