"""Replay: a motion as one HTML page that needs no server, by Drake's Meshcat."""

from typing import Any

import numpy as np
from jaxtyping import Float64
from pydrake.geometry import (
    CalcObb,
    Cylinder,
    GeometryId,
    HalfSpace,
    Meshcat,
    MeshcatAnimation,
    MeshcatParams,
    Rgba,
    Role,
)
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.tree import Frame

from planning.domain.curve import TimedTrajectory
from planning.domain.joints import JointGroup, JointType
from planning.world.builder import DEFAULT_COLOR
from planning.world.camera import SolidBox, place_camera
from planning.world.half_space_plate import plate_under
from planning.world.world import World

type Array = np.ndarray[Any, np.dtype[np.float64]]

_DEFAULT_COLOR = Rgba(0.7, 0.7, 0.7, 1.0)
_TRACE_COLOR = Rgba(0.95, 0.45, 0.05, 1.0)
_AXIS_COLORS = (Rgba(0.85, 0.1, 0.1, 1.0), Rgba(0.1, 0.65, 0.1, 1.0), Rgba(0.1, 0.2, 0.9, 1.0))
_AXIS_LENGTH, _AXIS_RADIUS = 0.06, 0.0025
# Twice the number of frames gives a smoother line than the animation needs.
_TRACE_POINTS_PER_FRAME = 2
_FOREVER = 1_000_000
# Of thousands of objects so many count as being in the camera's way.
_MOST_IN_THE_WAY = 200
# Of longer motions there are fewer frames a second, so that a browser can open the page.
MOST_FRAMES = 10_000


def replay_html(
    world: World,
    group: JointGroup,
    trajectory: TimedTrajectory,
    frames_per_second: float = 30.0,
    most_frames: int = MOST_FRAMES,
) -> str:
    """Return a page that shows the motion over and over, with the path of the tool frame.

    Meshcat insists on a web server while it works: it listens on the loopback interface, on a port
    that the system chooses, and is gone when this returns.

    Args:
        world: Where; what `group` does not move stays at the world's state.
        group: What moves.
        trajectory: Of the group.
        frames_per_second: Of the animation; fewer where there would be more than `most_frames`.
        most_frames: Of the animation.
    """
    meshcat = Meshcat(MeshcatParams(host="localhost", port=0, show_stats_plot=False))
    rate = min(frames_per_second, most_frames / trajectory.duration)
    return _Replay(world, meshcat).page(group, trajectory, rate)


class _Replay:
    """Draws a world in Meshcat and moves what moves."""

    def __init__(self, world: World, meshcat: Meshcat) -> None:
        self._world = world
        self._plant = world.drake.plant
        self._inspector = world.drake.scene_graph.model_inspector()
        self._meshcat = meshcat
        self._root = world.drake.diagram.CreateDefaultContext()
        self._context = self._plant.GetMyMutableContextFromRoot(self._root)
        fixed = self._plant.GetBodiesWeldedTo(self._plant.world_body())
        self._fixed = {body.index() for body in fixed}
        self._flat: list[tuple[str, GeometryId, Any]] = []

    def page(self, group: JointGroup, trajectory: TimedTrajectory, rate: float) -> str:
        """Draw everything and return the page."""
        states = self._states(group, trajectory, rate)
        self._plant.SetPositions(self._context, states[0])
        drawn = {**self._draw_bodies(), **self._draw_frames()}
        for path, frame in drawn.items():
            self._meshcat.SetTransform(path, frame.CalcPoseInWorld(self._context))
        self._draw_standing()
        self._draw_half_spaces(self._aim_camera(group, states))
        self._draw_trace(group, self._states(group, trajectory, rate * _TRACE_POINTS_PER_FRAME))
        self._meshcat.SetAnimation(self._animation(drawn, states, rate))
        for path in ("/Grid", "/Axes"):
            self._meshcat.SetProperty(path, "visible", value=False)
        return self._meshcat.StaticHtml()

    def _states(self, group: JointGroup, trajectory: TimedTrajectory, rate: float) -> Array:
        """Return full configurations, `rate` a second, shape (n, num_positions)."""
        times = trajectory.sample_times(1.0 / rate)
        return self._world.drake.embed(group, trajectory.positions(times), self._world.state)

    def _visible(self) -> list[tuple[Frame, str, list[GeometryId]]]:
        """Return every body that shows: its frame, its Meshcat path and what it shows."""
        visible: list[tuple[Frame, str, list[GeometryId]]] = []
        for index, name in self._world.drake.body_names.items():
            body = self._plant.get_body(index)
            frame_id = self._plant.GetBodyFrameIdIfExists(index)
            if frame_id is None:
                continue
            geometries = list(self._inspector.GetGeometries(frame_id, Role.kIllustration))
            if geometries:
                path = f"/bodies/{name.replace('::', '/')}"
                visible.append((body.body_frame(), path, geometries))
        return visible

    def _draw_bodies(self) -> dict[str, Frame]:
        """Draw the bodies and return their frames by path."""
        drawn: dict[str, Frame] = {}
        for frame, path, geometries in self._visible():
            for i, geometry in enumerate(geometries):
                self._draw_geometry(f"{path}/{i}", geometry)
            drawn[path] = frame
        return drawn

    def _draw_geometry(self, path: str, geometry: GeometryId) -> None:
        # Drake answers None for a geometry that only collides, whatever its stubs say.
        properties: Any = self._inspector.GetIllustrationProperties(geometry)
        color: Any = _DEFAULT_COLOR
        if properties is not None and properties.HasProperty("phong", "diffuse"):
            color = properties.GetProperty("phong", "diffuse")
        shape = self._inspector.GetShape(geometry)
        if isinstance(shape, HalfSpace):  # drawn where the camera looks, once that is known
            self._flat.append((path, geometry, color))
            return
        self._meshcat.SetObject(path, shape, color)
        self._meshcat.SetTransform(path, self._inspector.GetPoseInFrame(geometry))

    def _draw_standing(self) -> None:
        """Draw what stands outside of Drake's model."""
        standing = self._world.drake.standing
        for thing, shape, pose in zip(
            standing.things, standing.drake_shapes, standing.poses, strict=True
        ):
            path = f"/bodies/{thing.name}"
            color = DEFAULT_COLOR if thing.color is None else thing.color
            self._meshcat.SetObject(f"{path}/0", shape, Rgba(*color))
            self._meshcat.SetTransform(path, pose)

    def _draw_half_spaces(self, points: Array) -> None:
        """Draw every half space as a plate under some points in world, shape (n, 3)."""
        for path, geometry, color in self._flat:
            x_bg = self._inspector.GetPoseInFrame(geometry)
            body = self._plant.GetBodyFromFrameId(self._inspector.GetFrameId(geometry))
            x_wg = body.EvalPoseInWorld(self._context) @ x_bg
            plate, x_gp = plate_under(x_wg, points)
            self._meshcat.SetObject(path, plate, color)
            self._meshcat.SetTransform(path, x_bg @ x_gp)

    def _draw_frames(self) -> dict[str, Frame]:
        """Draw the scene's named frames as small triads and return them by path."""
        turns = (
            RotationMatrix.MakeYRotation(np.pi / 2),
            RotationMatrix.MakeXRotation(-np.pi / 2),
            RotationMatrix(),
        )
        bar = Cylinder(_AXIS_RADIUS, _AXIS_LENGTH)
        drawn: dict[str, Frame] = {}
        for named in self._world.scene.frames:
            path = f"/frames/{named.name}"
            standing = self._world.drake.standing.frames.get(named.name)
            if standing is None:
                drawn[path] = self._world.drake.frames[named.name]
            else:
                self._meshcat.SetTransform(path, standing)
            for i, turn in enumerate(turns):
                center = _AXIS_LENGTH / 2 * np.eye(3)[i]
                self._meshcat.SetObject(f"{path}/{i}", bar, _AXIS_COLORS[i])
                self._meshcat.SetTransform(f"{path}/{i}", RigidTransform(turn, center))
        return drawn

    def _draw_trace(self, group: JointGroup, states: Float64[np.ndarray, "n nx"]) -> None:
        """Draw where the default tool frame goes."""
        if not group.tool_frames:
            return
        tool = self._world.drake.frames[group.tool_frames[0]]
        points = np.empty((3, len(states)))
        for i, state in enumerate(states):
            self._plant.SetPositions(self._context, state)
            points[:, i] = tool.CalcPoseInWorld(self._context).translation()
        self._meshcat.SetLine("/trace", points, 4.0, _TRACE_COLOR)

    def _animation(
        self, drawn: dict[str, Frame], states: Float64[np.ndarray, "n nx"], rate: float
    ) -> MeshcatAnimation:
        animation = MeshcatAnimation(rate)
        animation.set_loop_mode(MeshcatAnimation.LoopMode.kLoopRepeat)
        animation.set_repetitions(_FOREVER)
        moving = {p: f for p, f in drawn.items() if f.body().index() not in self._fixed}
        for i, state in enumerate(states):
            self._plant.SetPositions(self._context, state)
            for path, frame in moving.items():
                animation.SetTransform(i, path, frame.CalcPoseInWorld(self._context))
        return animation

    def _aim_camera(self, group: JointGroup, states: Float64[np.ndarray, "n nx"]) -> Array:
        """Show all that moves, at the start, on the way and at the end; return its corners."""
        points: list[Array] = []
        for state in states[[0, len(states) // 2, -1]]:
            self._plant.SetPositions(self._context, state)
            points += [_corners(box) for box in self._boxes(moving=True)]
        if points:
            in_plane = any(joint.type is JointType.PLANAR for joint in group.joints)
            around = self._boxes(moving=False)
            camera, target = place_camera(np.concatenate(points), around, from_above=in_plane)
            self._meshcat.SetCameraPose(camera, target)
        return np.concatenate([np.zeros((0, 3)), *points])

    def _boxes(self, *, moving: bool) -> list[SolidBox]:
        """Return the boxes around what shows and moves, or around what shows and does not."""
        boxes: list[SolidBox] = []
        for frame, _, geometries in self._visible():
            if (frame.body().index() in self._fixed) is moving:
                continue
            x_wf = frame.CalcPoseInWorld(self._context)
            for geometry in geometries:
                box = self._inspector.GetObbInGeometryFrame(geometry)
                if box is not None:
                    x_wb = x_wf @ self._inspector.GetPoseInFrame(geometry) @ box.pose()
                    boxes.append(SolidBox(x_wb.GetAsMatrix4(), np.array(box.half_width())))
        return boxes if moving else boxes + self._largest_standing()

    def _largest_standing(self) -> list[SolidBox]:
        """Return boxes around what stands outside of Drake's model: of the largest objects."""
        standing = self._world.drake.standing
        radii = standing.balls[1]
        boxes: list[SolidBox] = []
        for row in np.argsort(-radii, kind="stable")[:_MOST_IN_THE_WAY].tolist():
            box = CalcObb(standing.drake_shapes[row])
            if box is not None:
                x_wb = standing.poses[row] @ box.pose()
                boxes.append(SolidBox(x_wb.GetAsMatrix4(), np.array(box.half_width())))
        return boxes


def _corners(box: SolidBox) -> Array:
    """Return the corners of a box in world, shape (8, 3)."""
    signs = np.stack(np.meshgrid(*[[-1.0, 1.0]] * 3), axis=-1).reshape(8, 3)
    return signs * box.half_width @ box.pose[:3, :3].T + box.pose[:3, 3]
