"""The proof of interpolated samples agrees with the certificate of the interpolated motion."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planning.api.retime_path import retime_path
from planning.certify.certifier import CertifyRequest, certify, certify_polyline
from planning.certify.intervals.hermite_errors import HermiteErrors
from planning.certify.samples import interpolants
from planning.certify.samples.interpolants import KINDS, interpolate_samples, prove_interpolants
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.curves.sampling import Sampling, sample_trajectory
from planning.domain.request.options import RetimeOptions
from planning.domain.robot.manifold import Manifold
from planning.world.world import World
from tests.certify.conftest import quintic, request_for, world_from
from tests.clocks import after_looks, no_hurry
from tests.conftest import bundled_world
from tests.profiles import num_cases

DELTA = np.array([-1.2, 0.2, -0.3, 0.1, 0.2, 0.4])


@cache
def motion(method: str, seed: int = 0) -> tuple[World, CertifyRequest, float]:
    """Return a proven motion of an arm over its table, with a corner, and its clearance."""
    world = bundled_world("ur5e_pickup")
    home = world.positions(world.group("arm"))
    rng = np.random.default_rng(seed)
    path = np.stack([home, home + DELTA / 2 + rng.normal(0, 0.05, 6), home + DELTA])
    options = RetimeOptions(method)
    found = retime_path(world, "arm", path, deadline=no_hurry(60.0), options=options)
    request = replace(request_for(world, "arm", found.trajectory), jerk=method == "ruckig")
    return world, request, found.certificate.proven_clearance


def of(request: CertifyRequest, sampling: Sampling):
    limits = request.limits.per_coordinate(request.limits.acceleration)
    errors = HermiteErrors.of(request)
    gaps = None if errors is None else errors.sample_spacing("quintic")
    return sample_trajectory(request.trajectory, sampling, limits, gaps)


def verdicts_on(world: World, request: CertifyRequest, samples, clearance: float, deadline=None):
    errors, limit = HermiteErrors.of(request), deadline or no_hurry(60.0)
    return prove_interpolants(world.drake, request, samples, clearance, limit, errors)


def certified_again(world: World, request: CertifyRequest, samples, kind: str):
    """Return the certificate of the motion that a receiver interpolates from samples."""
    made = replace(request, trajectory=interpolate_samples(samples, kind))
    certifier = certify_polyline if kind == "linear" else certify
    return certifier(world.drake, made, no_hurry(60.0))[0]


@pytest.mark.parametrize("method", ["toppra", "ruckig"])
@pytest.mark.parametrize(
    "sampling",
    [
        Sampling(0.01),
        Sampling(0.002),
        Sampling(10.0),
        Sampling(0.01, is_even=True),
        Sampling(num_points=2),
        Sampling(num_points=40),
    ],
    ids=str,
)
def test_a_verdict_is_the_certifiers(method, sampling):
    world, request, clearance = motion(method)
    samples = of(request, sampling)
    verdicts = verdicts_on(world, request, samples, clearance)
    assert tuple(verdict.kind for verdict in verdicts) == KINDS
    for verdict in verdicts:
        certificate = certified_again(world, request, samples, verdict.kind)
        assert verdict.proven == certificate.proven
        assert {check.name for check in verdict.failed} == {c.name for c in certificate.failed}
        assert ("acceleration" in verdict.unchecked) == (verdict.kind == "linear")
        assert verdict.reason == ""


@pytest.mark.parametrize("method", ["toppra", "ruckig"])
def test_samples_as_they_are_by_default_are_proven(method):
    for seed in range(3):
        world, request, clearance = motion(method, seed)
        samples = of(request, Sampling())
        for verdict in verdicts_on(world, request, samples, clearance):
            if (verdict.kind, method) != ("cubic", "ruckig"):
                # Polynomials of degree 3 have jumps of acceleration, which limits on jerk forbid.
                assert verdict.proven, (seed, verdict)
                assert verdict.up_to_period >= samples.longest_gap


@pytest.mark.parametrize("method", ["toppra", "ruckig"])
def test_up_to_its_period_an_interpolation_is_proven(method):
    world, request, clearance = motion(method)
    samples = of(request, Sampling())
    for verdict in verdicts_on(world, request, samples, clearance):
        for share in (1.0, 0.7, 0.31):
            period = verdict.up_to_period * share
            if period > 1e-3:
                others = of(request, Sampling(period))
                assert certified_again(world, request, others, verdict.kind).proven, (
                    verdict,
                    share,
                )


def over_a_wall(drop: float) -> tuple[World, CertifyRequest]:
    """Return a body's way over a wall, at the middle of it, whose top is so far below."""
    world = world_from(f"""
robots: [{{name: body, model: planar_l, positions: [-0.4, 0.0, 0.0]}}]
objects:
  - {{name: wall, shape: {{box: [0.02, 0.2, 0.2]}}, pose: {{position: [0.0, {-drop}, 0.0]}}}}
""")
    group = world.group("body")
    straight = quintic(group, np.array([-0.4, 0, 0]), np.array([0.4, 0, 0]), 12.0)
    powers = np.zeros((1, 7, 3))
    powers[0, :6] = straight.coefficients[0]
    # 64 s^3 (1 - s)^3, 0.3 m high.
    for power, factor in ((3, 64.0), (4, -192.0), (5, 192.0), (6, -64.0)):
        powers[0, power, 1] = 0.3 * factor / 12.0**power
    over = TimedTrajectory(group.joints, straight.breaks, straight.bases, powers)
    return world, request_for(world, "body", over)


def near_a_wall(gap: float) -> tuple[World, CertifyRequest, float]:
    """Return a path over a wall with a proven clearance, and that clearance."""
    drop = 0.3
    for _ in range(6):
        found = certify(*_model(over_a_wall(drop)), no_hurry(60.0))[0]
        drop -= found.min_clearance - gap
    world, request = over_a_wall(drop)
    certificate = certify(world.drake, request, no_hurry(60.0))[0]
    assert certificate.proven, certificate.failed
    return world, request, certificate.proven_clearance


def _model(of_world):
    world, request = of_world
    return world.drake, request


def test_two_samples_of_a_path_around_an_obstacle_are_not_proven():
    world, request, clearance = near_a_wall(0.01)
    for verdict in verdicts_on(world, request, of(request, Sampling(num_points=2)), clearance):
        assert not verdict.proven
        assert "clearance" in {check.name for check in verdict.failed}
    for verdict in verdicts_on(world, request, of(request, Sampling()), clearance):
        assert verdict.proven, verdict


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=num_cases(6))
def test_clearance_derived_from_that_of_the_motion_holds(seed):
    """Few samples cut the path over a wall short, by about its clearance."""
    rng = np.random.default_rng(seed)
    world, request, clearance = near_a_wall(10.0 ** rng.uniform(-4, -1.5))
    samples = of(request, Sampling(num_points=2 * int(rng.integers(2, 20))))
    for verdict in verdicts_on(world, request, samples, clearance):
        again = certified_again(world, request, samples, verdict.kind)
        assert verdict.proven == again.proven


def test_interpolants_are_not_proven_after_the_deadline():
    world, request, _ = motion("toppra")
    samples = of(request, Sampling())
    late = verdicts_on(world, request, samples, -np.inf, after_looks(1))
    assert not any(verdict.proven for verdict in late)
    assert all("time" in verdict.reason for verdict in late)


def test_default_samples_cost_no_second_proof_of_clearance(monkeypatch):
    world, request, clearance = motion("toppra")
    clearance_calls = []
    prove = interpolants.check_clearance
    monkeypatch.setattr(
        interpolants,
        "check_clearance",
        lambda *given: clearance_calls.append(given) or prove(*given),
    )
    samples = of(request, Sampling())
    verdicts_on(world, request, samples, clearance)
    assert clearance_calls == []
    verdicts_on(world, request, samples, -np.inf)
    assert len(clearance_calls) == len(KINDS)


def test_samples_of_floating_joints_are_interpolated_linearly_only():
    world = world_from("""
robots: [{name: body, model: free_l}]
""")
    group = world.group("body")
    q0 = world.positions(group)
    delta = np.array([0.4, -0.9, 0.3, 0.2, 0.1, 0.5])
    q1 = Manifold(group.joints).plus(q0, delta)
    request = request_for(world, "body", quintic(group, q0, q1, 6.0))
    straight, *others = verdicts_on(world, request, of(request, Sampling()), -np.inf)
    assert straight.proven, straight
    assert not any(verdict.proven for verdict in others)
    assert all("float" in verdict.reason for verdict in others)
