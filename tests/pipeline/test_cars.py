"""Cars in all stages: planned, timed, certified, and checked by independent means."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import planning
from planning.domain.report.motion_plan import MotionPlan
from planning.errors import NotCertified, ProblemInvalid
from planning.world.collision.collision_check import DrakeCollisionOracle
from planning.world.world import World
from tests.clocks import no_hurry
from tests.drivers import assert_driven, body_velocities

JOINT = "car::base_joint"
TRUCK = """
<robot name="truck">
  <link name="origin"/>
  <link name="body">
    <inertial><mass value="2"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/>
    </inertial>
    <collision><origin xyz="0.1 0 0.05"/><geometry><box size="0.3 0.16 0.06"/></geometry>
    </collision>
  </link>
  <link name="arm">
    <inertial><mass value="1"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/>
    </inertial>
    <collision><origin xyz="0.1 0 0.15"/><geometry><box size="0.25 0.04 0.04"/></geometry>
    </collision>
  </link>
  <joint name="drive" type="planar">
    <parent link="origin"/><child link="body"/><axis xyz="0 0 1"/>
  </joint>
  <joint name="shoulder" type="revolute">
    <parent link="body"/><child link="arm"/><axis xyz="0 0 1"/>
    <limit lower="-2" upper="2" velocity="2" effort="10"/>
  </joint>
</robot>
"""
CARD = """
name: truck
file: truck.urdf
base: origin
default_group: all
groups: {all: {joints: [drive, shoulder]}, arm: {joints: [shoulder]}}
limits:
  drive:
    position: {x: [-1.5, 1.5], y: [-1.0, 1.0]}
    steering: {turning_radius: 0.25}
"""


@pytest.fixture(scope="module")
def street() -> World:
    path = planning.bundled_folder("scenes") / "parallel_parking.scene.yaml"
    return planning.load_world(planning.read_scene(path))


def planned(world: World, end: np.ndarray | str, **fields: object) -> MotionPlan:
    goal = (
        planning.ConfigurationGoal(end)
        if isinstance(end, str)
        else planning.JointGoal(np.atleast_2d(end))
    )
    group = world.groups[0].name
    problem = replace(planning.PlanningProblem(group, goal, seed=1), **fields)
    return planning.plan(problem, world, deadline=no_hurry(30.0))


def assert_free(world: World, motion: MotionPlan) -> None:
    margins = world.margins()
    drake = DrakeCollisionOracle(world.drake, motion.group, world.state, margins)
    times = np.linspace(0.0, motion.trajectory.duration, 400)
    assert drake.are_free(motion.trajectory.positions(times)).all()


@pytest.mark.parametrize("method", ["toppra", "ruckig"])
def test_a_car_parks_in_a_gap(street: World, method: str) -> None:
    timing = planning.RetimeOptions(method="ruckig" if method == "ruckig" else "toppra")
    motion = planned(street, "parked", retime=timing)
    assert motion.certificate.proven
    assert_driven(motion.trajectory, 0.3, reverse=True)
    assert body_velocities(motion.trajectory)[:, 0].min() < -0.05
    assert_free(street, motion)
    assert motion.stages.refine.improved
    assert motion.stages.retime.blend_deviation == 0.0
    (check,) = [check for check in motion.certificate.checks if "steering" in check.name]
    assert check.passed


def test_the_same_problem_has_the_same_bytes(street: World) -> None:
    assert planned(street, "parked").digest == planned(street, "parked").digest


def test_a_request_makes_it_drive_forwards_only(street: World) -> None:
    car = {JOINT: planning.Steering(0.35, reverse=False)}
    motion = planned(street, "passed", search=planning.SearchOptions(spaces=car))
    assert_driven(motion.trajectory, 0.35, reverse=False)
    assert_free(street, motion)


def test_a_car_of_a_request_alone(world_of: object) -> None:
    """A body that could slide any way keeps to the arcs that are asked for."""
    text = "robots: [{name: body, model: planar_l, positions: [-0.3, -0.3, 0]}]"
    world = planning.load_world(planning.parse_scene(text))
    car = {"body::base_joint": planning.Steering(0.1, reverse=False)}
    search = planning.SearchOptions(spaces=car)
    motion = planned(world, np.array([-0.3, 0.2, 1.0]), search=search)
    assert_driven(motion.trajectory, 0.1, reverse=False)
    certificate, _ = planning.certify_trajectory(
        world, "body", motion.trajectory, deadline=no_hurry(10.0)
    )
    assert certificate.proven
    assert not [check for check in certificate.checks if "steering" in check.name]


@pytest.mark.parametrize("reverse", [True, False])
def test_the_way_back_is_driven_by_the_car_that_was_asked_for(reverse: bool) -> None:
    text = "robots: [{name: body, model: planar_l, positions: [-0.3, -0.3, 0]}]"
    world = planning.load_world(planning.parse_scene(text))
    car = {"body::base_joint": planning.Steering(0.1, reverse)}
    end = planning.JointGoal(np.array([[-0.3, 0.2, 1.0]]))
    problem = planning.PlanningProblem("body", end, search=planning.SearchOptions(spaces=car))
    soon = no_hurry(30.0)
    there = planning.plan(problem, world, deadline=soon)
    motion = there.path, there.trajectory, there.parts
    if not reverse:
        with pytest.raises(NotCertified, match=r"steering body::base_joint .* reverse"):
            planning.reverse_plan(world, problem, *motion, soon)
        return
    back = planning.reverse_plan(world, problem, *motion, soon)
    assert "steering body::base_joint" in {check.name for check in back.certificate.checks}
    assert back.path.length == pytest.approx(there.path.length)
    assert_driven(back.trajectory, 0.1, reverse=True)


def test_a_pose_is_reached_as_well(street: World) -> None:
    pose = planning.Pose(np.array([0.5, 0.1, 0.0]), np.array([1.0, 0.0, 0.0, 0.0]))
    exactly = np.zeros(3)
    goal = planning.PoseGoal((planning.PoseTarget(pose),), "car::body", exactly, exactly)
    problem = planning.PlanningProblem("car", goal)
    motion = planning.plan(problem, street, deadline=no_hurry(30.0))
    assert motion.goal_configuration[:2] == pytest.approx([0.5, 0.1], abs=1e-5)
    assert_driven(motion.trajectory, 0.3, reverse=True)


def test_waypoints_of_others_are_followed_on_arcs_or_refused(street: World) -> None:
    start = np.array([-0.9, 0.0, 0.0])
    deadline = no_hurry(30.0)
    # A quarter of a turn has its end as far ahead as aside.
    turned = np.array([-0.9 + 0.4 * np.sin(0.5), 0.4 * (1 - np.cos(0.5)), 0.5])
    done = planning.retime_path(street, "car", [start, turned], deadline=deadline)
    assert_driven(done.trajectory, 0.3, reverse=True)
    turned[2] += 0.1
    with pytest.raises(NotCertified, match=f"steering {JOINT}"):
        planning.retime_path(street, "car", [start, turned], deadline=deadline)


def test_what_a_robot_cannot_drive_is_refused(street: World) -> None:
    tighter = {JOINT: planning.Steering(0.2)}
    with pytest.raises(ProblemInvalid, match="turning radius"):
        planned(street, "passed", search=planning.SearchOptions(spaces=tighter))
    forwards = {JOINT: planning.Steering(0.3, reverse=False)}
    search = planning.SearchOptions(planner="PRM", spaces=forwards)
    with pytest.raises(ProblemInvalid, match="RRTConnect"):
        planned(street, "passed", search=search)


def test_searches_along_straight_lines_are_refused(street: World) -> None:
    with pytest.raises(ProblemInvalid, match="cannot follow"):
        planned(street, "passed", search=planning.SearchOptions(planner="GCS"))


def test_a_roadmap_of_drives_is_for_cars_that_drive_backwards(street: World) -> None:
    few = planning.RoadmapOptions(states=30, neighbours=4)
    forwards = {JOINT: planning.Steering(0.3, reverse=False)}
    with pytest.raises(ProblemInvalid, match="cannot drive backwards") as caught:
        planned(street, "passed", search=planning.SearchOptions(roadmap=few, spaces=forwards))
    assert caught.value.evidence["field"] == "search.roadmap"
    found = planned(street, "parked", search=planning.SearchOptions(roadmap=few))
    assert found.certificate.proven
    assert found.stages.search.roadmap.num_edges > 30


def shoulder_of(motion: MotionPlan) -> np.ndarray:
    """Where the truck's arm is all along a motion."""
    trajectory = motion.trajectory
    return trajectory.positions(np.linspace(0.0, trajectory.duration, 400))[:, 3]


def test_a_car_with_an_arm(tmp_path: Path) -> None:
    """The base drives, the arm keeps pace; alone, the arm is an arm."""
    folder = tmp_path / "truck"
    folder.mkdir()
    (folder / "truck.urdf").write_text(TRUCK)
    (folder / "robot.yaml").write_text(CARD)
    text = """
    robots: [{name: truck, model: truck, positions: {drive: [-0.8, 0, 0], shoulder: 0}}]
    objects:
      - {name: post, shape: {cylinder: {radius: 0.1, length: 0.4}}, pose: {position: [0, 0, 0.2]}}
    """
    library = planning.ModelLibrary((tmp_path,))
    world = planning.load_world(planning.parse_scene(text), library)
    constraints = (planning.TightLimits({"truck::shoulder": (-1.6, 1.6)}),)
    motion = planned(world, np.array([0.8, 0.1, 0.3, 1.5]), constraints=constraints)
    assert motion.certificate.proven
    assert motion.stages.refine.improved
    assert np.abs(shoulder_of(motion)).max() <= 1.6
    assert_driven(motion.trajectory, 0.25, reverse=True)
    assert_free(world, motion)
    locked = (planning.LockedJoints(("truck::shoulder",)),)
    still = planned(world, np.array([0.8, 0.1, 0.3, 0.0]), constraints=locked)
    assert_driven(still.trajectory, 0.25, reverse=True)
    assert np.ptp(still.path.waypoints[:, 3]) == 0.0
    assert np.ptp(shoulder_of(still)) == 0.0
    arm = planning.PlanningProblem("truck::arm", planning.JointGoal(np.array([[1.0]])))
    alone = planning.plan(arm, world, deadline=no_hurry(30.0))
    assert not [check for check in alone.certificate.checks if "steering" in check.name]
