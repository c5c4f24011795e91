"""Payloads are bodies that could be."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planning.domain.robot.payload import Payload
from planning.errors import ProblemInvalid

UNIT = st.floats(0.0, 1.0)


@given(masses=st.lists(UNIT, min_size=2, max_size=5), seed=st.integers(0, 1000))
def test_any_cloud_of_points_is_a_payload(masses: list[float], seed: int) -> None:
    points = np.random.default_rng(seed).normal(size=(len(masses), 3))
    weights = np.array(masses) + 0.01
    points -= weights @ points / weights.sum()
    i = sum(m * (p @ p * np.eye(3) - np.outer(p, p)) for m, p in zip(weights, points, strict=True))
    six = (i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2])
    payload = Payload.from_parts("tool", float(weights.sum()), (0.1, 0.0, 0.2), six)
    np.testing.assert_allclose(payload.inertia, i, atol=1e-12)


BAD = {
    "no mass": (0.0, (0, 0, 0), (0,) * 6),
    "negative mass": (-1.0, (0, 0, 0), (0,) * 6),
    "infinite mass": (float("inf"), (0, 0, 0), (0,) * 6),
    "a centre of two numbers": (1.0, (0, 0), (0,) * 6),
    "a centre nowhere": (1.0, (0, 0, float("nan")), (0,) * 6),
    "a moment too large": (1.0, (0, 0, 0), (1, 1, 2.1, 0, 0, 0)),
    "a negative moment": (1.0, (0, 0, 0), (1, 1, -0.1, 0, 0, 0)),
    "a product too large": (1.0, (0, 0, 0), (1, 1, 1, 1.5, 0, 0)),
    "five moments": (1.0, (0, 0, 0), (1,) * 5),
}


@pytest.mark.parametrize("name", BAD)
def test_what_is_no_body_is_refused_by_the_field_at_fault(name: str) -> None:
    with pytest.raises(ProblemInvalid) as refusal:
        Payload.from_parts("tool", *BAD[name])
    field = refusal.value.evidence["field"]
    assert field in {"mass", "center_of_mass", "inertia"}
    assert refusal.value.detail.startswith(f"{field}: ")
