"""Replay: motions as one HTML page that needs no server, by Drake's Meshcat."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from pydrake.geometry import Meshcat, MeshcatAnimation, Rgba

from planning.domain.arrays import Array
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.robot.joints import JointGroup, JointType
from planning.world.replay.camera import SolidBox, place_camera
from planning.world.replay.replay_page import Label, Section, Track, labelled
from planning.world.replay.replay_view import WorldView
from planning.world.replay.scene_drawing import (
    SceneDrawing,
    box_corners,
    frame_labels,
    open_meshcat,
)
from planning.world.world import World

if TYPE_CHECKING:
    from pydrake.math import RigidTransform

_TRACE_COLOR = Rgba(0.95, 0.45, 0.05, 1.0)
# Twice the number of frames gives a smoother line than the animation needs.
_TRACE_POINTS_PER_FRAME = 2
_NUM_REPETITIONS = 1_000_000
# Longer motions have fewer frames a second, so that a browser can open the page.
MAX_FRAMES = 10_000
# Number of instants of each motion at which the tool should be visible.
_NUM_CAMERA_INSTANTS = 5
# Number of points of a curve in the plot of a motion.
_NUM_PLOT_POINTS = 200


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
    duration = sum(motion.trajectory.duration for motion in motions)
    return _Replay(motions, open_meshcat(), min(frames_per_second, max_frames / duration)).page()


class _Replay:
    """Writer of worlds and their animation to Meshcat."""

    def __init__(self, motions: Sequence[ShownMotion], meshcat: Meshcat, rate: float) -> None:
        self._motions, self._meshcat, self._rate = motions, meshcat, rate
        views: dict[int, WorldView] = {}
        self._views = [views.setdefault(id(m.world), WorldView(m.world)) for m in motions]
        self._states = [motion.states(rate) for motion in motions]
        self._drawing = SceneDrawing(meshcat)

    def page(self) -> str:
        """Draw everything and return the page."""
        for view in self._views:
            self._drawing.add(view)
        for view, states in zip(self._views[::-1], self._states[::-1], strict=True):
            view.set_positions(states[0])  # in the end, everything is where the first motion begins
            self._drawing.place(view)
        self._drawing.draw_half_spaces(self._aim_camera())
        for i in range(len(self._motions)):
            self._draw_trace(i)
        self._meshcat.SetAnimation(self._animation())
        return labelled(
            self._meshcat.StaticHtml(),
            self._motions[0].world.scene.name,
            self._labels(),
            self._sections(),
            self._tracks(),
        )

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
                points += [box_corners(box) for box in view.boxes(moving=True)]
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
        frames = [label for view in self._views for label in frame_labels(view)]
        return list(dict.fromkeys([*frames, *self._drawing.labels()]))

    def _tracks(self) -> list[Track]:
        """Return the moving coordinates of each motion, for the plot under the slider."""
        begins = np.cumsum([0, *(len(states) for states in self._states)]) / self._rate
        tracks: list[Track] = []
        for motion, begin in zip(self._motions, begins, strict=False):
            until = motion.until or motion.trajectory.duration
            times = np.linspace(0.0, until, _NUM_PLOT_POINTS)
            positions = motion.trajectory.positions(times)
            shown = (begin + times).round(4).tolist()
            for name, column in zip(motion.group.position_names, positions.T, strict=True):
                tracks.append(Track(name, shown, column.round(5).tolist()))
        return tracks

    def _sections(self) -> list[Section]:
        ends = np.cumsum([len(states) for states in self._states]) / self._rate
        titles = [motion.title for motion in self._motions]
        return [Section(title, float(end)) for title, end in zip(titles, ends, strict=True)]
