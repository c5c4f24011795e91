"""World: a scene loaded into Drake, and the interface to it for every stage."""

from copy import copy
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Float64
from pydrake.planning import SceneGraphCollisionChecker

from planning.domain.arrays import Array
from planning.domain.geometry.body_pair import BodyPair
from planning.domain.geometry.pose import Pose
from planning.domain.robot.followers import Follower, combine_limits
from planning.domain.robot.joints import JointGroup, JointLimits
from planning.domain.scene.scene import Scene
from planning.errors import UnknownName
from planning.world.collision.collision_check import (
    DistanceProbe,
    DrakeCollisionOracle,
)
from planning.world.collision.drake_checker import make_collision_checker
from planning.world.collision.margins import PairMargins
from planning.world.contexts import shared_context
from planning.world.drake_model import DrakeModel
from planning.world.kernel.kernel_oracle import KernelCollisionOracle
from planning.world.kernel.kernel_scene import kernel_scene_of
from planning.world.loading.builder import pose_of
from planning.world.loading.initial_state import initial_state, named_configurations
from planning.world.loading.scene_build import LoadedRobot
from planning.world.models.groups import RobotGroups, group_limits, robot_groups
from planning.world.models.mimic_limits import followers_of
from planning.world.models.model_library import ModelLibrary
from planning.world.models.scene_groups import SceneGroups

type CollisionChecker = DrakeCollisionOracle | KernelCollisionOracle

# Making a checker takes longer than most of its queries, so the newest ones are kept.
_MAX_ORACLES = 16


class World:
    """Scene in Drake, for one process and one thread; load it again rather than share it.

    Attributes:
        scene: The loaded scene.
        library: Library of its robots' files.
        drake: The engine objects, borrowed read-only by the stages.
        state: The current configuration of all joints, shape (num_positions,), read-only.
        scene_groups: The groups of its robots, and those that span them.
    """

    def __init__(
        self,
        scene: Scene,
        library: ModelLibrary,
        drake: DrakeModel,
        robots: tuple[LoadedRobot, ...],
    ) -> None:
        """Take the parts unchecked; use `load_world` instead."""
        self.scene = scene
        self.library = library
        self.drake = drake
        self._robots = robots
        self._oracles: dict[tuple[Any, ...], CollisionChecker] = {}
        self._checkers: list[tuple[Any, Array]] = []
        self._limits: dict[tuple[str, ...], JointLimits] = {}
        self._stated_limits: dict[tuple[str, ...], tuple[JointLimits, tuple[Follower, ...]]] = {}
        self._robot_groups = [robot_groups(drake, loaded) for loaded in robots]
        self.scene_groups = SceneGroups(scene, self._robot_groups)
        self._configurations = named_configurations(scene, self._robot_groups, self.group)
        # Not those of the shared context: another world of this model may have moved it.
        nominal = np.array(drake.plant.GetDefaultPositions())
        self.state = initial_state(drake, robots, self._robot_groups, self._configurations, nominal)
        self.state.flags.writeable = False

    @cached_property
    def digest(self) -> str:
        """sha256 of the scene's content."""
        return self.scene.digest

    def shares_engine_with(self, other: "World") -> bool:
        """Return whether both use one Drake model, and so belong to one thread."""
        return self.drake.diagram is other.drake.diagram

    def has_objects_of(self, other: "World") -> bool:
        """Return whether both have the same objects outside of Drake's model, or moved ones."""
        return self.drake.static_objects.rows is other.drake.static_objects.rows

    @property
    def _plant_context(self) -> Any:
        """Shared context for frame poses."""
        return self.drake.plant.GetMyMutableContextFromRoot(shared_context(self.drake))

    @cached_property
    def loaded_robots(self) -> tuple[LoadedRobot, ...]:
        """Robots of the scene with their files, in order."""
        return self._robots

    @property
    def groups(self) -> tuple[JointGroup, ...]:
        """Every group of a robot once, in the order of the robots."""
        return self.scene_groups.own

    def group(self, name: str) -> JointGroup:
        """Return a group by `robot`, `robot::group`, its name, or several joined by `+`.

        Raises:
            UnknownName: There is none.
            ProblemInvalid: Two of the joined groups have a joint in common.
        """
        return self.scene_groups.find(name)

    def limits(self, group: JointGroup) -> JointLimits:
        """Return the limits of a group under which its followers keep their own limits too.

        Raises:
            ModelInvalid: No position of a leader keeps both its own limits and its follower's.
        """
        key = group.joint_names
        if key not in self._limits:
            self._limits[key] = combine_limits(*self.stated_limits(group))
        return self._limits[key]

    def stated_limits(self, group: JointGroup) -> tuple[JointLimits, tuple[Follower, ...]]:
        """Return the group's own limits, without those of its followers, and its followers."""
        key = group.joint_names
        if key not in self._stated_limits:
            followers = followers_of(self.drake, group, self._robots)
            self._stated_limits[key] = (
                group_limits(self.drake, group, list(self._robots)),
                followers,
            )
        return self._stated_limits[key]

    def with_limits(self, group: JointGroup, limits: JointLimits) -> "World":
        """Return this world with other limits of a group; all that is loaded is shared."""
        other = copy(self)
        other._limits = {**self._limits, group.joint_names: limits}  # noqa: SLF001  (one of its own)
        return other

    def configurations(self, group: JointGroup) -> dict[str, Array]:
        """Return the group's named configurations, each shape (nq,)."""
        return self.scene_groups.configurations(group, self._configurations)

    def configuration(self, group: JointGroup, name: str) -> Array:
        """Return one named configuration of the group, shape (nq,).

        Raises:
            UnknownName: There is none of that name.
        """
        known = self.configurations(group)
        if name not in known:
            raise UnknownName.among("configuration", name, known)
        return known[name]

    def positions(self, group: JointGroup) -> Array:
        """Return the group's positions in the scene, shape (nq,)."""
        return self.state[self.drake.position_indices(group)]

    def validate_frame(self, name: str) -> None:
        """Raise unless a frame exists.

        Raises:
            UnknownName: There is no such frame.
        """
        if name not in self.drake.frames and name not in self.drake.static_objects.frames:
            raise UnknownName.among("frame", name, self.drake.all_frames)

    def frame_pose(self, name: str, full: Float64[np.ndarray, " num_positions"]) -> Pose:
        """Return X_WF of a frame at a full configuration.

        Raises:
            UnknownName: There is no such frame.
        """
        self.validate_frame(name)
        static_pose = self.drake.static_objects.frames.get(name)
        if static_pose is not None:
            return pose_of(static_pose)
        plant, context = self.drake.plant, self._plant_context
        plant.SetPositions(context, full)
        return pose_of(self.drake.frames[name].CalcPoseInWorld(context))

    def frame_poses(
        self, name: str, full: Float64[np.ndarray, "n num_positions"]
    ) -> Float64[np.ndarray, "n 4 4"]:
        """Return X_WF of a frame at each full configuration, as homogeneous transforms.

        Raises:
            UnknownName: There is no such frame.
        """
        self.validate_frame(name)
        static_pose = self.drake.static_objects.frames.get(name)
        if static_pose is not None:
            return np.repeat(static_pose.GetAsMatrix4()[None], len(full), axis=0)
        plant, frame, context = self.drake.plant, self.drake.frames[name], self._plant_context
        poses = np.empty((len(full), 4, 4))
        for i, q in enumerate(full):
            plant.SetPositions(context, q)
            poses[i] = frame.CalcPoseInWorld(context).GetAsMatrix4()
        return poses

    def embed(self, group: JointGroup, q: Float64[np.ndarray, "*n nq"]) -> Array:
        """Return full configurations with the group at q and all other joints as in the scene."""
        return self.drake.embed(group, q, self.state)

    def margins(self, margin: float | None = None, padding: float = 0.0) -> PairMargins:
        """Return the collision margins of pairs of bodies.

        Args:
            margin: Default margin instead of the scene's [m]; exceptions for pairs stay.
            padding: Added to the margin of pairs of different robots or objects, and to all
                exceptions for pairs [m].
        """
        default = self.scene.margin if margin is None else margin
        exceptions = {
            (min(m.bodies), max(m.bodies)): m.margin + padding for m in self.scene.margins
        }
        return PairMargins(default + padding, exceptions, self.drake.owners)

    def collision_oracle(self, group: JointGroup, margins: PairMargins) -> CollisionChecker:
        """Return a fast collision checker of the group, cached by group and margins."""
        key = group.name, margins.default, *margins.by_pair.items()
        if key not in self._oracles:
            if len(self._oracles) >= _MAX_ORACLES:
                self._oracles.pop(next(iter(self._oracles)))
            self._oracles[key] = self._make_oracle(group, margins)
        return self._oracles[key]

    def _make_oracle(self, group: JointGroup, margins: PairMargins) -> CollisionChecker:
        kernel = kernel_scene_of(self.drake)
        if kernel is None:
            return DrakeCollisionOracle(self.drake, group, self.state, margins, self._drake_checker)
        return KernelCollisionOracle(
            self.drake, kernel, group, self.state, margins, self._drake_checker
        )

    def _drake_checker(self) -> SceneGraphCollisionChecker:
        """Return a Drake checker without margins, for one oracle: the first, then copies of it.

        It is made when the kernel is first undecided. Most plans need no other: to copy one takes a
        third of the time to make it.
        """
        if not self._checkers:
            checker: Any = make_collision_checker(self.drake)
            self._checkers.append((checker, np.array(checker.GetPaddingMatrix())))
            return checker
        first, padding = self._checkers[0]
        copy = first.Clone()
        copy.SetPaddingMatrix(padding)
        return copy

    def distance_probe(self, margins: PairMargins) -> DistanceProbe:
        """Return a slow distance query that reports pairs, distances and nearest points."""
        return DistanceProbe(self.drake, margins)

    def violations(
        self, group: JointGroup, q: Float64[np.ndarray, " nq"], margins: PairMargins
    ) -> tuple[BodyPair, ...]:
        """Return the pairs of bodies that are nearer than their margin, nearest first."""
        return self.distance_probe(margins).violations(self.embed(group, q))

    @property
    def robot_groups(self) -> list[RobotGroups]:
        """Groups of each robot, in order."""
        return self._robot_groups
