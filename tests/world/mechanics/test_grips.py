"""Objects that are held by contact: carried by friction, and lost where friction is too small."""

import time
from dataclasses import replace

import numpy as np
import pytest

import planning
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.scene.grip import Grip
from planning.errors import GraspLost, ModelInvalid, ProblemInvalid, SceneInvalid
from planning.execute.execution import Execution
from planning.execute.runner import Runner
from planning.execute.simulated_driver import SimulatedDriver
from planning.world.mechanics.settle_grip import settle_grip
from planning.world.mechanics.simulation import Simulation
from tests.profiles import only_campaign, rng_of, seeds

GROUPS = {"ur5e": "arm::gripper", "panda": "arm::hand"}
SHAPES = {"ball": {"sphere": 0.02}, "bar": {"box": [0.03, 0.03, 0.1]}}
GRAVITY = 9.81


def deadline():
    return planning.Deadline.after(60.0, time.monotonic)


def open_world(model, shape, mass, ahead=0.0):
    """An open gripper around a thing, whose middle is so far ahead of the tool frame [m]."""
    document = {"name": "grip", "robots": [{"name": "arm", "model": model, "positions": "home"}]}
    empty = planning.load_world(planning.parse_scene(document))
    tool = empty.group(GROUPS[model]).tool_frames[0]
    place = empty.frame_pose(tool, empty.state) @ planning.Pose.from_parts([0.0, 0.0, ahead])
    pose = {"position": place.position.tolist(), "quaternion": place.quaternion.tolist()}
    thing = {"name": "thing", "shape": shape, "movable": True, "mass": mass, "pose": pose}
    document["objects"] = [{name: value for name, value in thing.items() if value is not None}]
    return planning.load_world(planning.parse_scene(document)), tool


def settled(model, grip, shape="ball", mass=0.3, ahead=0.0):
    """The grasp, how it settles, and the world in which it holds."""
    world, tool = open_world(model, SHAPES[shape], mass, ahead)
    grasp = planning.AttachObject("thing", tool, grip=grip)
    closing = planning.gripper_motion(
        world, GROUPS[model], planning.GripperCommand(grasp=grasp), deadline=deadline()
    )
    fingers = closing.trajectory.positions(np.array([closing.trajectory.duration]))[0]
    found = settle_grip(world, GROUPS[model], fingers, grasp)
    joint = world.group(GROUPS[model]).joints[0].name.partition("::")[2]
    edits = [
        planning.SetPositions("arm", {joint: float(found.positions[0])}),
        replace(grasp, pose=found.held.in_frame),
    ]
    held = planning.edit_scene(world.scene, edits, world.library)
    return found, planning.load_world(held, world.library)


def carried(world, delta, duration=0.9):
    """The runner and the simulation once the arm has moved by `delta` [rad]."""
    group = world.group("arm")
    coefficients = np.zeros((1, 6, group.num_velocities))
    for power, factor in ((3, 10.0), (4, -15.0), (5, 6.0)):
        coefficients[0, power] = factor * np.array(delta) / duration**power
    start = world.positions(group)[None]
    motion = TimedTrajectory(group.joints, np.array([0.0, duration]), start, coefficients)
    simulation = Simulation(world, group, motion.start)
    runner = Runner(Execution(motion, world.limits(group)), SimulatedDriver(simulation))
    runner.start(0.0)
    now = 0.0
    while not runner.is_done and now < 10.0:
        now += 0.02
        runner.tick(now)
    return runner, simulation


@pytest.mark.parametrize("model", GROUPS)
def test_a_thing_is_carried_by_friction_alone(model):
    grip = Grip(GROUPS[model], 40.0, 0.6, 0.005)
    found, world = settled(model, grip, "bar", ahead=0.02)
    assert found.held.slip < 1e-3
    assert not found.held.is_lost
    delta = [0.5, -0.3, 0.2, 0.2, 0.3, 0.4, 0.3][: world.group("arm").num_velocities]
    runner, simulation = carried(world, delta)
    assert runner.execution.state == "succeeded", runner.execution.failure
    (held,) = runner.status.held
    assert held.name == "thing"
    assert 0 < held.slip < grip.slip
    # It is where the tool is, which has moved: by forward kinematics of what was measured.
    full = world.embed(world.group("arm"), simulation.q)
    expected = world.frame_pose(held.frame, full) @ held.in_frame
    np.testing.assert_allclose(held.in_world.matrix, expected.matrix, atol=1e-9)
    before = world.frame_pose("thing", world.state)
    assert np.linalg.norm(held.in_world.position - before.position) > 0.1
    assert simulation.held[0].slip == held.slip


@only_campaign("ten simulations: 15 s")
@pytest.mark.parametrize("seed", seeds(4))
@pytest.mark.parametrize("model", GROUPS)
def test_a_ball_is_held_up_exactly_if_coulombs_friction_can_do_it(model, seed):
    """Two fingers carry m g if 2 mu F exceeds it; mu is of both surfaces, 2 a / (a + 1)."""
    rng = rng_of(seed)
    mass, force = rng.uniform(0.1, 1.0), rng.uniform(10.0, 60.0)
    limit = mass * GRAVITY / (2 * force)
    for share in (0.6, 1.6):
        mu = share * limit
        grip = Grip(GROUPS[model], force, mu / (2 - mu), 0.002)
        found, _ = settled(model, grip, mass=mass)
        assert found.held.is_lost == (share < 1), (mass, force, mu, found.held.slip)


def test_what_slips_is_lost_and_the_robot_comes_to_rest():
    # It holds while the arm rests, and not when that lifts it quickly.
    grip = Grip(GROUPS["ur5e"], 8.0, 0.085, 0.002)
    found, world = settled("ur5e", grip, mass=0.2)
    assert not found.held.is_lost
    runner, simulation = carried(world, [1.0, -0.8, 0.0, 0.0, 0.0, 0.0], duration=0.8)
    failure = runner.execution.failure
    assert isinstance(failure, GraspLost)
    assert failure.evidence["object"] == "thing"
    assert failure.evidence["slip"] > failure.evidence["bound"] == grip.slip
    assert 0.0 < failure.evidence["time"] < 0.8
    assert runner.execution.state == "aborted"
    assert np.abs(simulation.v).max() < 0.01
    (held,) = runner.status.held
    assert held.is_lost
    # The arm follows its path meanwhile: the load that it counts on is gone, and no more.
    assert runner.status.tracking_error < 0.01


def test_a_weld_slips_nowhere_and_costs_no_free_body():
    world, tool = open_world("ur5e", SHAPES["ball"], 0.3)
    held = planning.edit_scene(world.scene, [planning.AttachObject("thing", tool)], world.library)
    welded = planning.load_world(held, world.library)
    runner, simulation = carried(welded, [0.2] * 6)
    assert runner.execution.state == "succeeded"
    assert simulation.held == runner.status.held == ()


def test_what_cannot_be_held_by_contact_is_refused():
    grip = Grip(GROUPS["ur5e"], 20.0, 0.5, 0.005)
    with pytest.raises(ProblemInvalid, match="mass"):
        settled("ur5e", grip, mass=None)
    world, tool = open_world("ur5e", SHAPES["ball"], None)
    fingers = world.positions(world.group(GROUPS["ur5e"]))
    weightless = planning.AttachObject("thing", tool, grip=grip)
    with pytest.raises(ModelInvalid, match="mass"):
        settle_grip(world, GROUPS["ur5e"], fingers, weightless)
    world, tool = open_world("ur5e", SHAPES["ball"], 0.3)
    wrong = planning.AttachObject("thing", tool, grip=replace(grip, gripper="arm"))
    scene = planning.edit_scene(world.scene, [wrong], world.library)
    with pytest.raises(SceneInvalid) as fault:
        planning.load_world(scene, world.library)
    assert fault.value.evidence["path"] == "objects.0.attached.grip.gripper"
    weld = planning.AttachObject("thing", tool)
    fingers = world.positions(world.group(GROUPS["ur5e"]))
    with pytest.raises(ProblemInvalid, match="grip"):
        settle_grip(world, GROUPS["ur5e"], fingers, weld)


def test_a_grip_is_part_of_the_document():
    world, tool = open_world("ur5e", SHAPES["ball"], 0.3)
    grasp = planning.AttachObject("thing", tool, grip=Grip("arm::gripper", 20.0, 0.4, 0.01))
    scene = planning.edit_scene(world.scene, [grasp], world.library)
    document = planning.scene_document(scene)
    again = planning.parse_scene(document.model_dump())
    assert again.objects[0].attached == scene.objects[0].attached
    assert again.objects[0].attached.grip == grasp.grip
