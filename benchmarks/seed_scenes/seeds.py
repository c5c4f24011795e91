"""What every seed of this project asks for, and in how much time."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

import planning
from benchmarks.seed_scenes.cycle import pick_and_place
from benchmarks.seed_scenes.leg import Leg
from planning.domain.request.deadline import Deadline

EXACT = np.zeros(3)


@dataclass(frozen=True)
class Seed:
    """A seed.

    Attributes:
        name: Its key in the report; the scene's own name comes first in it.
        scene: Name of its scene.
        allowed: For everything it asks for [s].
        run: Carries it out in the loaded scene with a random seed; raises PlanningFailure.
    """

    name: str
    scene: str
    allowed: float
    run: Callable[[planning.World, int, Deadline], tuple[Leg, ...]]


def maze(world: planning.World, seed: int, deadline: Deadline) -> tuple[Leg, ...]:
    """Slide an L from one corner of a maze to the other: RRTConnect, 800 states."""
    search = planning.SearchOptions(num_states=800, allowed_planning_time=4.0)
    goal = planning.ConfigurationGoal("exit")
    return _one(world, planning.PlanningProblem("body", goal, search=search, seed=seed), deadline)


def maze_along_walls(world: planning.World, seed: int, deadline: Deadline) -> tuple[Leg, ...]:
    """Slide it through without ever being farther than 0.05 m or nearer than 0.01 m to a wall."""
    problem = planning.PlanningProblem(
        "body",
        planning.ConfigurationGoal("exit"),
        search=planning.SearchOptions(num_states=800, allowed_planning_time=8.0),
        seed=seed,
        constraints=(planning.DistanceBand(None, None, 0.01, 0.05),),
    )
    return _one(world, problem, deadline)


def window(world: planning.World, seed: int, deadline: Deadline) -> tuple[Leg, ...]:
    """Fly an L through a hole that it has to turn for: 200 states."""
    search = planning.SearchOptions(num_states=200, allowed_planning_time=20.0)
    goal = planning.ConfigurationGoal("beyond")
    return _one(world, planning.PlanningProblem("body", goal, search=search, seed=seed), deadline)


def pickup_pose(world: planning.World, seed: int, deadline: Deadline) -> tuple[Leg, ...]:
    """Reach for a can from above: 100 configurations of 300 trials, 4 attempts."""
    goal = grasp(np.array([0.0, 0.0, -0.1]))
    problem = planning.PlanningProblem("arm", goal, ik=_MANY, search=_SHORTEST_OF_4, seed=seed)
    return _one(world, problem, deadline)


def pickup_joint(world: planning.World, seed: int, deadline: Deadline) -> tuple[Leg, ...]:
    """Reach for it again, by configurations: those that inverse kinematics finds for the pose."""
    found = planning.solve_ik(
        world, "arm", grasp(None), deadline=deadline, options=_MANY, seed=seed
    )
    goal = planning.JointGoal(found.positions)
    problem = planning.PlanningProblem("arm", goal, search=_SHORTEST_OF_4, seed=seed)
    return _one(world, problem, deadline)


def grasp(approach: np.ndarray[Any, Any] | None) -> planning.PoseGoal:
    """Return the pose of the gripper about the can; `approach` in its axes [m], shape (3,)."""
    target = planning.PoseTarget(planning.Pose.identity(), frame="pick")
    return planning.PoseGoal((target,), "arm::tcp", EXACT, EXACT, approach=approach)


def _one(
    world: planning.World, problem: planning.PlanningProblem, deadline: Deadline
) -> tuple[Leg, ...]:
    return (Leg(world, planning.plan(problem, world, deadline=deadline)),)


_MANY = planning.IkOptions(max_configurations=100, max_trials=300)
_SHORTEST_OF_4 = planning.SearchOptions(
    attempts=4, num_states=400, approach_states=100, allowed_planning_time=10.0
)


def parking(world: planning.World, seed: int, deadline: Deadline) -> tuple[Leg, ...]:
    """Park a car in a gap, backwards; no seed of this project, but a picture of its guide."""
    search = planning.SearchOptions(attempts=4)
    goal = planning.ConfigurationGoal("parked")
    return _one(world, planning.PlanningProblem("car", goal, search=search, seed=seed), deadline)


SEEDS = (
    Seed("maze_2d", "maze_2d", 4.0, maze),
    Seed("maze_2d_band", "maze_2d_band", 8.0, maze_along_walls),
    Seed("window_3d", "window_3d", 20.0, window),
    Seed("ur5e_pickup", "ur5e_pickup", 10.0, pickup_pose),
    Seed("ur5e_pickup_joint", "ur5e_pickup", 10.0, pickup_joint),
    Seed("irb120_cell", "irb120_cell", 20.0, pick_and_place),
)
PICTURES = (*SEEDS, Seed("parallel_parking", "parallel_parking", 5.0, parking))
