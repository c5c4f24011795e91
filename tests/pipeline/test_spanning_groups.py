"""Groups that span robots: planned, searched, refined, timed and certified as one."""

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import planning
from planning import GroupMotion
from planning.domain.goals.goal import PoseTarget
from planning.domain.request.options import IkOptions, RoadmapOptions, SearchOptions
from planning.goals.joint_metric import JointMetric
from planning.goals.quality import QualityProbe
from planning.world.world import World
from tests.certify.conftest import smallest_distance
from tests.clocks import no_hurry
from tests.discs import RADIUS, discs, straight
from tests.profiles import rng_of

ARMS = """
robots:
  - {name: l, model: irb120, positions: ready, base: {position: [0, 0.35, 0]}}
  - {name: r, model: irb120, positions: ready, base: {position: [0, -0.35, 0]}}
objects:
  - {name: table, shape: {box: [1.4, 1.8, 0.05]}, pose: {position: [0.25, 0, -0.027]}}
groups: {both: [l, r]}
"""
EXACT = np.zeros(3)


@cache
def arms() -> World:
    return planning.load_world(planning.parse_scene(ARMS))


def _plan(world: World, group: str, goal: Any, **more: Any) -> planning.MotionPlan:
    problem = planning.PlanningProblem(group, goal, **more)
    return planning.plan(problem, world, deadline=no_hurry())


def _down(frame: str, xyz: list[float]) -> planning.PoseGoal:
    target = PoseTarget(planning.Pose.from_parts(xyz, rpy=[np.pi, 0.0, 0.0]))
    return planning.PoseGoal((target,), frame, EXACT, EXACT)


@pytest.mark.parametrize("options", [{}, {"roadmap": RoadmapOptions(states=300)}])
def test_two_discs_change_places(tmp_path: Path, options: Any) -> None:
    """In a corridor in which they cannot pass each other's places in a straight line."""
    walls = """objects:
  - {name: north, shape: {box: [2, 0.1, 0.2]}, pose: {position: [0, 0.35, 0]}}
  - {name: south, shape: {box: [2, 0.1, 0.2]}, pose: {position: [0, -0.35, 0]}}
configurations: {swapped: {group: a+b, positions: [0.5, 0, -0.5, 0]}}
"""
    world = discs(tmp_path, {"a": (-0.5, 0), "b": (0.5, 0)}, more=walls)
    found = _plan(
        world, "a+b", planning.ConfigurationGoal("swapped"), search=SearchOptions(**options)
    )
    assert found.certificate.proven
    assert found.trajectory.end == pytest.approx([0.5, 0, -0.5, 0])
    times = np.linspace(0, found.trajectory.duration, 2_001)
    q = found.trajectory.positions(times)
    distance = np.linalg.norm(q[:, :2] - q[:, 2:], axis=1).min() - 2 * RADIUS
    assert distance > 0
    assert found.certificate.min_clearance <= distance + 1e-9
    limits = world.limits(world.group("a+b"))
    assert (np.abs(found.trajectory.velocities(times)) <= limits.velocity + 1e-9).all()


def test_one_tool_goes_to_its_pose_and_the_other_arm_ends_where_it_was() -> None:
    world = arms()
    for frame, own, other in (
        ("l::tcp", slice(0, 6), slice(6, 12)),
        ("r::tcp", slice(6, 12), slice(0, 6)),
    ):
        goal = _down(frame, [0.36, 0.05, 0.25])
        found = _plan(world, "both", goal)
        start = world.positions(world.group("both"))
        assert found.certificate.proven
        assert found.trajectory.end[other].tolist() == start[other].tolist()
        assert np.abs(found.trajectory.end[own] - start[own]).max() > 0.05
        pose = world.frame_pose(frame, world.embed(found.group, found.trajectory.end))
        assert pose.position == pytest.approx([0.36, 0.05, 0.25], abs=1e-5)


def test_the_other_arm_moves_away_if_the_tool_cannot_reach_its_pose_else() -> None:
    """The right arm stands where the left tool shall go."""
    world = arms()
    reach = planning.solve_ik(
        world, "r", _down("r::tcp", [0.36, 0.05, 0.15]), deadline=no_hurry(), seed=1
    )
    blocked = planning.edit_scene(
        world.scene, [planning.SetPositions("r", tuple(map(float, reach.entries[0])))]
    )
    world = planning.load_world(blocked)
    found = _plan(world, "both", _down("l::tcp", [0.36, 0.06, 0.15]))
    start = world.positions(world.group("both"))
    assert found.certificate.proven
    assert np.abs(found.trajectory.end[6:] - start[6:]).max() > 0.1


def test_inverse_kinematics_names_the_branch_of_the_arm_that_has_the_tool() -> None:
    world = arms()
    group, one = world.group("both"), world.group("r")
    probe, alone = (
        QualityProbe(world, each, "r::tcp", JointMetric.from_names(each, {}))
        for each in (group, one)
    )
    q = world.positions(group)
    found, expected = probe.evaluate(q, q), alone.evaluate(q[6:], q[6:])
    assert found.branch is not None
    assert found.branch == expected.branch
    assert found.manipulability == pytest.approx(expected.manipulability)


def test_no_more_configurations_than_those_of_the_arm_that_moves() -> None:
    """Whole turns of the arm that stays would be goals of their own, each farther away."""
    world = arms()
    goal = _down("l::tcp", [0.36, 0.3, 0.25])
    found = planning.solve_ik(
        world, "both", goal, deadline=no_hurry(), options=IkOptions(max_configurations=50)
    )
    start = world.positions(world.group("both"))
    assert len(found.entries) > 1
    assert (found.entries[:, 6:] == start[6:]).all()


def test_a_line_of_one_tool_leaves_the_other_arm_alone() -> None:
    world = arms()
    target = PoseTarget(planning.Pose.from_parts([0, 0, 0.08]), frame="l::tcp")
    found = _plan(world, "both", planning.LineGoal((target,), "l::tcp"))
    assert found.certificate.proven
    start = world.positions(world.group("both"))
    assert np.abs(found.trajectory.end[6:] - start[6:]).max() < 1e-9


def test_a_path_of_both_arms_is_timed_and_certified() -> None:
    world = arms()
    start = world.positions(world.group("both"))
    path = np.stack([start, start + np.tile([0.2, 0.1, -0.1, 0.0, 0.1, 0.2], 2)])
    found = planning.retime_path(world, "l+r", path, deadline=no_hurry())
    assert found.certificate.proven
    certificate, _ = planning.certify_trajectory(
        world, "both", found.trajectory, deadline=no_hurry()
    )
    assert certificate.proven
    backwards, _ = planning.certify_trajectory(
        world, "r+l", _swapped(world, found.trajectory), deadline=no_hurry()
    )
    assert backwards.min_clearance == pytest.approx(certificate.min_clearance, abs=2e-3)


def _swapped(world: World, motion: planning.TimedTrajectory) -> planning.TimedTrajectory:
    """Return the motion with the arms' coordinates in the other order."""
    order = [*range(6, 12), *range(6)]
    return planning.TimedTrajectory(
        world.group("r+l").joints,
        motion.breaks,
        motion.bases[:, order],
        motion.coefficients[:, :, order],
    )


@given(seed=st.integers(0, 2**32 - 1))
def test_no_measured_distance_of_two_arms_is_below_what_is_proven(seed: int) -> None:
    """Of motions that are combined with any delay; what is refused is measured to be too near."""
    world, rng = arms(), rng_of(seed)
    motions = []
    for name in ("l", "r"):
        start = world.positions(world.group(name))
        turn = rng.uniform(0.6, 1.4) * (-1 if name == "l" else 1)
        goal = start + np.append(
            turn, rng.uniform([0.2, -0.4, -1, -0.5, -1], [0.7, 0.1, 1, 0.5, 1])
        )
        legs = np.stack([start, goal, start + rng.uniform(-0.3, 0.3, 6)])
        motions.append(GroupMotion(name, straight(world, name, *legs), float(rng.uniform(0, 2))))
    whole = planning.combine_motions(world, motions)
    certificate, _ = planning.certify_trajectory(
        world, whole.group, whole.trajectory, deadline=no_hurry()
    )
    measured = smallest_distance(world, whole.trajectory, whole.group, 0.02)
    if "clearance" in {check.name for check in certificate.failed}:
        assert certificate.observed_clearance <= max(measured, 1e-6)
    else:
        assert certificate.min_clearance <= measured + 1e-6
