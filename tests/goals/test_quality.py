"""Quality of configurations: manipulability, clearance, limit margin and arm branch."""

from itertools import pairwise

import numpy as np
import pytest

import planning
from planning.api.ik import assess_configurations
from planning.domain.geometry.pose import Pose
from planning.domain.goals.goal import PoseGoal
from planning.goals.arm_branch import branch_of
from planning.goals.joint_metric import JointMetric
from planning.goals.quality import QualityProbe
from planning.world.mechanics.tool_kinematics import ToolKinematics
from tests.clocks import no_hurry
from tests.goals.conftest import at, world_by

GOAL: PoseGoal = at(Pose.from_parts([0.45, 0.25, 0.45], rpy=[np.pi, 0, 0.3]))
SIGNS = [(s, e, w) for s in (-1, 1) for e in (-1, 1) for w in (-1, 1)]


def signs_of(branch: object) -> tuple[int, int, int]:
    return branch.shoulder, branch.elbow, branch.wrist


def probe_of(world: object, group: object) -> QualityProbe:
    metric = JointMetric.from_names(group, {})
    return QualityProbe(world, group, group.tool_frames[0], metric)


def test_the_eight_branches_of_a_ur_are_its_eight_solutions() -> None:
    world = world_by("ur5e_pickup", "kernel")
    deadline = no_hurry(20.0)
    found = planning.solve_ik(world, "arm", GOAL, deadline=deadline)
    qualities = assess_configurations(world, "arm", found.positions)
    turns = np.round(np.remainder(found.positions + 1e-4, 2 * np.pi), 3)
    by_branch: dict[tuple[int, int, int], set[tuple[float, ...]]] = {}
    for q, quality in zip(turns, qualities, strict=True):
        by_branch.setdefault(signs_of(quality.branch), set()).add(tuple(q))
    assert sorted(by_branch) == SIGNS
    assert all(len(rows) == 1 for rows in by_branch.values())
    distances = [quality.distance for quality in qualities]
    assert all(a <= b + 1e-9 for a, b in pairwise(distances))


def test_the_three_signs_are_the_sign_of_the_jacobians_determinant() -> None:
    world = world_by("ur5e_pickup", "kernel")
    group = world.group("arm")
    probe = probe_of(world, group)
    kinematics = ToolKinematics(world, group, group.tool_frames[0])
    rng = np.random.default_rng(3)
    ratios = set()
    for q in rng.uniform(-np.pi, np.pi, (60, 6)):
        quality = probe.evaluate(q, q)
        determinant = float(np.linalg.det(kinematics.velocity_jacobians(q[None])[0]))
        assert quality.manipulability == pytest.approx(abs(determinant), rel=1e-9)
        ratios.add(int(np.prod(signs_of(quality.branch)) * np.sign(determinant)))
    assert len(ratios) == 1


def test_a_singularity_has_no_sign() -> None:
    world = world_by("ur5e_pickup", "kernel")
    group = world.group("arm")
    q = np.array([0.3, -1.2, 0.0, 0.4, 0.7, 0.1])
    stretched = probe_of(world, group).evaluate(q, q)
    assert stretched.branch.elbow == 0
    assert abs(stretched.branch.shoulder * stretched.branch.wrist) == 1
    assert stretched.manipulability < 1e-9


def spherical_arm(q: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return axes, points and Jacobian of a PUMA-like arm with a shoulder that is offset."""
    joints = [  # axis, and where the next joint is
        ([0, 0, 1], [0.1, 0.15, 0.6]),
        ([0, 1, 0], [0, 0.02, 0.5]),
        ([0, 1, 0], [0.05, 0.0, 0.4]),
        ([0, 0, 1], [0, 0, 0]),
        ([0, 1, 0], [0, 0, 0]),
        ([0, 0, 1], [0, 0, 0.1]),
    ]
    x, axes, points = np.eye(4), [], []
    for (axis, offset), angle in zip(joints, q, strict=True):
        axes.append(x[:3, :3] @ axis)
        points.append(x[:3, 3].copy())
        turn = Pose.from_parts(quaternion=[np.cos(angle / 2), *np.sin(angle / 2) * np.array(axis)])
        x = x @ turn.matrix @ Pose.from_parts(offset).matrix
    z, p = np.array(axes), np.array(points)
    return z, p, np.vstack([np.cross(z, x[:3, 3] - p).T, z.T])


def test_spherical_wrists_have_branches_too() -> None:
    rng = np.random.default_rng(5)
    ratios, seen = set(), set()
    for q in rng.uniform(-np.pi, np.pi, (80, 6)):
        z, p, jacobian = spherical_arm(q)
        branch = branch_of(z, p)
        seen.add(signs_of(branch))
        ratios.add(int(np.prod(signs_of(branch)) * np.sign(np.linalg.det(jacobian))))
    assert len(ratios) == 1
    assert sorted(seen) == SIGNS


def test_other_arms_have_no_branch() -> None:
    world = world_by("panda_shelf", "kernel")
    group = world.groups[0]
    q = world.positions(group)
    (quality,) = assess_configurations(world, group.name, q[None])
    assert quality.branch is None
    z, p, _ = spherical_arm(np.full(6, 0.4))
    assert branch_of(z, p + np.eye(6, 3, -3) * 0.1) is None


def test_clearance_is_what_checking_says_and_limit_margins_shrink_to_zero() -> None:
    world = world_by("ur5e_pickup", "kernel")
    group = world.group("arm")
    limits = world.limits(group)
    rows = np.random.default_rng(0).uniform(limits.lower / 2, limits.upper / 2, (10, 6))
    verdicts = planning.check_configurations(world, "arm", rows)
    for quality, verdict in zip(assess_configurations(world, "arm", rows), verdicts, strict=True):
        assert quality.clearance == pytest.approx(verdict.nearest.distance, abs=1e-9)
        assert quality.pair == verdict.nearest.bodies
        assert quality.limit_margin >= 0.25 - 1e-9
    (edge,) = assess_configurations(world, "arm", limits.upper[None])
    assert edge.limit_margin == 0.0
