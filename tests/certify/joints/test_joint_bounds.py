"""What the kernel says of the joints of a motion is what numpy says, and holds at samples."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planning.certify.certifier import CertifyRequest, motion_checks
from planning.certify.form_check import form_check
from planning.certify.joints.limit_checks import RATE_NAMES, rate_check
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.robot.joints import JointType
from planning.kernel.native import native
from planning.world.collision.margins import PairMargins
from tests.conftest import group_of, limits_of
from tests.profiles import num_cases

pytestmark = pytest.mark.skipif(native() is None, reason="the native kernel was not built")
GROUP = group_of(*[JointType.REVOLUTE] * 5)


def request_of(seed: int, pieces: int, terms: int, *, jerk: bool) -> CertifyRequest:
    """Return the request of a motion that jumps and exceeds its limits anywhere."""
    rng = np.random.default_rng(seed)
    breaks = np.concatenate([[0.0], np.cumsum(rng.uniform(0.05, 1.0, pieces))])
    coefficients = rng.normal(size=(pieces, terms, 5)) * 0.5 ** np.arange(terms)[:, None]
    coefficients[rng.random(coefficients.shape) < 0.2] = 0.0
    curve = TimedTrajectory(GROUP.joints, breaks, rng.normal(size=(pieces, 5)), coefficients)
    limits = limits_of(GROUP)
    limits = replace(
        limits,
        lower=np.where(rng.random(5) < 0.3, -np.inf, limits.lower),
        velocity=np.where(rng.random(5) < 0.3, np.inf, limits.velocity),
    )
    return CertifyRequest(
        group=GROUP,
        trajectory=curve,
        state=np.zeros(5),
        start=curve.start,
        goals=curve.end[None],
        limits=limits,
        margins=PairMargins(0.0, {}, {}),
        jerk=jerk,
    )


@given(
    seed=st.integers(0, 2**32 - 1),
    pieces=st.integers(1, 9),
    terms=st.integers(1, 12),
    jerk=st.booleans(),
)
@settings(max_examples=num_cases(100))
def test_checks_are_numpys(seed: int, pieces: int, terms: int, jerk: bool) -> None:
    request = request_of(seed, pieces, terms, jerk=jerk)
    found = [form_check(request), *motion_checks(request)]
    assert request.joint_bounds is not None
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("planning.certify.joints.joint_bounds.native", lambda: None)
        same = replace(request)
        wanted = [form_check(same), *motion_checks(same)]
        assert same.joint_bounds is None
    for one, other in zip(found, wanted, strict=True):
        assert (one.name, one.passed, one.where) == (other.name, other.passed, other.where)
        assert one.value == pytest.approx(other.value, rel=1e-11, abs=1e-11)
        assert one.time == pytest.approx(other.time, abs=1e-6)


@given(seed=st.integers(0, 2**32 - 1), pieces=st.integers(1, 5), terms=st.integers(2, 8))
@settings(max_examples=num_cases(30))
def test_no_sample_exceeds_the_bounds(seed: int, pieces: int, terms: int) -> None:
    request = request_of(seed, pieces, terms, jerk=True)
    curve = request.trajectory
    inside = np.concatenate([np.linspace(a, b, 50)[1:-1] for a, b in pairwise(curve.breaks)])
    for order, name in enumerate(RATE_NAMES, start=1):
        shares = np.abs(curve.tangents(inside, order)) / getattr(request.limits, name)
        assert shares.max() <= rate_check(request, name, order).value * (1 + 1e-12)


def test_numbers_that_are_not_finite_are_left_to_numpy() -> None:
    request = request_of(0, 2, 4, jerk=False)
    broken = np.array(request.trajectory.coefficients)
    broken[0, 1, 0] = np.nan
    request = replace(request, trajectory=replace(request.trajectory, coefficients=broken))
    assert request.joint_bounds is None
    assert not form_check(request).passed
