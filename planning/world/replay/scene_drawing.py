"""SceneDrawing: worlds drawn in a Meshcat, each body once, and their names."""

from collections.abc import Collection

import numpy as np
from jaxtyping import Float64
from pydrake.geometry import Cylinder, HalfSpace, Meshcat, MeshcatParams, Rgba
from pydrake.math import RigidTransform, RotationMatrix

from planning.domain.arrays import Array
from planning.domain.geometry.pose import Pose
from planning.world.replay.camera import SolidBox
from planning.world.replay.half_space_plate import plate_under
from planning.world.replay.replay_page import Label
from planning.world.replay.replay_view import ShownBody, ShownShape, WorldView

_AXIS_COLORS = (Rgba(0.85, 0.1, 0.1, 1.0), Rgba(0.1, 0.65, 0.1, 1.0), Rgba(0.1, 0.2, 0.9, 1.0))
_AXIS_LENGTH, _AXIS_RADIUS = 0.06, 0.0025
_TARGET_LENGTH, _TARGET_RADIUS = 0.15, 0.006
MARKED = Rgba(0.86, 0.10, 0.10, 1.0)
_TINT = 0.45


def open_meshcat() -> Meshcat:
    """Return a Meshcat that listens on the loopback interface until it is dropped."""
    meshcat = Meshcat(MeshcatParams(host="localhost", port=0, show_stats_plot=False))
    for path in ("/Grid", "/Axes"):
        meshcat.SetProperty(path, "visible", value=False)
    return meshcat


class SceneDrawing:
    """Bodies and named frames in a Meshcat.

    Attributes:
        meshcat: That draws.
        drawn: Bodies by their place in its tree.
    """

    def __init__(self, meshcat: Meshcat, marked: Collection[str] = ()) -> None:
        """Draw nothing yet; `marked` are full names of bodies that are drawn in red."""
        self.meshcat = meshcat
        self.drawn: dict[str, ShownBody] = {}
        self._marked = frozenset(marked)
        self._half_spaces: list[tuple[WorldView, ShownBody, str, ShownShape]] = []

    def add(self, view: WorldView) -> None:
        """Draw the bodies that no earlier world has shown, and the named frames."""
        for shown in view.bodies:
            if shown.path not in self.drawn:
                self.drawn[shown.path] = shown
                self._draw_body(view, shown)
        self._draw_frames(view)

    def add_ghost(self, view: WorldView, color: Rgba) -> None:
        """Draw the bodies that move once more where the view has them, in one colour."""
        poses = view.moving_poses
        for shown in view.bodies:
            if shown.path not in poses:
                continue
            for i, drawn in enumerate(shown.shapes):
                path = f"/ghost{shown.path}/{i}"
                self.meshcat.SetObject(path, drawn.shape, color)
                self.meshcat.SetTransform(path, poses[shown.path] @ drawn.X_BS)

    def draw_target(self, target: Pose) -> Label:
        """Draw a tool pose as large axes, and return its label."""
        x_wt = RigidTransform(target.matrix)
        self._draw_axes("/target", x_wt, _TARGET_LENGTH, _TARGET_RADIUS)
        return Label("/target/2", "goal", "frame")

    def place(self, view: WorldView) -> None:
        """Put everything where the view has it."""
        for path, pose in view.poses.items():
            self.meshcat.SetTransform(path, pose)

    def draw_half_spaces(self, points: Float64[np.ndarray, "n 3"]) -> None:
        """Draw every half space as a plate under some points in world."""
        for view, shown, path, drawn in self._half_spaces:
            plate, x_gp = plate_under(view.poses[shown.path] @ drawn.X_BS, points)
            self.meshcat.SetObject(path, plate, self._color(shown, drawn))
            self.meshcat.SetTransform(path, drawn.X_BS @ x_gp)

    def labels(self) -> list[Label]:
        """Label bodies: objects and robots, and links, which are shown on request."""
        labels: list[Label] = []
        robots: set[str] = set()
        for path, shown in self.drawn.items():
            robot, _, link = shown.name.partition("::")
            middle = f"{path}/0"  # of its first shape; the body's origin may be far from it
            if not link:
                labels.append(Label(middle, shown.name, "thing"))
                continue
            if robot not in robots:
                labels.append(Label(middle, robot, "thing"))
            robots.add(robot)
            kind = "thing" if shown.name in self._marked else "link"
            labels.append(Label(middle, link, kind))
        return labels

    def _draw_body(self, view: WorldView, shown: ShownBody) -> None:
        for i, drawn in enumerate(shown.shapes):
            path = f"{shown.path}/{i}"
            if isinstance(drawn.shape, HalfSpace):  # drawn once the camera is aimed
                self._half_spaces.append((view, shown, path, drawn))
                continue
            self.meshcat.SetObject(path, drawn.shape, self._color(shown, drawn))
            self.meshcat.SetTransform(path, drawn.X_BS)

    def _color(self, shown: ShownBody, drawn: ShownShape) -> Rgba:
        """Return red for a marked link, a tint of it for a marked object, which may be a floor."""
        if shown.name not in self._marked:
            return drawn.color
        share, own = (1.0 if "::" in shown.name else _TINT), drawn.color
        red, green, blue = (
            share * mark + (1 - share) * plain
            for mark, plain in zip(_channels(MARKED), _channels(own), strict=True)
        )
        return Rgba(red, green, blue, own.a())

    def _draw_frames(self, view: WorldView) -> None:
        """Draw the scene's named frames as small triads, which `place` moves."""
        for named in view.world.scene.frames:
            path = f"/frames/{named.name}"
            self._draw_axes(path, RigidTransform(), _AXIS_LENGTH, _AXIS_RADIUS)

    def _draw_axes(self, path: str, x_wf: RigidTransform, length: float, radius: float) -> None:
        """Draw three bars along the axes of a frame F [m]."""
        turns = (
            RotationMatrix.MakeYRotation(np.pi / 2),
            RotationMatrix.MakeXRotation(-np.pi / 2),
            RotationMatrix(),
        )
        self.meshcat.SetTransform(path, x_wf)
        for i, turn in enumerate(turns):
            bar, center = Cylinder(radius, length), length / 2 * np.eye(3)[i]
            self.meshcat.SetObject(f"{path}/{i}", bar, _AXIS_COLORS[i])
            self.meshcat.SetTransform(f"{path}/{i}", RigidTransform(turn, center))


def _channels(color: Rgba) -> tuple[float, float, float]:
    return color.r(), color.g(), color.b()


def frame_labels(view: WorldView) -> list[Label]:
    """Label the named frames of a scene."""
    return [Label(f"/frames/{f.name}", f.name, "frame") for f in view.world.scene.frames]


def box_corners(box: SolidBox) -> Array:
    """Return the corners of a box in world, shape (8, 3)."""
    signs = np.stack(np.meshgrid(*[[-1.0, 1.0]] * 3), axis=-1).reshape(8, 3)
    return signs * box.half_width @ box.pose[:3, :3].T + box.pose[:3, 3]
