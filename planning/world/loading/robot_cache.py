"""RobotCache: the robots of a scene, loaded without its objects and reloaded when they change."""

from dataclasses import replace
from typing import Any

import numpy as np

from planning.domain.geometry.pose import Pose
from planning.domain.scene.scene import Scene, SceneRobot
from planning.world.loading.load_world import load_world
from planning.world.models.groups import RobotGroups
from planning.world.models.model_library import ModelLibrary
from planning.world.world import World

type Positions = str | dict[str, float | tuple[float, ...]] | tuple[float, ...]


class RobotCache:
    """Cache of a scene's loaded robots, for link poses and joint names; objects play no part."""

    def __init__(self, library: ModelLibrary) -> None:
        """Find robots in `library`."""
        self._library = library
        self._world: World | None = None
        self._loaded_scene: Scene | None = None

    def bodies(self, scene: Scene) -> list[str]:
        """Return the full names of the robots' bodies, "world" first."""
        return list(self._load(scene).drake.bodies)

    def frame_pose(self, scene: Scene, name: str) -> Pose:
        """Return X_WF of the world or a link at the scene's positions."""
        world = self._load(scene)
        return world.frame_pose(name, world.state)

    def with_positions(self, scene: Scene, index: int, positions: Positions) -> SceneRobot:
        """Return a robot of the scene at new positions; unnamed joints keep theirs.

        Raises:
            SceneInvalid: They name what the robot does not have, or their count is wrong.
        """
        before, robot = self._load(scene), scene.robots[index]
        moved = replace(robot, positions=positions)
        robots = (*scene.robots[:index], moved, *scene.robots[index + 1 :])
        after = self._load(replace(scene, robots=robots))
        own = after.robot_groups[index]
        given, joints = _given_joints(after, own, positions), _independent_joints(after, own)
        if given >= set(joints):
            return moved
        merged = {
            name.removeprefix(f"{own.robot}::"): _value(after if name in given else before, name)
            for name in joints
        }
        return replace(robot, positions=merged)

    def _load(self, scene: Scene) -> World:
        # Named configurations refer to groups of robots, so both are kept.
        robots_only = Scene(
            scene.name,
            scene.robots,
            configurations=scene.configurations,
            files=scene.files,
            groups=scene.groups,
        )
        if self._world is None or self._loaded_scene != robots_only:
            # The same bytes for the whole edit, even if the disk changes meanwhile.
            files = {} if self._world is None else self._world.scene.files
            scene_with_files = replace(robots_only, files={**files, **scene.files})
            # Robots that only moved are not loaded again.
            self._world = load_world(
                scene_with_files, self._library, kernel=False, previous=self._world
            )
            self._loaded_scene = robots_only
        return self._world


def _independent_joints(world: World, own: RobotGroups) -> list[str]:
    """Return the full names of a robot's joints that follow no other."""
    followers = {coupling.follower_position for coupling in world.drake.couplings}
    plant = world.drake.plant
    return [
        name
        for name, index in world.drake.joint_indices.items()
        if name.startswith(f"{own.robot}::")
        and plant.get_joint(index).position_start() not in followers
    ]


def _given_joints(world: World, own: RobotGroups, positions: Positions) -> set[str]:
    """Return the full names of the joints that `positions` sets."""
    match positions:
        case dict():
            prefix = f"{own.robot}::"
            return {prefix + name.removeprefix(prefix) for name in positions}
        case str():
            groups = [g for g in own.groups.values() if positions in world.configurations(g)]
        case tuple():
            groups = [own.groups[own.default]]
    return {joint.name for group in groups for joint in group.joints}


def _value(world: World, name: str) -> float | tuple[float, ...]:
    joint: Any = world.drake.plant.get_joint(world.drake.joint_indices[name])
    begin = joint.position_start()
    values: list[float] = np.array(world.state[begin : begin + joint.num_positions()]).tolist()
    return values[0] if len(values) == 1 else tuple(values)
