"""The clearance of a certificate: its lower bound holds, and the observed one is measured."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.certify.conftest import (
    certificate_of,
    quintic,
    request_for,
    smallest_distance,
    world_from,
)
from tests.profiles import num_cases

BALL = """
robots: [{name: body, model: planar_l, positions: [-0.3, 0.0, 0.0]}]
objects:
  - {name: ball, shape: {sphere: 0.05}, pose: {position: [0.0, 0.3, 0.03]}}
"""


@settings(max_examples=num_cases(4))
@given(seed=st.integers(0, 10_000))
def test_the_smallest_distance_lies_between_what_is_proven_and_observed(seed: int) -> None:
    world, rng = world_from(BALL), np.random.default_rng(seed)
    q0 = np.array([-0.25, rng.uniform(-0.2, 0.2), rng.uniform(-3, 3)])
    q1 = np.array([0.25, rng.uniform(-0.2, 0.2), q0[2] + rng.normal(0, 0.8)])
    motion = quintic(world.group("body"), q0, q1, 30.0)
    certificate = certificate_of(world, request_for(world, "body", motion))
    smallest = smallest_distance(world, motion, "body", 5e-4)
    if certificate.proven:
        assert certificate.min_clearance <= smallest + 1e-7
        assert smallest <= certificate.observed_clearance + 1e-4
        assert certificate.proven_clearance == certificate.min_clearance >= 0
        resolution = certificate.checks[-1].resolution
        gap = certificate.observed_clearance - certificate.min_clearance
        assert gap == pytest.approx(resolution, abs=1e-12)
    else:
        assert smallest < 1e-4
        assert certificate.min_clearance == certificate.observed_clearance
        assert certificate.proven_clearance == -np.inf
