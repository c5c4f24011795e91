"""Robustness: errors of obstacles and joints within the reported ones cause no contact."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from pydrake.geometry import Box, Cylinder, Sphere
from pydrake.math import RigidTransform

from planning.certify.certifier import certify
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.request.options import CertifyOptions
from planning.domain.request.robustness import MAX_DISPLACEMENT, MAX_JOINT_ERROR, Robustness
from planning.world.collision.margins import PairMargins
from planning.world.world import World
from tests.certify.chains import Builder, P, R, Robot, fine_loop
from tests.certify.conftest import quintic, smallest_distance
from tests.certify.sound_motions import sound_motions
from tests.clocks import no_hurry
from tests.conftest import bundled_world
from tests.profiles import PROFILE, num_cases

ASKED = CertifyOptions(robustness=True)
DOWN = np.array([0.0, 0.0, 1.0])


def robustness_of(
    robot: Robot, trajectory: TimedTrajectory, margins: PairMargins
) -> Robustness | None:
    request = replace(robot.request(trajectory, margins), options=ASKED)
    certificate, report = certify(robot.model, request, no_hurry(30.0))
    assert certificate.proven is (report.robustness is not None)
    return report.robustness


@pytest.mark.parametrize("margin", [0.0, 0.02])
@pytest.mark.parametrize("gap", [0.03, 0.2])
def test_a_slide_up_to_a_wall_survives_the_gap_that_is_left(gap: float, margin: float) -> None:
    builder = Builder()
    builder.link(P, Sphere(0.05))
    builder.obstacle("wall", Box(1.0, 1.0, 0.1), RigidTransform(0.5 * DOWN))
    robot = builder.build()
    motion = quintic(robot.group, np.zeros(1), np.array([0.4 - gap]), 1.0)
    found = robustness_of(robot, motion, PairMargins(margin))
    assert found is not None
    spare = gap - margin
    for value, pair in (
        (found.obstacle_displacement, found.obstacle_pair),
        (found.joint_error, found.joint_pair),
    ):
        assert 0.98 * spare - 2e-4 <= value <= spare
        assert set(pair) == {"robot::link0", "wall"}


@pytest.mark.parametrize("length", [0.3, 1.0])
def test_a_pointer_that_turns_towards_a_wall_survives_the_gap_over_its_length(
    length: float,
) -> None:
    builder = Builder()
    tip = RigidTransform(np.array([length, 0.0, 0.0]))
    builder.link(R, Sphere(1e-3), axis=DOWN, x_bg=tip)
    # The pointer ends along x, and the wall is across its way: the tip comes straight at it.
    builder.obstacle(
        "wall", Box(2.0, 0.1, 1.0), RigidTransform(np.array([0.0, 0.05 + 1e-3 + 0.02, 0.0]))
    )
    robot = builder.build()
    motion = quintic(robot.group, np.array([-0.5]), np.zeros(1), 1.0)
    found = robustness_of(robot, motion, PairMargins(0.0))
    assert found is not None
    hits = float(np.arcsin(0.02 / length))
    assert 0.97 * hits <= found.joint_error < hits


def test_large_reserves_are_reported_up_to_a_bound() -> None:
    builder = Builder()
    builder.link(P, Sphere(0.05))
    builder.obstacle("far", Sphere(0.1), RigidTransform(9.0 * DOWN))
    robot = builder.build()
    motion = quintic(robot.group, np.zeros(1), np.ones(1), 1.0)
    found = robustness_of(robot, motion, PairMargins(0.0))
    assert found is not None
    assert (found.obstacle_displacement, found.joint_error) == (MAX_DISPLACEMENT, MAX_JOINT_ERROR)
    alone = Builder()
    alone.link(P, Sphere(0.05))
    found = robustness_of(alone.build(), motion, PairMargins(0.0))
    assert found is not None
    assert found.obstacle_pair == ("", "")
    assert found.obstacle_displacement == MAX_DISPLACEMENT


def among(places: np.ndarray) -> Robot:
    """Return an arm of three links among a ball, a box and a cylinder."""
    builder = Builder()
    along = np.array([0.0, 1.0, 0.0])
    for i in range(3):
        out = RigidTransform(np.array([0.0 if i == 0 else 0.4, 0.0, 0.0]))
        middle = RigidTransform(np.array([0.2, 0.0, 0.0]))
        axis = DOWN if i == 0 else along
        builder.link(R, Box(0.38, 0.06, 0.06), i - 1 if i else None, out, axis, x_bg=middle)
    shapes = (Sphere(0.1), Box(0.1, 0.3, 0.2), Cylinder(0.08, 0.4))
    for i, (shape, place) in enumerate(zip(shapes, places, strict=True)):
        builder.obstacle(f"thing{i}", shape, RigidTransform(place))
    return builder.build()


@given(seed=st.integers(0, 10_000))
@settings(max_examples=num_cases(6))
def test_no_displacement_below_the_bound_makes_anything_touch(seed: int) -> None:
    rng = np.random.default_rng(seed)
    places = rng.normal(0.0, 0.5, (3, 3)) + np.array([0.0, 0.0, 0.4])
    robot = among(places)
    motion = quintic(robot.group, rng.uniform(-1, 1, 3), rng.uniform(-1, 1, 3), 1.0)
    found = robustness_of(robot, motion, PairMargins(0.0))
    assume(found is not None)
    assert found.obstacle_displacement > 0
    for _ in range(4):
        away = rng.normal(size=(3, 3))
        away *= 0.999 * found.obstacle_displacement / np.linalg.norm(away, axis=1)[:, None]
        assert fine_loop(among(places + away), motion, 0.01) > 0
    for _ in range(4):
        off = 0.999 * found.joint_error * rng.choice([-1.0, 1.0], 3)
        assert fine_loop(robot, replace(motion, bases=motion.bases + off), 0.01) > 0


def displaced_hits(world: World, name: str, motion: TimedTrajectory, error: float) -> bool:
    """Return whether some choice of signs of an error of every joint makes anything touch."""
    rng = np.random.default_rng(1)
    return any(
        smallest_distance(
            world,
            replace(
                motion, bases=motion.bases + error * rng.choice([-1.0, 1.0], motion.bases.shape)
            ),
            name,
            0.05,
        )
        <= 0
        for _ in range(6)
    )


@pytest.mark.campaign
def test_bundled_scenes_tolerate_the_reported_errors_and_little_more() -> None:
    motions, hit = sound_motions(num_cases(3), 8 + PROFILE.seed), 0
    for sound in motions:
        request = replace(sound.request, options=ASKED)
        certificate, report = certify(sound.world.drake, request, no_hurry(30.0))
        found = report.robustness
        assert certificate.proven
        assert found is not None
        assert found.joint_error > 0
        # The robot's own base is no obstacle.
        assert any("::" not in body for body in found.obstacle_pair)
        motion = sound.request.trajectory
        assert not displaced_hits(sound.world, sound.name, motion, 0.999 * found.joint_error)
        hit += displaced_hits(sound.world, sound.name, motion, 5 * found.joint_error)
    assert hit >= len(motions) / 3


def test_robustness_is_reported_only_if_proven_and_requested() -> None:
    world = bundled_world("ur5e_pickup")
    (sound,) = sound_motions(1, 8)
    deadline = no_hurry(30.0)
    assert certify(world.drake, sound.request, deadline)[1].robustness is None
    broken = replace(sound.request, start=sound.request.start + 0.1, options=ASKED)
    assert certify(world.drake, broken, deadline)[1].robustness is None
