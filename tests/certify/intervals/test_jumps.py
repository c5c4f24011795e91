"""Jumps between pieces add up, and the clearance proof covers the way between them."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.geometry import Box
from pydrake.math import RigidTransform

from planning.certify.certifier import certify
from planning.certify.clearance.clearance_check import quick_clearance
from planning.certify.clearance.clearance_result import ClearanceResult
from planning.certify.clearance.drake_clearance import DrakeProof
from planning.certify.intervals.jumps import JumpSums, unwrap_turns
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.robot.joints import Joint, JointType
from planning.world.collision.margins import PairMargins
from tests.certify.chains import FLOATING, PLANAR, Builder, P, R, Robot
from tests.clocks import no_hurry
from tests.profiles import num_cases

MARGINS = PairMargins(0.0, {}, {})


@given(st.integers(0, 9999), st.integers(0, 8))
def test_sums_are_the_largest_between_any_two_instants(seed: int, count: int) -> None:
    jumps = np.random.default_rng(seed).normal(size=(count, 2))
    sums = JumpSums.of(jumps)
    for column in range(2):
        every = [abs(jumps[i:j, column].sum()) for i in range(count) for j in range(i, count + 1)]
        assert sums.largest[column] == pytest.approx(max(every, default=0.0), abs=1e-12)
        if count:
            last = sums.last_jump(column)
            ending = [abs(jumps[i : last + 1, column].sum()) for i in range(count)]
            assert max(ending) == pytest.approx(sums.largest[column])


def slider() -> Robot:
    builder = Builder()
    builder.link(P, Box(0.02, 0.02, 0.02))
    return builder.build()


def stairs(robot: Robot, order: int, jump: float, count: int, gap: float) -> TimedTrajectory:
    """Return a motion whose order-th derivative alone jumps: up, and for rates back to 0."""
    levels = np.arange(count) * jump
    if order:
        levels = np.concatenate([levels, levels[::-1]])
    if order == 2:
        levels = np.concatenate([levels, -levels])
    powers, bases = np.zeros((len(levels), 3, 1)), np.zeros((len(levels), 1))
    q = v = 0.0
    for i, level in enumerate(levels):
        if order == 0:
            bases[i] = level
            continue
        v, push = (level, 0.0) if order == 1 else (v, level)
        bases[i], powers[i, 1], powers[i, 2] = q, v, push / 2
        q, v = q + v * gap + push / 2 * gap**2, v + push * gap
    breaks = np.arange(len(levels) + 1) * gap
    return TimedTrajectory(robot.group.joints, breaks, bases, powers)


@pytest.mark.parametrize(
    ("order", "jump", "name"),
    [
        (0, 0.99e-6, "continuity"),
        (1, 0.99e-5, "velocity continuity"),
        (2, 0.49e-3, "acceleration continuity"),
    ],
)
@pytest.mark.parametrize("count", [2, 3, 2000])
def test_small_jumps_that_add_up_are_refused(
    order: int, jump: float, name: str, count: int
) -> None:
    robot = slider()
    motion = stairs(robot, order, jump, count, 1e-6)
    request = robot.request(motion, MARGINS)
    request = replace(request, limits=robot.limits(1.0), jerk=True)
    certificate, _ = certify(robot.model, request, no_hurry())
    checks = {check.name: check for check in certificate.checks}
    # Accelerations go from the highest to the lowest, which is as far below rest.
    apart = (count - 1) * jump * (2 if order == 2 else 1)
    assert checks[name].value == pytest.approx(apart, rel=1e-6)
    assert checks[name].passed == (count == 2)
    others = {"continuity", "velocity continuity", "acceleration continuity"} - {name}
    assert all(checks[other].passed for other in others)


def test_rounding_that_cancels_is_no_jump() -> None:
    """A million jumps of the size of rounding, in alternating directions."""
    robot = slider()
    count = 10_000
    bases = np.where(np.arange(count) % 2, 0.9e-6, 0.0)[:, None]
    motion = TimedTrajectory(
        robot.group.joints, np.arange(count + 1) * 1e-3, bases, np.zeros((count, 1, 1))
    )
    certificate, _ = certify(robot.model, robot.request(motion, MARGINS), no_hurry())
    assert next(c for c in certificate.checks if c.name == "continuity").passed


CONTINUOUS = (Joint("g::c", JointType.CONTINUOUS), Joint("g::p", JointType.PLANAR))


@given(st.integers(0, 9999))
def test_unwrapping_changes_bases_by_whole_turns_only(seed: int) -> None:
    rng = np.random.default_rng(seed)
    joints = (*CONTINUOUS, Joint("g::f", JointType.FLOATING), Joint("g::r", JointType.REVOLUTE))
    powers = rng.normal(size=(5, 4, 11))
    base = rng.normal(size=12)
    base[4:8] /= np.linalg.norm(base[4:8])
    rows = [base]
    whole = TimedTrajectory(joints, np.arange(2.0), base[None], powers[:1])
    for i in range(4):
        piece = TimedTrajectory(joints, np.arange(2.0), rows[-1][None], powers[i : i + 1])
        rows.append(whole.manifold.plus(piece.end, -powers[i + 1, 0]))
    sound = TimedTrajectory(joints, np.arange(6.0), np.array(rows), powers)
    turned = np.array(rows)
    turned[:, [0, 3]] += 2 * np.pi * rng.integers(-2, 3, (5, 2))
    turned[1:, 0] -= turned[0, 0] - sound.bases[0, 0]
    turned[1:, 3] -= turned[0, 3] - sound.bases[0, 3]
    turned[0] = sound.bases[0]
    made = unwrap_turns(TimedTrajectory(joints, sound.breaks, turned, powers))
    np.testing.assert_allclose(made.bases, sound.bases, atol=1e-9)
    assert unwrap_turns(made) is made


def across(kind: JointType) -> tuple[Robot, TimedTrajectory]:
    """Return an arm on one side of a post, then at once on the other, never near it."""
    builder = Builder()
    arm = RigidTransform([0.5, 0.0, 0.0])
    builder.link(kind, Box(0.6, 0.02, 0.02), axis=np.array([0.0, 0.0, 1.0]), x_bg=arm)
    where = [0.5, 0.0, 0.4] if kind is P else [0.5, 0.2, 0.0]
    builder.obstacle("post", Box(0.05, 0.05, 0.05), RigidTransform(where))
    robot = builder.build()
    start, axis = np.array(robot.state), {R: 0, P: 0, PLANAR: 2, FLOATING: 2}[kind]
    bases = np.stack([start, start])
    width = robot.group.num_velocities
    leap = np.zeros(width)
    leap[axis] = 0.8
    manifold = TimedTrajectory(
        robot.group.joints, np.arange(2.0), bases[:1], np.zeros((1, 1, width))
    ).manifold
    bases[1] = manifold.plus(bases[0], leap)
    powers = np.zeros((2, 2, width))
    powers[:, 1, axis] = 1e-3  # it does move
    return robot, TimedTrajectory(robot.group.joints, np.arange(3.0), bases, powers)


# Drake's proof of a jump fails only after its last segment: half a millisecond each.
SEGMENTS = num_cases(400, 20_000)


def proof_of(robot: Robot, motion: TimedTrajectory, implementation: str) -> ClearanceResult:
    request = robot.request(motion, MARGINS)
    if implementation == "drake":
        return DrakeProof(robot.model, request, no_hurry(), SEGMENTS).run()
    return quick_clearance(robot.model, request, no_hurry())


@pytest.mark.campaign
@pytest.mark.parametrize("kind", [R, P, PLANAR, FLOATING])
def test_an_obstacle_in_the_way_of_a_jump_is_detected(implementation: str, kind: JointType) -> None:
    """Neither side of the jump is near the obstacle, which is on the way between them."""
    robot, motion = across(kind)
    assert not proof_of(robot, motion, implementation).check.passed
    for begin, end in pairwise(motion.breaks):
        half = motion.until(float(end)).after(float(begin)) if begin else motion.until(float(end))
        halved = proof_of(robot, half, implementation)
        assert halved.check.passed
        assert halved.num_segments < SEGMENTS / 10
