"""Roadmaps shared by plans: the same bytes built, from memory and from disk; one per world."""

import os
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

import planning
from planning.domain.geometry.pose import Pose
from planning.domain.goals.goal import ConfigurationGoal, JointGoal, LineGoal, PoseTarget
from planning.domain.request.options import RefineOptions, RoadmapOptions, SearchOptions
from planning.domain.request.problem import PlanningProblem
from planning.domain.robot.manifold import Manifold
from planning.domain.scene.scene_operation import MoveObject, SetPositions
from planning.errors import DeadlineExceeded, ProblemInvalid
from planning.roadmaps.roadmap_cache import RoadmapCache
from tests.clocks import after_looks, no_hurry
from tests.conftest import bundled_world
from tests.profiles import only_campaign

SMALL = RoadmapOptions(states=600, neighbours=8)


def problem_of(seed=0, group="body", goal="exit", **options):
    return PlanningProblem(
        group,
        ConfigurationGoal(goal),
        search=SearchOptions(**{"allowed_planning_time": 30.0, "roadmap": SMALL, **options}),
        refine=RefineOptions("none"),
        seed=seed,
    )


def solve(world, problem, roadmaps=None):
    deadline = no_hurry(30.0)
    return planning.plan(problem, world, deadline=deadline, roadmaps=roadmaps)


@pytest.fixture(scope="module")
def maze():
    return bundled_world("maze_2d")


@pytest.fixture(scope="module")
def roadmap(maze):
    deadline = no_hurry(30.0)
    return planning.build_roadmap(problem_of(), maze, deadline=deadline)


SCRIPT = """
import sys
from pathlib import Path
from tests.roadmaps.test_load_or_build import RoadmapCache, bundled_world, problem_of, solve
for folder in sys.argv[1:]:
    shelf = RoadmapCache(folder=Path(folder))
    found = solve(bundled_world("maze_2d"), problem_of(4), shelf)
    print(found.digest, found.stages.search.roadmap.digest, "roadmap_build" in found.timings)
"""


@only_campaign("6 s")
def test_cold_warm_and_disk_give_the_same_bytes_in_any_process(maze, tmp_path):
    problem, shelf = problem_of(4), RoadmapCache(folder=tmp_path)
    cold, warm = solve(maze, problem, shelf), solve(maze, problem, shelf)
    disk = solve(maze, problem, RoadmapCache(folder=tmp_path))
    plans = cold, warm, disk
    assert ["roadmap_build" in found.timings for found in plans] == [True, False, False]
    assert cold.stages.search.roadmap.used
    assert len({found.digest for found in plans}) == 1
    assert cold.stages == warm.stages == disk.stages
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, str(tmp_path), str(tmp_path / "empty")],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "PYTHONHASHSEED": "17"},
    )
    told = [cold.digest, cold.stages.search.roadmap.digest]
    assert done.stdout.split() == [*told, "False", *told, "True"]


@pytest.mark.parametrize(("scene", "group"), [("maze_2d", "body"), ("panda_shelf", "panda")])
def test_every_edge_is_free_by_drake_alone(scene, group):
    world = bundled_world(scene)
    options = RoadmapOptions(states=60, neighbours=6)
    problem = replace(problem_of(roadmap=options), group=group)
    built = planning.build_roadmap(problem, world, deadline=no_hurry(30.0))
    assert len(built.edges) > 30
    joints = world.group(group)
    manifold = Manifold(joints.joints)
    drake = planning.load_world(world.scene, kernel=False)
    judge = drake.collision_oracle(joints, drake.margins())
    for i, j in built.edges[:60]:
        a, b = built.states[[i, j]]
        count = int(np.ceil(float(manifold.distance(b, a)) / 0.02))
        assert judge.are_free(manifold.interpolate(a, b, np.linspace(0.0, 1.0, count + 1))).all()


def test_a_second_query_takes_a_small_share_of_the_checks_of_the_first(maze, roadmap):
    shelf = RoadmapCache([roadmap])
    for seed in range(4):
        report = solve(maze, problem_of(seed), shelf).stages.search
        assert report.roadmap.num_states_checked == roadmap.num_states_checked
        first = roadmap.num_states_checked + report.num_states_checked
        assert report.num_states_checked < first / 2


def test_the_seed_of_a_plan_its_start_and_its_goal_share_a_roadmap(maze, roadmap):
    deadline = no_hurry(30.0)
    free = roadmap.states[:2]
    others = [
        problem_of(9),
        replace(problem_of(), start=free[0], goal=JointGoal(free[1:])),
        problem_of(attempts=3, planner="PRM", allowed_planning_time=9.0),
    ]
    for other in others:
        assert planning.build_roadmap(other, maze, deadline=deadline) == roadmap


def test_what_a_robot_has_around_it_changes_the_roadmap_and_where_it_stands_does_not(maze, roadmap):
    deadline = no_hurry(30.0)

    def built(*operations, **options):
        world = planning.load_world(planning.edit_scene(maze.scene, operations))
        return planning.build_roadmap(problem_of(**options), world, deadline=deadline)

    moved = maze.scene.objects[-1]
    shifted = replace(moved.pose, position=moved.pose.position + np.array([0.03, 0.0, 0.0]))
    assert built().key == roadmap.key
    away = built(MoveObject(moved.name, shifted))
    assert away.key != roadmap.key
    assert away.digest != roadmap.digest
    elsewhere = built(SetPositions("body", tuple(float(x) for x in roadmap.states[0])))
    assert elsewhere == roadmap
    deadline = no_hurry(30.0)
    wider = planning.build_roadmap(replace(problem_of(), margin=0.01), maze, deadline=deadline)
    assert wider.key != roadmap.key


def test_a_motion_by_roadmap_is_proven_on_arms_and_bodies():
    for scene, group, goal in (("window_3d", "body", "beyond"), ("ur5e_pickup", "arm", "ready")):
        world = bundled_world(scene)
        few = RoadmapOptions(states=120, neighbours=6)
        found = solve(world, problem_of(group=group, goal=goal, roadmap=few))
        assert found.certificate.proven
        assert found.stages.search.roadmap.num_edges > 0


def test_nonsense_and_lines_are_refused(maze):
    for options in ({"states": 0}, {"neighbours": 0}, {"seed": -1}):
        with pytest.raises(ProblemInvalid) as caught:
            solve(maze, problem_of(roadmap=RoadmapOptions(**options)))
        assert caught.value.evidence["field"] == "search.roadmap"
    line = LineGoal((PoseTarget(Pose.from_parts([0.0, 0.05, 0.0]), "body::body"),))
    with pytest.raises(ProblemInvalid, match="line goal") as refusal:
        solve(maze, replace(problem_of(), goal=line))
    assert refusal.value.evidence["field"] == "search.roadmap"


def test_a_roadmap_that_takes_too_long_says_so(maze):
    problem = problem_of(roadmap=RoadmapOptions(states=20_000, neighbours=50))
    with pytest.raises(DeadlineExceeded, match="20000 states") as caught:
        planning.plan(problem, maze, deadline=after_looks(20))
    assert caught.value.evidence["during"] == "roadmap"
