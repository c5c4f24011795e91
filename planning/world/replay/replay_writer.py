"""Replay: motions as one HTML page that needs no server, by Drake's Meshcat."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pydrake.geometry import (
    Cylinder,
    HalfSpace,
    Meshcat,
    MeshcatAnimation,
    MeshcatParams,
    Rgba,
)
from pydrake.math import RigidTransform, RotationMatrix

from planning.domain.arrays import Array
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.robot.joints import JointGroup, JointType
from planning.world.replay.camera import SolidBox, place_camera
from planning.world.replay.half_space_plate import plate_under
from planning.world.replay.replay_page import Label, Section, labelled
from planning.world.replay.replay_view import ShownBody, ShownShape, WorldView
from planning.world.world import World

_TRACE_COLOR = Rgba(0.95, 0.45, 0.05, 1.0)
_AXIS_COLORS = (Rgba(0.85, 0.1, 0.1, 1.0), Rgba(0.1, 0.65, 0.1, 1.0), Rgba(0.1, 0.2, 0.9, 1.0))
_AXIS_LENGTH, _AXIS_RADIUS = 0.06, 0.0025
# Twice the number of frames gives a smoother line than the animation needs.
_TRACE_POINTS_PER_FRAME = 2
_NUM_REPETITIONS = 1_000_000
# Longer motions have fewer frames a second, so that a browser can open the page.
MAX_FRAMES = 10_000
# Number of instants of each motion at which the tool should be visible.
_NUM_CAMERA_INSTANTS = 5


@dataclass(frozen=True)
class ShownMotion:
    """Motion to replay, with its world.

    Attributes:
        title: Title, for people.
        world: The world; joints outside of `group` stay at its state.
        group: The group that moves.
        trajectory: Of the group.
        until: Part of it to show [s]; None for all.
    """

    title: str
    world: World
    group: JointGroup
    trajectory: TimedTrajectory
    until: float | None = None

    def states(self, rate: float) -> Array:
        """Return full configurations, `rate` a second, shape (n, num_positions), n >= 1."""
        times = self.trajectory.sample_times(1.0 / rate)
        if self.until is not None:
            times = np.append(times[times < self.until], min(self.until, times[-1]))
        return self.world.embed(self.group, self.trajectory.positions(times))


def replay_html(
    world: World,
    group: JointGroup,
    trajectory: TimedTrajectory,
    frames_per_second: float = 30.0,
    max_frames: int = MAX_FRAMES,
) -> str:
    """Return a page that repeats the motion, with the path of the tool frame.

    Meshcat needs a web server while it works: it listens on the loopback interface, on a port
    that the system chooses, and stops when this returns.

    Args:
        world: The world; joints outside of `group` stay at its state.
        group: The group that moves.
        trajectory: Of the group.
        frames_per_second: Of the animation; fewer where there would be more than `max_frames`.
        max_frames: Of the animation.
    """
    motion = ShownMotion(group.name, world, group, trajectory)
    return replay_motions_html([motion], frames_per_second, max_frames)


def replay_motions_html(
    motions: Sequence[ShownMotion],
    frames_per_second: float = 30.0,
    max_frames: int = MAX_FRAMES,
) -> str:
    """Return a page that repeats motions one after the other, as `replay_html` does.

    Each has a world of its own, such as the revisions of a scene between which an object was
    grasped; objects that one of them does not have are hidden during its motion.

    Args:
        motions: In order, at least one.
        frames_per_second: Of the animation; fewer where there would be more than `max_frames`.
        max_frames: Of the animation.
    """
    meshcat = Meshcat(MeshcatParams(host="localhost", port=0, show_stats_plot=False))
    duration = sum(motion.trajectory.duration for motion in motions)
    return _Replay(motions, meshcat, min(frames_per_second, max_frames / duration)).page()


class _Replay:
    """Writer of worlds and their animation to Meshcat."""

    def __init__(self, motions: Sequence[ShownMotion], meshcat: Meshcat, rate: float) -> None:
        self._motions, self._meshcat, self._rate = motions, meshcat, rate
        views: dict[int, WorldView] = {}
        self._views = [views.setdefault(id(m.world), WorldView(m.world)) for m in motions]
        self._states = [motion.states(rate) for motion in motions]
        self._drawn: dict[str, ShownBody] = {}
        self._half_spaces: list[tuple[WorldView, ShownBody, str, ShownShape]] = []

    def page(self) -> str:
        """Draw everything and return the page."""
        for view in self._views:
            self._draw_bodies(view)
            self._draw_frames(view)
        for view, states in zip(self._views[::-1], self._states[::-1], strict=True):
            view.set_positions(states[0])  # in the end, everything is where the first motion begins
            for path, pose in view.poses.items():
                self._meshcat.SetTransform(path, pose)
        self._draw_half_spaces(self._aim_camera())
        for i in range(len(self._motions)):
            self._draw_trace(i)
        self._meshcat.SetAnimation(self._animation())
        for path in ("/Grid", "/Axes"):
            self._meshcat.SetProperty(path, "visible", value=False)
        return labelled(
            self._meshcat.StaticHtml(),
            self._motions[0].world.scene.name,
            self._labels(),
            self._sections(),
        )

    def _draw_bodies(self, view: WorldView) -> None:
        """Draw the bodies that no earlier world has shown."""
        for shown in view.bodies:
            if shown.path in self._drawn:
                continue
            self._drawn[shown.path] = shown
            for i, drawn in enumerate(shown.shapes):
                path = f"{shown.path}/{i}"
                if isinstance(drawn.shape, HalfSpace):  # drawn once the camera is aimed
                    self._half_spaces.append((view, shown, path, drawn))
                    continue
                self._meshcat.SetObject(path, drawn.shape, drawn.color)
                self._meshcat.SetTransform(path, drawn.X_BS)

    def _draw_half_spaces(self, points: Array) -> None:
        """Draw every half space as a plate under some points in world, shape (n, 3)."""
        for view, shown, path, drawn in self._half_spaces:
            plate, x_gp = plate_under(view.poses[shown.path] @ drawn.X_BS, points)
            self._meshcat.SetObject(path, plate, drawn.color)
            self._meshcat.SetTransform(path, drawn.X_BS @ x_gp)

    def _draw_frames(self, view: WorldView) -> None:
        """Draw the scene's named frames as small triads."""
        turns = (
            RotationMatrix.MakeYRotation(np.pi / 2),
            RotationMatrix.MakeXRotation(-np.pi / 2),
            RotationMatrix(),
        )
        bar = Cylinder(_AXIS_RADIUS, _AXIS_LENGTH)
        for named in view.world.scene.frames:
            for i, turn in enumerate(turns):
                path, center = f"/frames/{named.name}/{i}", _AXIS_LENGTH / 2 * np.eye(3)[i]
                self._meshcat.SetObject(path, bar, _AXIS_COLORS[i])
                self._meshcat.SetTransform(path, RigidTransform(turn, center))

    def _draw_trace(self, i: int) -> None:
        """Draw the path of the default tool frame in a motion."""
        motion, view = self._motions[i], self._views[i]
        if not motion.group.tool_frames:
            return
        states = motion.states(self._rate * _TRACE_POINTS_PER_FRAME)
        points = np.empty((3, len(states)))
        for k, state in enumerate(states):
            view.set_positions(state)
            points[:, k] = view.tool(motion.group)
        self._meshcat.SetLine(f"/trace/{i}", points, 4.0, _TRACE_COLOR)

    def _animation(self) -> MeshcatAnimation:
        animation = MeshcatAnimation(self._rate)
        animation.set_autoplay(play=True)
        animation.set_loop_mode(MeshcatAnimation.LoopMode.kLoopRepeat)
        animation.set_repetitions(_NUM_REPETITIONS)
        paths = self._changing_paths()
        common_paths = set.intersection(*(set(view.poses) for view in self._views))
        frame = 0
        for view, states in zip(self._views, self._states, strict=True):
            view.set_positions(states[0])
            initial_poses = view.poses
            for path in paths - common_paths:
                animation.SetProperty(frame, path, "visible", value=path in initial_poses)
            for state in states:
                view.set_positions(state)
                now = initial_poses | view.moving_poses
                for path in sorted(paths & now.keys()):
                    animation.SetTransform(frame, path, now[path])
                frame += 1
        return animation

    def _changing_paths(self) -> set[str]:
        """Return the paths of bodies that move, appear, disappear, or differ between worlds."""
        found: set[str] = set()
        first: dict[str, RigidTransform] = {}
        for view, states in zip(self._views, self._states, strict=True):
            view.set_positions(states[0])
            poses = view.poses
            found |= view.moving_poses.keys() | (poses.keys() ^ first.keys() if first else set())
            first = first or poses
            found |= {p for p in poses.keys() & first if not poses[p].IsExactlyEqualTo(first[p])}
        return found

    def _aim_camera(self) -> Array:
        """Aim at all moving bodies, at the start, midway and at the end; return their corners."""
        points: list[Array] = []
        obstacles: list[SolidBox] = []
        watched = []
        for motion, view, states in zip(self._motions, self._views, self._states, strict=True):
            for state in states[[0, len(states) // 2, -1]]:
                view.set_positions(state)
                points += [_corners(box) for box in view.boxes(moving=True)]
            obstacles = view.boxes(moving=False)
            instants = np.linspace(0, len(states) - 1, _NUM_CAMERA_INSTANTS).round().astype(int)
            watched += view.watched(motion.group, list(states[instants]))
        if points:
            is_planar = any(
                joint.type is JointType.PLANAR for m in self._motions for joint in m.group.joints
            )
            cloud = np.concatenate(points)
            camera, target = place_camera(cloud, obstacles, watched, from_above=is_planar)
            self._meshcat.SetCameraPose(camera, target)
        return np.concatenate([np.zeros((0, 3)), *points])

    def _labels(self) -> list[Label]:
        """Label objects, frames and robots; links as well, shown on request."""
        labels: list[Label] = []
        for view in self._views:
            labels += [Label(f"/frames/{f.name}", f.name, "frame") for f in view.world.scene.frames]
        robots: set[str] = set()
        for path, shown in self._drawn.items():
            robot, _, link = shown.name.partition("::")
            middle = f"{path}/0"  # of its first shape; the body's origin may be far from it
            if not link:
                labels.append(Label(middle, shown.name, "thing"))
                continue
            if robot not in robots:
                labels.append(Label(middle, robot, "thing"))
            robots.add(robot)
            labels.append(Label(middle, link, "link"))
        return list(dict.fromkeys(labels))

    def _sections(self) -> list[Section]:
        ends = np.cumsum([len(states) for states in self._states]) / self._rate
        titles = [motion.title for motion in self._motions]
        return [Section(title, float(end)) for title, end in zip(titles, ends, strict=True)]


def _corners(box: SolidBox) -> Array:
    """Return the corners of a box in world, shape (8, 3)."""
    signs = np.stack(np.meshgrid(*[[-1.0, 1.0]] * 3), axis=-1).reshape(8, 3)
    return signs * box.half_width @ box.pose[:3, :3].T + box.pose[:3, 3]
