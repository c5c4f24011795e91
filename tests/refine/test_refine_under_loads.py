"""Curves refined under loads are faster under them, as the model predicts."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from planning.domain.curves.curve import JointSpline
from planning.domain.curves.path import JointPath
from planning.domain.request.deadline import Deadline
from planning.domain.request.motion_limits import MotionLimits, ToolLimit
from planning.domain.request.options import RetimeOptions
from planning.refine.model.curve_model import CurveModel
from planning.refine.refine_problem import RefineProblem
from planning.refine.refiner import refine
from planning.retime.blend import blend_corners
from planning.retime.limits.request_limits import path_limits
from planning.retime.retimer import retime
from planning.world.world import World
from tests.clocks import no_hurry
from tests.profiles import pairs
from tests.refine.arms import ARMS, KINDS, arm_of, limits_of, request_of

# Two bars of 1 m in a vertical plane, with a weight at the end; stretched out ahead the shoulder
# needs 19 N m for the weight alone.
BARS = """<robot name="r"><link name="base"/><link name="upper"/><link name="lower">
<inertial><origin xyz="0 0 -1"/><mass value="1"/>
<inertia ixx="0.001" iyy="0.001" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>
<axis xyz="0 -1 0"/><limit lower="-4" upper="4" velocity="3" effort="{effort}"/></joint>
<joint name="elbow" type="revolute"><parent link="upper"/><child link="lower"/>
<origin xyz="0 0 -1"/><axis xyz="0 -1 0"/>
<limit lower="-3" upper="3" velocity="3" effort="100"/></joint></robot>"""

FAR_OUT = {"ur5e": 32, "panda": 15}


def deadline() -> Deadline:
    return no_hurry(60.0)


def path_of(name: str, kind: str) -> JointPath:
    """Return a path around a corner; where torques count, far out and back."""
    world, group = arm_of(name)
    q = world.positions(group)
    if kind == "torque":
        rng = np.random.default_rng(FAR_OUT[name])
        limits = world.limits(group)
        far = q + rng.normal(0.0, 0.7, len(q)), q + rng.normal(0.0, 1.0, len(q))
        return JointPath(group, np.clip([q, *far], limits.lower + 0.05, limits.upper - 0.05))
    corner = q + 0.2 * np.ones(len(q))
    return JointPath(group, np.stack([q, corner, q + np.linspace(0.7, -0.5, len(q))]))


def options_of(others: MotionLimits, method: str = "toppra") -> RetimeOptions:
    return RetimeOptions(
        method=method,
        tool_limits=others.tool_limits,
        speed_zones=others.speed_zones,
        acceleration_bounds=others.acceleration_bounds,
        effort=others.limits_effort,
        payload=others.payload,
    )


def seconds(world: World, path: JointPath, curve: JointSpline, others: MotionLimits) -> float:
    options = options_of(others)
    limits = path_limits(world, path.group, options)
    return retime(curve, world.limits(path.group), options, limits)[0].duration


CASES = pairs(list(ARMS), [*KINDS, "signed"])


def others_of(name: str, kind: str) -> MotionLimits:
    if kind != "signed":
        return limits_of(name, kind)
    _, group = arm_of(name)
    names = [block for block, _ in group.blocks]
    return MotionLimits(acceleration_bounds={names[1]: (-0.5, 3.0), names[3]: (-4.0, 0.8)})


@pytest.mark.campaign
@pytest.mark.parametrize(("name", "kind"), CASES)
def test_refined_curves_are_quicker_than_the_path_and_than_without_knowing(name, kind):
    (world, _), path, others = arm_of(name), path_of(name, kind), others_of(name, kind)
    request = request_of(world, path, others)
    curve, report = refine(world, request, deadline())
    assert curve is not None, report.reason
    refined = seconds(world, path, curve, others)
    assert report.duration_after == pytest.approx(refined, rel=0.02)
    assert report.lower_bound <= refined
    blind, _ = refine(world, replace(request, motion_limits=MotionLimits()), deadline())
    assert blind is not None
    known = blend_corners(path, 0.1, 1), blind
    assert refined < 0.995 * min(seconds(world, path, other, others) for other in known)


@pytest.mark.campaign
@pytest.mark.parametrize(("name", "kind"), CASES)
def test_small_steps_achieve_the_predicted_decrease(name, kind):
    """Together: a single one may end at a kink, where other limits bind beyond."""
    (world, _), path = arm_of(name), path_of(name, kind)
    task = RefineProblem.of(world, request_of(world, path, others_of(name, kind)), deadline())
    points = task.fit_path(0.15)
    model = CurveModel(task.distance_query, task.chart_limits, task.rate_bounds, len(points), 60)
    costs, promises = [model.evaluate(points).merit], []
    for _ in range(4):
        points, promised = model.step(model.evaluate(points), 0.001)
        promises.append(promised)
        costs.append(model.evaluate(points).merit)
    assert min(promises) > 0
    assert (np.diff(costs) < 0).all()
    assert 0.7 * sum(promises) < costs[0] - costs[-1] < 1.4 * sum(promises)


def bars_path(world: World) -> JointPath:
    """From hanging down to straight up, with the elbow almost stretched in between."""
    return JointPath(world.group("r"), np.array([[0.0, 0.0], [np.pi / 2, 0.3], [np.pi, 0.0]]))


def test_a_weight_that_no_stretched_arm_can_hold_is_lifted_bent(
    urdf_world: Callable[..., World],
):
    world = urdf_world(BARS.format(effort=15.0))
    path, others = bars_path(world), MotionLimits(limits_effort=True)
    curve, report = refine(world, request_of(world, path, others), deadline())
    assert curve is not None, report.reason
    elbow = np.abs(curve.positions(np.linspace(0.0, 1.0, 101))[:, 1])
    assert elbow.max() > 0.8
    assert seconds(world, path, curve, others) == pytest.approx(report.duration_after, rel=0.05)


def test_a_weight_that_cannot_be_held_at_the_goal_is_not_lifted(
    urdf_world: Callable[..., World],
):
    world = urdf_world(BARS.format(effort=15.0))
    path = JointPath(world.group("r"), np.array([[0.0, 0.0], [np.pi / 2, 0.0]]))
    curve, report = refine(
        world, request_of(world, path, MotionLimits(limits_effort=True)), deadline()
    )
    assert curve is None
    assert report.reason == "the static torque exceeds an effort limit at the start or the goal"


def test_a_weight_that_cannot_be_lifted_at_all_is_refused(urdf_world: Callable[..., World]):
    world = urdf_world(
        BARS.format(effort=15.0).replace('lower="-3" upper="3"', 'lower="-0.4" upper="0.4"')
    )
    path = bars_path(world)
    curve, report = refine(
        world, request_of(world, path, MotionLimits(limits_effort=True)), deadline()
    )
    assert curve is None
    assert "the static torque exceeds an effort limit" in report.reason


def test_no_motion_of_a_frame_beats_the_straight_way():
    (world, group), path = arm_of("ur5e"), path_of("ur5e", "speed")
    others = MotionLimits((ToolLimit("arm::tcp", speed=0.05),))
    task = RefineProblem.of(world, request_of(world, path, others), deadline())
    full = world.embed(group, path.waypoints[[0, -1]])
    ends = world.frame_poses("arm::tcp", full)[:, :3, 3]
    assert task.lower_bound == pytest.approx(np.linalg.norm(ends[1] - ends[0]) / 0.05)


def test_under_jerk_limits_both_signs_share_the_nearer_bound():
    (world, _), path = arm_of("ur5e"), path_of("ur5e", "speed")
    others = MotionLimits(acceleration_bounds={"arm::elbow_joint": (-0.5, 3.0)})
    task = RefineProblem.of(world, request_of(world, path, others, limits_jerk=True), deadline())
    np.testing.assert_array_equal(task.rate_bounds.acceleration_range, [[-1.0] * 6, [1.0] * 6])
