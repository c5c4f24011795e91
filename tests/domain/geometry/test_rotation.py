"""SO(3) against Drake's rotations and finite differences."""

import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RollPitchYaw, RotationMatrix

from planning.domain.geometry import rotation

vectors = arrays(np.float64, 3, elements=st.floats(-1.8, 1.8))


@given(vectors)
def test_log_undoes_exp_within_half_a_turn(phi: np.ndarray) -> None:
    assert np.linalg.norm(phi) < np.pi
    assert np.allclose(rotation.log(rotation.exp(phi)), phi, atol=1e-9)


@given(arrays(np.float64, 3, elements=st.floats(-9.0, 9.0)))
def test_log_leaves_whole_turns_out(phi: np.ndarray) -> None:
    angle = float(np.linalg.norm(phi))
    beyond = angle - 2 * np.pi * round(angle / (2 * np.pi))
    assume(angle > 1.0 and abs(beyond) < np.pi - 1e-3)
    assert np.allclose(rotation.log(rotation.exp(phi)), phi * (beyond / angle), atol=1e-9)


@given(vectors, vectors)
def test_products_and_matrices_agree_with_drake(phi: np.ndarray, psi: np.ndarray) -> None:
    a, b = rotation.exp(phi), rotation.exp(psi)
    drake = RotationMatrix(Quaternion(a)) @ RotationMatrix(Quaternion(b))
    assert np.allclose(rotation.matrix(rotation.multiply(a, b)), drake.matrix(), atol=1e-9)


@given(vectors)
def test_quaternion_of_matrix_is_the_same_rotation(phi: np.ndarray) -> None:
    matrix = rotation.matrix(rotation.exp(phi))
    assert np.allclose(rotation.matrix(rotation.from_matrix(matrix)), matrix, atol=1e-9)


@given(vectors)
def test_roll_pitch_yaw_is_drakes(rpy: np.ndarray) -> None:
    expected = RollPitchYaw(rpy).ToRotationMatrix().matrix()
    assert np.allclose(rotation.matrix(rotation.from_rpy(rpy)), expected, atol=1e-9)


@given(vectors, vectors, vectors)
def test_rates_are_the_derivatives_of_exp(
    phi: np.ndarray, rate: np.ndarray, curvature: np.ndarray
) -> None:
    def body_rate(t: float) -> np.ndarray:
        here = phi + rate * t + curvature * t**2 / 2
        return rotation.right_jacobian(here, rate + curvature * t)

    h = 1e-6
    before, after = (rotation.exp(phi + rate * t + curvature * t**2 / 2) for t in (-h, h))
    turned = rotation.log(rotation.multiply(rotation.conjugate(before), after)) / (2 * h)
    assert np.allclose(body_rate(0.0), turned, atol=1e-5)
    expected = (body_rate(h) - body_rate(-h)) / (2 * h)
    assert np.allclose(rotation.body_acceleration(phi, rate, curvature), expected, atol=1e-5)
