"""Every bundled scene, planned in with Drake alone: as on a machine without a compiler.

Here the worlds do without the native kernel; `make drake-only` takes it away from everything else
as well, from refining and certifying.
"""

import sys
from functools import cache
from typing import Any

import numpy as np
import pytest

import planning
from planning.world.collision.collision_check import DrakeCollisionOracle
from planning.world.world import World
from tests.certify.conftest import smallest_distance
from tests.clocks import no_hurry
from tests.profiles import PROFILE

pytestmark = pytest.mark.drake_only

EXACT = np.zeros(3)
GROUPS = {
    "irb120_cell": "arm",
    "maze_2d": "body",
    "maze_2d_band": "body",
    "panda_shelf": "panda",
    "parallel_parking": "car",
    "two_arms": "both",
    "ur5e_pickup": "arm",
    "window_3d": "body",
}


def to_frame(frame: str) -> planning.PoseGoal:
    target = planning.PoseTarget(planning.Pose.identity(), frame)
    return planning.PoseGoal((target,), "", EXACT, EXACT)


def to(name: str) -> planning.ConfigurationGoal:
    return planning.ConfigurationGoal(name)


# Along the wall that it starts beside: the whole way around takes Drake nine seconds.
AHEAD = planning.JointGoal(np.array([[0.15, -0.42, 0.0]]))
GRASP = planning.PoseGoal(
    to_frame("pick").targets, "arm::tcp", EXACT, EXACT, approach=np.array([0.0, 0.0, -0.1])
)
RUCKIG = {"retime": planning.RetimeOptions(method="ruckig")}
PLANS: dict[str, tuple[str, Any, dict[str, Any]]] = {
    "a pose": ("irb120_cell", to_frame("above_pick"), {}),
    "a maze": ("maze_2d", to("exit"), {}),
    "a band": (
        "maze_2d_band",
        AHEAD,
        {"constraints": (planning.DistanceBand(None, None, 0.01, 0.05),)},
    ),
    "two arms": ("two_arms", to_frame("above_bolt"), {}),
    "a shelf": ("panda_shelf", to_frame("lower"), {"seed": 3}),
    "a gap": ("parallel_parking", to("parked"), {}),
    "a grasp": ("ur5e_pickup", GRASP, {}),
    "unrefined": ("ur5e_pickup", to("stowed"), {"refine": planning.RefineOptions("none")}),
    "jerk": ("ur5e_pickup", to("stowed"), RUCKIG),
    "a window": ("window_3d", to("beyond"), {}),
    "a window, jerk": ("window_3d", to("beyond"), RUCKIG),
    "a portfolio": (
        "window_3d",
        to("beyond"),
        {"search": planning.SearchOptions(planner=("RRTConnect", "PRM"), attempts=2)},
    ),
}


# Drake alone takes 5 to 40 s for some: `make drake-only` has all but the slowest, the campaign all.
QUICK = ["a band", "unrefined", "jerk"]
SLOWEST = {"a gap", "a maze"}


def _chosen() -> list[str]:
    if PROFILE.is_campaign:
        return list(PLANS)
    return [name for name in PLANS if name not in SLOWEST] if "--no-kernel" in sys.argv else QUICK


@cache
def world_without_kernel(name: str) -> World:
    path = planning.bundled_folder("scenes") / f"{name}.scene.yaml"
    return planning.load_world(planning.read_scene(path), kernel=False)


def test_every_bundled_scene_is_planned_in() -> None:
    scenes = {path.name for path in planning.bundled_folder("scenes").glob("*.scene.yaml")}
    assert {f"{scene}.scene.yaml" for scene in GROUPS} == scenes
    assert {scene for scene, _, _ in PLANS.values()} == set(GROUPS)


@pytest.mark.parametrize("name", _chosen())
def test_what_is_delivered_is_proven_and_free(name: str) -> None:
    scene, goal, options = PLANS[name]
    world = world_without_kernel(scene)
    group = world.group(GROUPS[scene])
    assert isinstance(world.collision_oracle(group, world.margins()), DrakeCollisionOracle)
    problem = planning.PlanningProblem(group.name, goal, **options)
    found = planning.plan(problem, world, deadline=no_hurry())
    assert found.certificate.proven
    np.testing.assert_allclose(found.trajectory.start, world.positions(group), atol=1e-9)
    np.testing.assert_allclose(found.trajectory.end, found.goal_configuration, atol=1e-6)
    free = smallest_distance(world, found.trajectory, group.name, 0.01)
    assert free > 0
    # What was proven on the whole interval holds at samples.
    assert free >= found.certificate.min_clearance - 1e-6
