"""Worlds whose inverse kinematics is the kernel's, and the same with Drake's."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import planning
from planning.domain.geometry.pose import Pose
from planning.domain.goals.goal import PoseGoal, PoseTarget
from planning.domain.goals.goal_configurations import GoalConfigurations
from planning.domain.request.options import IkOptions
from planning.goals.find_goals import GoalQuery, find_goals
from planning.kernel.native import native
from planning.world.world import World
from tests.clocks import after_looks, no_hurry
from tests.conftest import bundled_world
from tests.profiles import num_cases

EXACT = np.zeros(3)
# Poses that are tried to find a nearer one than the nearest.
TRIES = num_cases(500, 2000)
ENGINES = pytest.mark.parametrize("engine", ["kernel", "drake"])


def with_engine(world: World, engine: str) -> World:
    """Let the kernel or Drake answer in a world that belongs to one test."""
    if engine == "kernel" and native() is None:
        pytest.skip("the native kernel is not built")
    world.drake = replace(world.drake, uses_kernel=engine == "kernel")
    return world


@cache
def world_by(name: str, engine: str) -> World:
    """Return a bundled scene whose inverse kinematics is the kernel's or Drake's."""
    if engine == "kernel" and native() is not None:
        return bundled_world(name)
    path: Path = planning.bundled_folder("scenes") / f"{name}.scene.yaml"
    return with_engine(planning.load_world(planning.read_scene(path)), engine)


def ask(
    world: World,
    name: str,
    goal: PoseGoal,
    options: IkOptions | None = None,
    seed: int = 0,
    looks: int | None = None,
) -> GoalConfigurations:
    """Return the goal configurations of a group that is where the scene puts it.

    Time runs out after so many looks at the clock; None lets it last. A hundred looks are enough
    to refuse a goal, and too few to find what is nearest to it where lines count.
    """
    group = world.group(name)
    query = GoalQuery(group, goal, world.positions(group), world.margins(), options or IkOptions())
    deadline = no_hurry() if looks is None else after_looks(looks)
    return find_goals(world, query, np.random.default_rng(seed), deadline)


def at(
    pose: Pose, frame: str = "world", rotation: np.ndarray = EXACT, position: np.ndarray = EXACT
) -> PoseGoal:
    """Return the goal of one pose of the default tool frame."""
    return PoseGoal((PoseTarget(pose, frame),), "", position, rotation)
