"""World: a scene loaded into Drake, and the door to it for every stage."""

from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.joints import JointGroup, JointLimits
from planning.domain.pose import Pose
from planning.domain.report import BodyPair
from planning.domain.scene import NamedConfiguration, Scene, SceneRobot
from planning.domain.summary import GroupSummary, SceneSummary
from planning.errors import ProblemInvalid, SceneInvalid, UnknownName
from planning.world.builder import LoadedRobot, build_diagram, pose_of
from planning.world.collision import DistanceProbe, DrakeCollisionOracle
from planning.world.drake_model import DrakeModel
from planning.world.groups import RobotGroups, group_limits, robot_groups
from planning.world.margins import PairMargins
from planning.world.model_library import ModelLibrary

type Array = np.ndarray[Any, np.dtype[np.float64]]


class World:
    """A scene in Drake. Lives in one process and one thread; load it again rather than share it.

    Attributes:
        scene: What was loaded.
        library: Where its robots were found.
        drake: The engine objects, borrowed read-only by the stages.
        state: The current configuration of everything, shape (num_positions,), read-only.
    """

    def __init__(
        self,
        scene: Scene,
        library: ModelLibrary,
        drake: DrakeModel,
        robots: tuple[LoadedRobot, ...],
    ) -> None:
        """Trust the parts; use `load_world`."""
        self.scene = scene
        self.library = library
        self.drake = drake
        self._robots = robots
        self._robot_groups = [robot_groups(drake, loaded) for loaded in robots]
        self._groups = {
            group.name: group for own in self._robot_groups for group in own.groups.values()
        }
        for own in self._robot_groups:
            for name, group in own.groups.items():
                self._groups.setdefault(f"{own.robot}::{name}", group)
        self._configurations = self._collect_configurations()
        self._context = drake.diagram.CreateDefaultContext()
        self._plant_context = drake.plant.GetMyMutableContextFromRoot(self._context)
        self.state = self._initial_state()
        self.state.flags.writeable = False

    @property
    def digest(self) -> str:
        """sha256 of the scene's content."""
        return self.scene.digest

    @property
    def groups(self) -> tuple[JointGroup, ...]:
        """Every group once, in the order of the robots."""
        return tuple(group for own in self._robot_groups for group in own.groups.values())

    def group(self, name: str) -> JointGroup:
        """Return a group by `robot` or `robot::group`.

        Raises:
            UnknownName: There is none.
        """
        if name not in self._groups:
            raise UnknownName.among("group", name, self._groups)
        return self._groups[name]

    def limits(self, group: JointGroup) -> JointLimits:
        """Return what the group may do."""
        return group_limits(self.drake, group, list(self._robots))

    def configurations(self, group: JointGroup) -> dict[str, Array]:
        """Return the group's named configurations, each shape (nq,)."""
        return self._configurations[group.name]

    def configuration(self, group: JointGroup, name: str) -> Array:
        """Return one named configuration of the group, shape (nq,).

        Raises:
            UnknownName: There is none of that name.
        """
        if name not in self._configurations[group.name]:
            raise UnknownName.among("configuration", name, self._configurations[group.name])
        return self._configurations[group.name][name]

    def positions(self, group: JointGroup) -> Array:
        """Return where the scene puts the group, shape (nq,)."""
        return self.state[self.drake.position_indices(group)]

    def require_frame(self, name: str) -> None:
        """Go on only if there is such a frame.

        Raises:
            UnknownName: There is none.
        """
        if name not in self.drake.frames:
            raise UnknownName.among("frame", name, self.drake.frames)

    def frame_pose(self, name: str, full: Float64[np.ndarray, " num_positions"]) -> Pose:
        """Return X_WF of a frame at a full configuration.

        Raises:
            UnknownName: There is no such frame.
        """
        self.require_frame(name)
        plant = self.drake.plant
        plant.SetPositions(self._plant_context, full)
        return pose_of(self.drake.frames[name].CalcPoseInWorld(self._plant_context))

    def embed(self, group: JointGroup, q: Float64[np.ndarray, "*n nq"]) -> Array:
        """Return full configurations with the group at q and all else as in the scene."""
        return self.drake.embed(group, q, self.state)

    def margins(self, margin: float | None = None, padding: float = 0.0) -> PairMargins:
        """Return the distances to keep.

        Args:
            margin: Instead of the scene's own [m].
            padding: Added to the margin of every pair of different robots or objects [m].
        """
        default = self.scene.margin if margin is None else margin
        exceptions = {
            (min(m.bodies), max(m.bodies)): m.margin + padding for m in self.scene.margins
        }
        return PairMargins(default + padding, exceptions)

    def collision_oracle(self, group: JointGroup, margins: PairMargins) -> DrakeCollisionOracle:
        """Return a fast judge of the group's configurations."""
        return DrakeCollisionOracle(self.drake, group, self.state, margins)

    def distance_probe(self, margins: PairMargins) -> DistanceProbe:
        """Return a slow judge that says which pairs, how near and where."""
        return DistanceProbe(self.drake, margins)

    def violations(
        self, group: JointGroup, q: Float64[np.ndarray, " nq"], margins: PairMargins
    ) -> tuple[BodyPair, ...]:
        """Return the pairs of bodies that are nearer than their margin, nearest first."""
        return self.distance_probe(margins).violations(self.embed(group, q))

    @property
    def summary(self) -> SceneSummary:
        """What can be named in this scene."""
        groups = {
            group.name: GroupSummary(
                group,
                self.limits(group),
                {name: tuple(map(float, q)) for name, q in self.configurations(group).items()},
                tuple(map(float, self.positions(group))),
            )
            for group in self.groups
        }
        inspector = self.drake.scene_graph.model_inspector()
        return SceneSummary(
            groups=groups,
            frames=tuple(sorted(self.drake.frames)),
            bodies=tuple(sorted(self.drake.bodies)),
            num_pairs=len(inspector.GetCollisionCandidates()),
            digest=self.digest,
            assumed=tuple(
                f"{own.robot}::{joint}" for own in self._robot_groups for joint in own.assumed
            ),
        )

    @property
    def robot_groups(self) -> list[RobotGroups]:
        """The groups of each robot, in order."""
        return self._robot_groups

    def _collect_configurations(self) -> dict[str, dict[str, Array]]:
        """Return the robots' and the scene's named configurations, by group."""
        collected: dict[str, dict[str, Array]] = {group.name: {} for group in self.groups}
        for own in self._robot_groups:
            for name, by_group in own.configurations.items():
                for group_name, q in by_group.items():
                    if group_name not in own.groups:
                        raise UnknownName.among("group", group_name, own.groups)
                    group = own.groups[group_name]
                    path = f"{own.robot}, configuration {name}"
                    collected[group.name][name] = _counted(group, q, path)
        for entry in self.scene.configurations:
            group = self._scene_group(entry)
            q = _counted(group, entry.positions, f"configurations.{entry.name}.positions")
            collected[group.name][entry.name] = q
        for by_name in collected.values():
            for q in by_name.values():
                q.flags.writeable = False
        return collected

    def _scene_group(self, entry: NamedConfiguration) -> JointGroup:
        path = f"configurations.{entry.name}.group"
        try:
            return self.group(entry.group)
        except UnknownName as fault:
            message = f"{path}: {fault.detail}"
            raise SceneInvalid(message, {"path": path, **fault.evidence}) from fault

    def _initial_state(self) -> Array:
        state = np.array(self.drake.plant.GetPositions(self._plant_context))
        for i, (loaded, own) in enumerate(zip(self._robots, self._robot_groups, strict=True)):
            placed = _robot_positions(loaded.scene_robot, own, self._configurations, i)
            for group in own.groups.values():
                if group.name not in placed:
                    q = state[self.drake.position_indices(group)]
                    limits = self.limits(group)
                    placed = {group.name: np.clip(q, limits.lower, limits.upper), **placed}
            by_name = {group.name: group for group in own.groups.values()}
            for name, q in placed.items():
                state[self.drake.position_indices(by_name[name])] = q
            if isinstance(loaded.scene_robot.positions, dict):
                self._place_joints(state, loaded.scene_robot, i)
        return self.drake.follow(state)

    def _place_joints(self, state: Array, robot: SceneRobot, i: int) -> None:
        by_joint = robot.positions
        assert isinstance(by_joint, dict)  # noqa: S101  (the caller's case)
        for joint, number in by_joint.items():
            full = f"{robot.name}::{joint.removeprefix(f'{robot.name}::')}"
            path = f"robots.{i}.positions.{joint}"
            if full not in self.drake.joint_indices:
                known = [n for n in self.drake.joint_indices if n.startswith(f"{robot.name}::")]
                fault = UnknownName.among("joint", full, known)
                raise SceneInvalid(f"{path}: {fault.detail}", {"path": path, **fault.evidence})
            index = self.drake.plant.get_joint(self.drake.joint_indices[full])
            values = np.atleast_1d(np.array(number, dtype=np.float64))
            if len(values) != index.num_positions():
                count = index.num_positions()
                message = f"{path}: {full} has {count} positions, got {len(values)}"
                raise SceneInvalid(message, {"path": path})
            begin = index.position_start()
            state[begin : begin + len(values)] = values


def load_world(scene: Scene, library: ModelLibrary | None = None) -> World:
    """Load a scene into Drake.

    Raises:
        SceneInvalid: A name in the scene is wrong; evidence has its `path`.
        AssetNotFound: A file is not there.
        ModelInvalid: A robot's description is unsafe or does not load.
        UnknownName: There is no such robot.
    """
    chosen = library or ModelLibrary.bundled()
    drake, robots = build_diagram(scene, chosen)
    world = World(scene, chosen, drake, robots)
    for i, entry in enumerate(scene.margins):
        for body in entry.bodies:
            if body not in drake.bodies:
                fault = UnknownName.among("body", body, drake.bodies)
                path = f"margins.{i}.bodies"
                raise SceneInvalid(f"{path}: {fault.detail}", {"path": path, **fault.evidence})
    return world


def _robot_positions(
    robot: SceneRobot, own: RobotGroups, configurations: dict[str, dict[str, Array]], i: int
) -> dict[str, Array]:
    """Return where a robot's groups start, by full group name, as the scene says."""
    path = f"robots.{i}.positions"
    named = {
        group.name: configurations[group.name]["home"]
        for group in own.groups.values()
        if "home" in configurations[group.name]
    }
    match robot.positions:
        case str() as name:
            chosen = {
                group.name: configurations[group.name][name]
                for group in own.groups.values()
                if name in configurations[group.name]
            }
            if not chosen:
                known = {n for g in own.groups.values() for n in configurations[g.name]}
                fault = UnknownName.among("configuration", name, known)
                raise SceneInvalid(f"{path}: {fault.detail}", {"path": path, **fault.evidence})
            return {**named, **chosen}
        case tuple() as numbers:
            if own.default not in own.groups:
                message = f"{path}: {robot.name!r} has no joint to place"
                raise SceneInvalid(message, {"path": path})
            group = own.groups[own.default]
            return {**named, group.name: _counted(group, numbers, path)}
        case _:
            return named


def _counted(group: JointGroup, q: Any, path: str) -> Array:
    """Return q as an array of the group's length, with unit quaternions."""
    positions = np.array(q, dtype=np.float64)
    names = list(group.position_names)
    if positions.shape != (len(names),):
        message = f"{path}: {group.name} has {len(names)} positions {names}, got {positions.size}"
        raise SceneInvalid(message, {"path": path, "expected": names})
    return positions


def require_positions(group: JointGroup, q: Any, field: str) -> Array:
    """Return q as an array of the group's positions, read-only.

    Raises:
        ProblemInvalid: The count is wrong or a number is not finite.
    """
    positions = np.array(q, dtype=np.float64)
    names = list(group.position_names)
    if positions.shape != (len(names),):
        message = f"{field}: {group.name} has {len(names)} positions {names}, got {positions.size}"
        raise ProblemInvalid(message, {"field": field, "expected": names, "got": positions.size})
    if not np.isfinite(positions).all():
        bad = [name for name, x in zip(names, positions, strict=True) if not np.isfinite(x)]
        message = f"{field}: {bad} must be finite"
        raise ProblemInvalid(message, {"field": field, "joints": bad})
    positions.flags.writeable = False
    return positions
