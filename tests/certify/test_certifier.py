"""What is proven is true, and what is broken is refused."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planning.certify.certifier import CertifyRequest
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.scene.scene import PairMargin
from planning.world.world import World
from tests.certify.conftest import (
    certificate_of,
    quintic,
    request_for,
    smallest_distance,
    world_from,
)
from tests.conftest import bundled_world
from tests.profiles import num_cases

pytestmark = pytest.mark.usefixtures("implementation")

FLAT = """
robots: [{{name: body, model: planar_l, positions: [-0.3, 0.0, 0.0]}}]
objects:
  - name: wall
    shape: {{box: [{thickness:.6f}, 0.2, 0.2]}}
    pose: {{position: [{x:.6f}, {y:.6f}, 0.0]}}
margin: {margin}
"""


def flat_world(x: float, y: float = 0.0, thickness: float = 0.02, margin: float = 0.0) -> World:
    return world_from(FLAT.format(x=x, y=y, thickness=thickness, margin=margin))


def slide(world: World, shift: float = 0.6, duration: float = 4.0) -> CertifyRequest:
    """Return the certify request of a straight motion along x, from -0.3."""
    group = world.group("body")
    q0 = np.array([-0.3, 0.0, 0.0])
    trajectory = quintic(group, q0, q0 + np.array([shift, 0.0, 0.0]), duration)
    return request_for(world, "body", trajectory)


def swing() -> tuple[World, CertifyRequest]:
    """Return a sound motion of the UR5e over its table."""
    world = bundled_world("ur5e_pickup")
    group = world.group("arm")
    q0 = world.positions(group)
    q1 = q0 + np.array([-1.2, 0.2, -0.3, 0.1, 0.2, 0.4])
    return world, request_for(world, "arm", quintic(group, q0, q1, 2.5))


def test_a_sound_motion_is_proven_with_every_check_named() -> None:
    world, request = swing()
    certificate = certificate_of(world, request)
    assert certificate.proven
    names = {check.name for check in certificate.checks}
    assert names >= {"start", "goal", "continuity", "position", "velocity", "acceleration"}
    assert "clearance" in names
    assert not certificate.failed
    reference = smallest_distance(world, request.trajectory, "arm", 0.002)
    resolution = certificate.checks[-1].resolution
    assert certificate.observed_clearance - resolution - 1e-6 <= reference
    assert certificate.observed_clearance >= reference - 1e-4
    assert resolution < 0.01


def test_minimum_clearance_is_the_analytic_one() -> None:
    # The long side of the L reaches 0.125 m in +x and the wall's face is at 0.52: 0.095 m are left.
    world = flat_world(x=0.53)
    certificate = certificate_of(world, slide(world))
    gap = 0.52 - (0.3 + 0.125)
    assert certificate.proven
    assert certificate.observed_clearance == pytest.approx(gap, abs=1e-6)
    assert certificate.time == pytest.approx(4.0)
    assert set(certificate.pair) == {"body::body", "wall"}


@pytest.mark.campaign
@pytest.mark.parametrize("gap", [3e-4, 0.01, 1e-4, 1e-3][: num_cases(2, 4)])
def test_a_graze_is_proven_and_a_touch_is_not(gap: float) -> None:
    # The lower arm of the L ends at y = -0.05; the wall is 0.2 wide.
    near = flat_world(x=0.0, y=-0.05 - 0.1 - gap)
    certificate = certificate_of(near, slide(near))
    assert certificate.proven
    assert certificate.observed_clearance == pytest.approx(gap, abs=1e-6)
    touching = flat_world(x=0.0, y=-0.05 - 0.1 + gap)
    assert not certificate_of(touching, slide(touching)).proven


@given(x=st.floats(-0.1, 0.4), thickness=st.floats(0.0005, 0.003))
@settings(max_examples=num_cases(6))
def test_a_thin_wall_between_two_samples_is_caught(x: float, thickness: float) -> None:
    world = flat_world(x=x, thickness=thickness)
    # 0.6 m in one go: a sample every 10 ms is up to 12 mm from the next.
    request = slide(world, duration=1.2)
    fast = replace(
        request,
        limits=replace(
            request.limits, velocity=np.array([10.0, 10.0]), acceleration=np.array([50.0, 50.0])
        ),
    )
    certificate = certificate_of(world, fast)
    assert not certificate.proven
    assert certificate.failed[0].name == "clearance"
    assert certificate.failed[0].where == "body::body-wall"


def test_margins_are_required_and_pairs_may_override_them() -> None:
    for margin, proven in ((0.09, True), (0.1, False)):
        world = flat_world(x=0.53, margin=margin)
        certificate = certificate_of(world, slide(world))
        assert certificate.proven is proven
        assert certificate.checks[-1].bound == margin
    world = flat_world(x=0.53, margin=0.1)
    exception = PairMargin(("body::body", "wall"), 0.01)
    world.scene = replace(world.scene, margins=(exception,))
    assert certificate_of(world, slide(world)).proven


def _with(trajectory: TimedTrajectory, **arrays: np.ndarray) -> TimedTrajectory:
    return replace(trajectory, **arrays)


def _bumped(trajectory: TimedTrajectory, power: int, amount: float) -> TimedTrajectory:
    coefficients = np.array(trajectory.coefficients)
    coefficients[0, power, 0] += amount
    return _with(trajectory, coefficients=coefficients)


def _cut(trajectory: TimedTrajectory, jump: float) -> TimedTrajectory:
    """Return the motion in two halves, the second displaced."""
    half = trajectory.duration / 2
    taylor = np.stack([trajectory.tangents(np.array([half]), k)[0] for k in range(6)])
    factorials = np.array([1, 1, 2, 6, 24, 120.0])
    second = taylor / factorials[:, None]
    second[0, 0] += jump
    return TimedTrajectory(
        trajectory.joints,
        np.array([0.0, half, trajectory.duration]),
        np.repeat(trajectory.bases, 2, axis=0),
        np.stack([trajectory.coefficients[0], second]),
    )


NAN = float("nan")
MUTANTS = {
    "shifted": (lambda t: _with(t, bases=t.bases + 0.01), "start"),
    "pushed off its goal": (lambda t: _bumped(t, 5, 1e-4), "goal"),
    "moving at its start": (lambda t: _bumped(t, 1, 1e-3), "rest"),
    "sped up": (lambda t: t.time_scaled(0.2), "velocity"),
    "accelerated": (lambda t: t.time_scaled(0.4), "acceleration"),
    "torn": (lambda t: _cut(t, 1e-3), "continuity"),
    "out of its limits": (lambda t: _with(t, bases=t.bases + 7.0), "position"),
    "not a number": (lambda t: _with(t, bases=t.bases * NAN), "form"),
    "backwards in time": (lambda t: _with(t, breaks=t.breaks[::-1].copy()), "form"),
    "of another shape": (lambda t: _with(t, bases=t.bases[:, :5]), "form"),
}


@pytest.mark.parametrize("name", MUTANTS)
def test_mutants_are_refused_for_what_is_wrong_with_them(name: str) -> None:
    world, request = swing()
    mutate, check = MUTANTS[name]
    certificate = certificate_of(world, request, trajectory=mutate(request.trajectory))
    assert not certificate.proven
    assert check in {failed.name for failed in certificate.failed}


def test_two_halves_of_a_sound_motion_are_sound() -> None:
    world, request = swing()
    assert certificate_of(world, request, trajectory=_cut(request.trajectory, 0.0)).proven


def test_a_motion_through_the_box_is_refused_with_pair_and_depth() -> None:
    world = bundled_world("ur5e_pickup")
    group = world.group("arm")
    pick = np.array([0.30977, -1.22556, 1.82362, -2.16885, -1.5708, -1.26102])
    place = np.array([-0.74525, -1.24629, 1.85330, -2.17782, -1.5708, -2.31605])
    trajectory = quintic(group, pick, place, 4.0)
    certificate = certificate_of(world, request_for(world, "arm", trajectory))
    check = certificate.checks[-1]
    assert not certificate.proven
    assert (check.name, check.passed) == ("clearance", False)
    assert check.value < 0
    assert "box" in check.where
    assert 0 < check.time < 4


@given(seed=st.integers(0, 1000))
@settings(max_examples=num_cases(3))
def test_proven_motions_are_free_at_dense_samples(seed: int) -> None:
    world = bundled_world("ur5e_pickup")
    group = world.group("arm")
    q0 = world.positions(group)
    q1 = q0 + np.random.default_rng(seed).normal(0, 0.7, 6)
    trajectory = quintic(group, q0, q1, 5.0)
    certificate = certificate_of(world, request_for(world, "arm", trajectory))
    reference = smallest_distance(world, trajectory, "arm", 0.004)
    if certificate.proven:
        assert reference > 0
        assert certificate.observed_clearance >= reference - 1e-3
        assert (
            certificate.observed_clearance - certificate.checks[-1].resolution <= reference + 1e-6
        )
    elif certificate.failed[0].name == "clearance":
        # Refusals are justified: the samples come as near to contact as the certificate says.
        assert reference <= max(certificate.failed[0].value, 0) + 1e-3


@given(seed=st.integers(0, 1000))
@settings(max_examples=num_cases(4))
def test_verdicts_on_a_turning_body_agree_with_dense_samples(seed: int) -> None:
    world = bundled_world("window_3d")
    group = world.group("body")
    rng = np.random.default_rng(seed)
    q0 = world.positions(group)
    q1 = np.concatenate([rng.normal(size=4), [0.5, *rng.uniform(-0.2, 0.2, 1), 0.5]])
    q1[:4] /= np.linalg.norm(q1[:4])
    trajectory = quintic(group, q0, q1, 10.0)
    certificate = certificate_of(world, request_for(world, "body", trajectory))
    assert certificate.proven == (smallest_distance(world, trajectory, "body", 0.002) > 0)


def test_the_followers_of_a_moving_finger_count() -> None:
    text = """
robots: [{name: arm, model: ur5e}]
objects: [{name: stick, shape: {box: [0.004, 0.004, 0.004]}}]
"""
    world = world_from(text)
    gripper = world.group("arm::gripper")
    follower = world.frame_pose("arm::right_finger", world.embed(gripper, np.array([0.0]))).position
    leader = world.frame_pose("arm::left_finger", world.embed(gripper, np.array([0.0]))).position
    tip = world.frame_pose("arm::tcp", world.state).position
    at = (follower - leader) / max(np.linalg.norm(follower - leader), 1e-9) * 0.02 + tip
    placed = text.replace("0.004]}}]", f"0.004]}}, pose: {{position: {at.tolist()}}}}}]")
    world = world_from(placed)
    closing = quintic(gripper, np.array([0.025]), np.array([0.0]), 2.0)
    opening_only_leader = certificate_of(world, request_for(world, "arm::gripper", closing))
    reference = smallest_distance(world, closing, "arm::gripper", 1e-4)
    assert opening_only_leader.proven == (reference > 0)
