"""Random paths of the bundled robots."""

from dataclasses import dataclass

import numpy as np

import planning
from planning.domain.curves.path import JointPath
from planning.domain.robot.joints import JointLimits

SCENES = {"panda": ("panda_shelf", "panda"), "ur5e": ("ur5e_pickup", "arm")}
# Standard deviation of a step in every joint [rad].
_SPREAD = 0.7


@dataclass(frozen=True)
class Question:
    """A path to time.

    Attributes:
        robot: Whose it is.
        path: Its waypoints.
        limits: What to keep.
    """

    robot: str
    path: JointPath
    limits: JointLimits


def random_paths(count: int, seed: int) -> list[Question]:
    """Return random walks of 3 to 8 waypoints within the joints' limits, robots in turns."""
    rng = np.random.default_rng(seed)
    folder = planning.bundled_folder("scenes")
    robots: list[tuple[str, planning.World, str]] = []
    for robot, (scene, name) in SCENES.items():
        world = planning.load_world(planning.read_scene(folder / f"{scene}.scene.yaml"))
        robots.append((robot, world, name))
    questions: list[Question] = []
    for i in range(count):
        robot, world, name = robots[i % len(robots)]
        group = world.group(name)
        limits = world.limits(group)
        rows = [world.positions(group)]
        for _ in range(int(rng.integers(2, 8))):
            step = rng.normal(0.0, _SPREAD, group.num_positions)
            rows.append(np.clip(rows[-1] + step, limits.lower + 0.1, limits.upper - 0.1))
        questions.append(Question(robot, JointPath(group, np.stack(rows)), limits))
    return questions
