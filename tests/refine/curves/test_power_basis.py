"""The power basis is the B-spline itself."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from planning.domain.robot.joints import Joint, JointType
from planning.refine.curves.bspline_basis import make_bspline
from planning.refine.curves.power_basis import joint_spline


def joints(count: int) -> tuple[Joint, ...]:
    return tuple(Joint(f"g::j{i}", JointType.REVOLUTE) for i in range(count))


@given(
    seed=st.integers(0, 2**32 - 1),
    count=st.integers(4, 18),
    size=st.integers(1, 8),
    duration=st.floats(0.1, 20.0),
)
def test_positions_and_derivatives_are_those_of_drake(seed, count, size, duration):
    rng = np.random.default_rng(seed)
    spline = make_bspline(rng.uniform(-3, 3, (count, size)), duration)
    curve = joint_spline(joints(size), spline)
    s = np.concatenate([[0.0, 1.0], rng.uniform(0, 1, 50)])
    t = np.minimum(s * duration, duration)
    np.testing.assert_allclose(curve.positions(s), spline.vector_values(t).T, atol=1e-12)
    for order in (1, 2):
        wanted = spline.MakeDerivative(order).vector_values(t).T * duration**order
        scale = np.abs(wanted).max()
        np.testing.assert_allclose(curve.tangents(s, order), wanted, atol=1e-11 * scale)
    assert curve.num_pieces == count - 3


@given(seed=st.integers(0, 2**32 - 1), count=st.integers(4, 18))
def test_the_ends_are_the_outer_control_points(seed, count):
    points = np.random.default_rng(seed).uniform(-3, 3, (count, 6))
    curve = joint_spline(joints(6), make_bspline(points))
    np.testing.assert_array_equal(curve.start, points[0])
    np.testing.assert_allclose(curve.end, points[-1], atol=1e-13)
