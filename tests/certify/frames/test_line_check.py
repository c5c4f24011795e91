"""The line check: its value bounds the deviation at every instant, tightly."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planning.certify.certifier import CertifyRequest, certify
from planning.certify.frames.line_check import line_checks
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.geometry import rotation
from planning.domain.geometry.pose import Pose
from planning.domain.goals.linear_moves import LineSection, ToolLine
from planning.domain.report.certificate import Check
from planning.domain.robot.manifold import Manifold
from planning.world.world import World
from tests.certify.conftest import quintic, request_for
from tests.clocks import no_hurry
from tests.conftest import bundled_world
from tests.profiles import num_cases

DENSE = 300


def checks_of(
    world: World,
    request: CertifyRequest,
    line: ToolLine,
    allowed: tuple[float, float] = (0.05, 0.3),
) -> dict[str, Check]:
    section = LineSection(line, 0.0, request.trajectory.duration, *allowed)
    limited = replace(request, lines=(section,))
    deadline = no_hurry(30)
    return {check.name: check for check in line_checks(world.drake, limited, deadline)}


def between_ends(world: World, name: str, frame: str, motion: TimedTrajectory) -> ToolLine:
    group = world.group(name)
    first, last = (
        world.frame_pose(frame, world.embed(group, q)) for q in (motion.start, motion.end)
    )
    return ToolLine(frame, first, last)


def measured(
    world: World, name: str, line: ToolLine, motion: TimedTrajectory
) -> tuple[float, float]:
    """Return the largest distances from a line at many instants, pose by pose."""
    q = motion.positions(np.linspace(0, motion.duration, DENSE))
    x = world.frame_poses(line.frame, world.embed(world.group(name), q))
    fractions = (x[:, :3, 3] - line.begin.position) @ line.translation / line.length**2
    nearest = line.begin.position + np.clip(fractions, 0, 1)[:, None] * line.translation
    turned = rotation.exp(fractions[:, None] * line.rotation_vector)
    expected = rotation.matrix(rotation.multiply(line.begin.quaternion[None], turned))
    cosines = (np.einsum("nij,nij->n", x[:, :3, :3], expected) - 1) / 2
    turns = np.arccos(np.clip(cosines, -1, 1))
    return float(np.linalg.norm(x[:, :3, 3] - nearest, axis=1).max()), float(turns.max())


@pytest.mark.parametrize(
    ("scene", "name", "frame", "size"),
    [
        ("ur5e_pickup", "arm", "arm::tcp", 0.3),
        ("panda_shelf", "panda", "panda::panda_hand_tcp", 0.3),
        ("window_3d", "body", "body::body", 0.4),
    ],
)
@given(seed=st.integers(0, 200))
@settings(max_examples=num_cases(2))
def test_values_bound_the_deviation_at_every_instant_tightly(
    scene: str, name: str, frame: str, size: float, seed: int
) -> None:
    world = bundled_world(scene)
    group = world.group(name)
    q0 = world.positions(group)
    delta = np.random.default_rng(seed).uniform(-size, size, group.num_velocities)
    motion = quintic(group, q0, Manifold(group.joints).plus(q0, delta), 1.0)
    line = between_ends(world, name, frame, motion)
    allowed = (0.01, 0.02)
    found = checks_of(world, request_for(world, name, motion), line, allowed)
    shift, turn = measured(world, name, line, motion)
    assert shift <= found["line"].value <= 1.001 * shift + 0.03 * allowed[0]
    assert turn - 1e-7 <= found["line rotation"].value <= 1.01 * turn + 0.03 * allowed[1]
    assert found["line"].passed == (found["line"].value <= allowed[0])


def test_a_motion_on_its_line_passes_and_beside_it_fails() -> None:
    world = bundled_world("window_3d")
    group = world.group("body")
    q0 = world.positions(group)
    q1 = np.array(q0)
    q1[4] += 0.2
    motion = quintic(group, q0, q1, 1.0)
    line = between_ends(world, "body", "body::body", motion)
    good = checks_of(world, request_for(world, "body", motion), line, (1e-3, 1e-2))
    assert good["line"].passed
    assert good["line rotation"].passed
    aside = ToolLine(
        line.frame,
        line.begin,
        Pose(line.end.position + np.array([0, 2e-3, 0]), line.end.quaternion),
    )
    bad = checks_of(world, request_for(world, "body", motion), aside, (1e-3, 1e-2))
    assert not bad["line"].passed
    assert bad["line"].value == pytest.approx(2e-3, rel=0.05)


def test_a_pure_rotation_must_keep_its_axis() -> None:
    world = bundled_world("window_3d")
    group = world.group("body")
    manifold, q0 = Manifold(group.joints), world.positions(group)
    turn = np.array([0, 0, 0.8, 0, 0, 0])
    motion = quintic(group, q0, manifold.plus(q0, turn), 1.0)
    line = between_ends(world, "body", "body::body", motion)
    assert checks_of(world, request_for(world, "body", motion), line)["line rotation"].value < 0.01
    other = quintic(group, q0, manifold.plus(q0, np.array([0, 0.3, 0.8, 0, 0, 0])), 1.0)
    found = checks_of(world, request_for(world, "body", other), line)
    assert found["line rotation"].value > 0.25


def test_line_checks_exist_only_with_lines() -> None:
    world = bundled_world("window_3d")
    group = world.group("body")
    q0 = world.positions(group)
    q1 = np.array(q0)
    q1[5] += 0.1
    motion = quintic(group, q0, q1, 2.0)
    request = request_for(world, "body", motion)
    deadline = no_hurry(30)
    plain, _ = certify(world.drake, request, deadline)
    assert not [check for check in plain.checks if check.name.startswith("line")]
    line = between_ends(world, "body", "body::body", motion)
    wrong = ToolLine(line.frame, line.end, line.end)
    section = LineSection(wrong, 0.0, motion.duration, 1e-3, 1e-2)
    limited = replace(request, lines=(section,))
    refused, _ = certify(world.drake, limited, deadline)
    assert not refused.proven
    assert [check.name for check in refused.failed] == ["line"]
