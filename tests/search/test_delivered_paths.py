"""Every state of every delivered path is free by Drake alone, whatever was asked for."""

from functools import partial

import numpy as np
import pytest

import planning
from planning.domain.request.options import SearchOptions
from planning.search.solver import SearchTask, search
from planning.world.collision.collision_check import DrakeCollisionOracle
from tests.clocks import no_hurry
from tests.search.conftest import each_kind_of_planner
from tests.search.test_solver import fine_samples

SCENE = """
robots: [{name: body, model: planar_l, positions: [-0.35, -0.3, 0]}]
objects:
  - {name: wall, shape: {box: [0.02, 0.5, 0.2]}, pose: {position: [0, -0.25, 0]}}
  - {name: post, shape: {cylinder: {radius: 0.03, length: 0.2}}, pose: {position: [0.2, 0.1, 0]}}
configurations: {beyond: {group: body, positions: [0.3, -0.3, 0]}}
"""
JOINT = "body::base_joint"
OPTIONS = {
    "plain": {},
    "weights": {"weights": {f"{JOINT}.angular": 0.3}},
    "weighted length": {"weights": {JOINT: 2.0}, "objective": "weighted_length"},
    "bounds": {"bounds": {f"{JOINT}.x": (-0.4, 0.4), f"{JOINT}.yaw": (-1.5, 1.5)}},
    "position": {"spaces": {JOINT: "position"}},
    "duration": {"objective": "duration", "attempts": 2},
    "clearance": {"objective": "clearance"},
    "no shortcut": {"shortcut_time": 0.0},
    "many states": {"num_states": 150, "keep_graph": True},
}


@pytest.fixture(scope="module")
def scene():
    world = planning.load_world(planning.parse_scene(SCENE))
    group = world.group("body")
    margins = world.margins()
    drake = DrakeCollisionOracle(world.drake, group, world.state, margins)
    return world, group, world.collision_oracle(group, margins), drake


def clearances_of(scene):
    from planning.world.collision.obstacle_distance import obstacle_distances

    return obstacle_distances(*scene[:2])


def free_path(scene, **options):
    world, group, oracle, drake = scene
    goals = world.configuration(group, "beyond")[None]
    task = SearchTask(
        start=world.positions(group),
        goals=goals,
        options=SearchOptions(**options),
        resolution=0.05,
        padding=0.0,
        seed=3,
        clearances=clearances_of(scene),
    )
    deadline = no_hurry(20.0)
    found = search(group, world.limits(group), oracle, task, deadline)
    for qs in fine_samples(group, found.path.waypoints, 0.05 / 4):
        assert all(drake.is_free(q) for q in qs)
    assert found.path.waypoints[0].tobytes() == task.start.tobytes()
    assert found.path.waypoints[-1].tobytes() == goals[0].tobytes()
    return found


@each_kind_of_planner
def test_by_every_planner(scene, name):
    assert not free_path(scene, planner=name).report.direct


@partial(each_kind_of_planner, among=("RRTConnect",))
@pytest.mark.parametrize("wish", OPTIONS)
def test_with_every_option(scene, name, wish):
    options = OPTIONS[wish]
    if name in {"FMT", "BFMT"} and "objective" in options:
        # They ask for the costs of more than all pairs: of 1,000 samples that takes minutes.
        options = {**options, "parameters": {"num_samples": 200}}
    free_path(scene, planner=name, **options)


def test_by_several_planners(scene):
    found = free_path(scene, planner=("RRTConnect", "KPIECE1", "PRM"))
    assert found.report.solved == 3


def test_clearance_is_that_of_the_robot_from_the_rest(scene):
    world, group = scene[:2]
    measure = clearances_of(scene)
    far, near = np.array([-0.9, 0.9, 0.0]), world.positions(group)
    distances = measure(np.stack([far, near]))
    assert distances[0] == 0.3
    probe = world.distance_probe(world.margins())
    nearest = probe.pairs_within(world.embed(group, near), 1.0)[0]
    assert distances[1] == pytest.approx(min(0.3, nearest.distance))
