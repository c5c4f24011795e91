"""What is left of a motion: the verdict of the whole certificate, and the first conflict."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import planning
from planning import TimedTrajectory
from planning.certify.clearance.clearance_check import check_clearance
from planning.certify.clearance.proof_in_order import prove_in_order
from planning.errors import DeadlineExceeded, ProblemInvalid
from planning.world.collision.margins import PairMargins
from planning.world.world import World
from tests.certify.chains import random_robot, random_trajectory
from tests.certify.oracles import oracle, without_kernel
from tests.clocks import after_looks, no_hurry
from tests.discs import RADIUS, discs, straight
from tests.profiles import num_cases


def block(x: float) -> str:
    """Return a block across the way, of which the near side is 0.05 m before its place."""
    pose = f"{{position: [{x}, 0, 0]}}"
    return f"objects: [{{name: block, shape: {{box: [0.1, 4, 1]}}, pose: {pose}}}]\n"


def moved(tmp_path: Path, more: str = "") -> tuple[World, TimedTrajectory]:
    """Return a disc that goes from x = -1 to x = 1 in 2 s."""
    world = discs(tmp_path, {"a": (-1, 0)}, more=more)
    return world, straight(world, "a", (-1, 0), (1, 0))


def drake_only(world: World) -> World:
    world.drake = without_kernel(world.drake)
    return world


@pytest.mark.parametrize("kernel", [True, False])
def test_the_first_conflict_is_found(tmp_path: Path, kernel: bool) -> None:
    world, motion = moved(tmp_path, block(0.6))
    world = world if kernel else drake_only(world)
    report = planning.certify_rest(world, "a", motion, 0.5, deadline=no_hurry())
    assert not report.proven
    assert set(report.pair) == {"a::disc", "block"}
    # The disc touches the block at x = 0.6 - 0.05 - RADIUS, and what is proven is before that.
    x = motion.positions(np.array([report.proven_until, report.proven_until + 1.1e-3]))[:, 0]
    assert x[0] <= 0.55 - RADIUS <= x[1]
    assert report.distance <= 1e-6


@pytest.mark.parametrize("kernel", [True, False])
def test_what_lies_behind_does_not_count(tmp_path: Path, kernel: bool) -> None:
    world, motion = moved(tmp_path, block(-0.6))
    world = world if kernel else drake_only(world)
    report = planning.certify_rest(world, "a", motion, 1.0, deadline=no_hurry())
    assert (report.proven, report.since, report.proven_until) == (True, 1.0, 2.0)
    assert report.pair == ("", "")
    assert not planning.certify_rest(world, "a", motion, 0.0, deadline=no_hurry()).proven


def test_the_end_of_a_motion_has_a_rest_too(tmp_path: Path) -> None:
    for x, is_proven in ((-0.6, True), (1.0, False)):
        world, motion = moved(tmp_path, block(x))
        report = planning.certify_rest(world, "a", motion, 2.0, deadline=no_hurry())
        assert report.proven is is_proven
        assert report.proven_until == 2.0


@given(seed=st.integers(0, 100_000), margin=st.sampled_from([0.0, 0.01]))
@settings(max_examples=num_cases(12))
def test_the_verdict_is_that_of_the_certificate(seed: int, margin: float) -> None:
    """And until `until` there is no violation, which comes within a millisecond."""
    rng = np.random.default_rng(seed)
    with oracle(kernel=True):
        robot = random_robot(rng, num_links=3, num_obstacles=3)
    motion = random_trajectory(rng, robot.group, int(rng.integers(1, 4)), 0.25)
    request = robot.request(motion, PairMargins(margin))
    result = check_clearance(robot.model, request, no_hurry())
    found = prove_in_order(robot.model, request, no_hurry())
    assert found.proven is result.check.passed
    if found.proven or found.until == 0.0:
        return
    before = replace(request, trajectory=motion.until(found.until))
    assert check_clearance(robot.model, before, no_hurry()).check.passed
    if found.until + 1.1e-3 < motion.duration:
        beyond = replace(request, trajectory=motion.until(found.until + 1.1e-3))
        assert not check_clearance(robot.model, beyond, no_hurry()).check.passed


def test_faults_are_named(tmp_path: Path) -> None:
    world, motion = moved(tmp_path)
    for since in (-0.1, 2.1, np.nan):
        with pytest.raises(ProblemInvalid, match="since"):
            planning.certify_rest(world, "a", motion, since, deadline=no_hurry())
    with pytest.raises(DeadlineExceeded):
        planning.certify_rest(world, "a", motion, 0.0, deadline=after_looks(1, seconds=0.0))
