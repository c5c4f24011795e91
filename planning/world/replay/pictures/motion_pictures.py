"""motion_pictures(): a motion at some instants, all from one side, as PNG files."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.robot.joints import JointGroup, JointType
from planning.domain.scene.geometry import SceneMotion
from planning.domain.value import Value
from planning.world.replay.camera import place_camera
from planning.world.replay.pictures.png import png
from planning.world.replay.pictures.shade import shade
from planning.world.replay.pictures.surface import Surface, joined, surface_of, tube
from planning.world.replay.pictures.view_point import ViewPoint, view_of
from planning.world.replay.replay_view import WorldView
from planning.world.replay.scene_drawing import box_corners
from planning.world.replay.scene_motion import scene_motion
from planning.world.world import World

# Points of the tool's path, and at how many instants the whole robot is to be in the picture.
_NUM_POINTS, _NUM_FRAMED = 61, 5
_TRACE, _MARK = np.array([0.95, 0.45, 0.05]), np.array([0.86, 0.10, 0.10])
# Of lines, over the size of what is shown.
_TRACE_RADIUS, _SEGMENT_RADIUS = 0.004, 0.005
# Share of the mark in the colour of what is marked.
_TINT = 0.6


@dataclass(frozen=True, eq=False)
class Instant(Value):
    """What a picture shows.

    Attributes:
        time: Since the beginning [s].
        marked: Full names of bodies to show in red.
        segment: Ends of a line to draw in red, such as nearest points, shape (2, 3) [m]; no row
            for none.
    """

    time: float
    marked: tuple[str, ...]
    segment: Float64[np.ndarray, "k 3"]


def motion_pictures(
    world: World,
    group: JointGroup,
    trajectory: TimedTrajectory,
    instants: Sequence[Instant],
    size: tuple[int, int] = (420, 330),
) -> list[bytes]:
    """Return a picture per instant, with the path of the tool frame; the same bytes each time.

    Args:
        world: The scene; joints outside of the group stay at its state.
        group: That moves.
        trajectory: Of the group.
        instants: What to show.
        size: Width and height [pixel].
    """
    shown = np.array([instant.time for instant in instants])
    times = np.concatenate([shown, np.linspace(0.0, trajectory.duration, _NUM_POINTS)])
    rows = trajectory.positions(times.clip(0.0, trajectory.duration))
    motion = scene_motion(world, group, rows)
    cloud, view = _aimed(world, group, rows[len(shown) :], size)
    surfaces = {body.name: surface_of(body, motion.meshes) for body in motion.bodies}
    extent = float(np.linalg.norm(np.ptp(cloud, axis=0)))
    path = _line(motion.tool_path[len(shown) :], _TRACE, _TRACE_RADIUS * extent)
    return [
        png(
            shade(
                joined([
                    *_placed(surfaces, motion, i, instant.marked),
                    path,
                    _line(instant.segment, _MARK, _SEGMENT_RADIUS * extent),
                ]),
                view,
                cloud,
            )
        )
        for i, instant in enumerate(instants)
    ]


def _placed(
    surfaces: dict[str, Surface], motion: SceneMotion, i: int, marked: Sequence[str]
) -> list[Surface]:
    """Return all bodies where they are at an instant."""
    found: list[Surface] = []
    for name, surface in surfaces.items():
        pose = motion.fixed[name].matrix if name in motion.fixed else motion.moving[name][i]
        found.append((_tinted(surface) if name in marked else surface).placed(pose))
    return found


def _tinted(surface: Surface) -> Surface:
    colors = surface.colors.copy()
    colors[:, :3] += _TINT * (_MARK - colors[:, :3])
    return Surface(surface.corners, surface.normals, colors)


def _line(points: Array, color: Array, radius: float) -> Surface:
    if len(points) < 2:
        return joined([])
    return tube(points, np.tile(color, (len(points), 1)), radius)


def _aimed(
    world: World, group: JointGroup, rows: Array, size: tuple[int, int]
) -> tuple[Array, ViewPoint]:
    """Return corners of what moves during the motion, shape (n, 3), and a view of all of them."""
    view = WorldView(world)
    chosen = np.linspace(0, len(rows) - 1, _NUM_FRAMED).round().astype(int)
    states = world.embed(group, rows[chosen])
    corners: list[Array] = []
    for state in states:
        view.set_positions(state)
        corners += [box_corners(box) for box in view.boxes(moving=True)]
    cloud = np.concatenate([np.zeros((0, 3)), *corners])
    if not len(cloud):
        cloud = np.zeros((1, 3))
    is_planar = any(joint.type is JointType.PLANAR for joint in group.joints)
    watched = view.watched(group, list(states))
    fixed = view.boxes(moving=False)
    camera, target = place_camera(cloud, fixed, watched, from_above=is_planar)
    return cloud, view_of(cloud, camera - target, *size)
