"""WorldView: visible bodies of a world in a replay, with colours and poses."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Float64
from pydrake.geometry import CalcObb, GeometryId, Rgba, Role
from pydrake.math import RigidTransform
from pydrake.multibody.tree import Frame, RigidBody

from planning.domain.arrays import Array
from planning.domain.robot.joints import JointGroup
from planning.world.loading.builder import DEFAULT_COLOR
from planning.world.replay.camera import SolidBox, WatchedPoint
from planning.world.world import World

# Default colours: neighbouring links differ, so that their ends are visible.
_PALETTE = (
    Rgba(0.55, 0.63, 0.71),
    Rgba(0.80, 0.71, 0.52),
    Rgba(0.56, 0.69, 0.56),
    Rgba(0.74, 0.58, 0.60),
    Rgba(0.64, 0.58, 0.74),
    Rgba(0.70, 0.70, 0.70),
)
# Largest number of static objects that count as occluding.
_MAX_OCCLUDING = 200


@dataclass(frozen=True)
class ShownShape:
    """Shape that is drawn.

    Attributes:
        shape: Drake's.
        X_BS: Its pose on its body.
        color: As in its description, or a default one.
        box: Its bounding box, on the shape; None for unbounded shapes.
    """

    shape: Any
    X_BS: RigidTransform
    color: Rgba
    box: Any


@dataclass(frozen=True)
class ShownBody:
    """Body that is drawn.

    Attributes:
        name: Its full name.
        path: Its place in Meshcat's tree.
        body: Drake's; None for an object outside of Drake's model.
        shapes: Its visual shapes, else its collision shapes.
    """

    name: str
    path: str
    body: RigidBody | None
    shapes: tuple[ShownShape, ...]


class WorldView:
    """View of a world by a context of its own; one thread."""

    def __init__(self, world: World) -> None:
        """Collect the visible bodies."""
        self.world = world
        self._inspector: Any = world.drake.scene_graph.model_inspector()
        self._plant = world.drake.plant
        self._root = world.drake.diagram.CreateDefaultContext()
        self._context = self._plant.GetMyMutableContextFromRoot(self._root)
        fixed = self._plant.GetBodiesWeldedTo(self._plant.world_body())
        self._fixed = {body.index() for body in fixed}
        static_objects = world.drake.static_objects
        self.bodies = [*self._shown_bodies(), *self._static_bodies()]
        named = {f"/frames/{frame.name}": frame.name for frame in world.scene.frames}
        self._static_poses = {
            path: static_objects.frames[name]
            for path, name in named.items()
            if name in static_objects.frames
        }
        poses = zip(static_objects.objects, static_objects.poses, strict=True)
        self._static_poses |= {_path(thing.name): pose for thing, pose in poses}
        self._frames: dict[str, Frame] = {
            shown.path: shown.body.body_frame() for shown in self.bodies if shown.body is not None
        } | {
            path: world.drake.frames[name]
            for path, name in named.items()
            if path not in self._static_poses
        }
        self._moving = {p: f for p, f in self._frames.items() if self._moves(f.body())}

    def set_positions(self, state: Float64[np.ndarray, " nx"]) -> None:
        """Set the full configuration."""
        self._plant.SetPositions(self._context, state)

    @property
    def poses(self) -> dict[str, RigidTransform]:
        """X_WF of all visible bodies, by path."""
        found = {p: f.CalcPoseInWorld(self._context) for p, f in self._frames.items()}
        return found | self._static_poses

    @property
    def moving_poses(self) -> dict[str, RigidTransform]:
        """X_WF of the visible bodies that are not fixed to the world, by path."""
        return {p: f.CalcPoseInWorld(self._context) for p, f in self._moving.items()}

    def tool(self, group: JointGroup) -> Array:
        """Return the position of a group's default tool frame, p_WF, shape (3,)."""
        tool = self.world.drake.frames[group.tool_frames[0]]
        return np.array(tool.CalcPoseInWorld(self._context).translation())

    def boxes(self, *, moving: bool) -> list[SolidBox]:
        """Return the bounding boxes of visible bodies that move, or of those that do not."""
        boxes: list[SolidBox] = []
        for shown in self.bodies:
            if shown.body is None or self._moves(shown.body) is not moving:
                continue
            x_wb = self._plant.EvalBodyPoseInWorld(self._context, shown.body)
            boxes += [_solid(x_wb, drawn) for drawn in shown.shapes if drawn.box is not None]
        return boxes if moving else boxes + self._largest_static_boxes

    @cached_property
    def _largest_static_boxes(self) -> list[SolidBox]:
        """Boxes around the largest objects outside of Drake's model."""
        static_bodies = [shown for shown in self.bodies if shown.body is None]
        radii = self.world.drake.static_objects.balls[1]
        largest = [static_bodies[row] for row in np.argsort(-radii, kind="stable")[:_MAX_OCCLUDING]]
        return [
            _solid(self._static_poses[shown.path], drawn)
            for shown in largest
            for drawn in shown.shapes
            if drawn.box is not None
        ]

    def watched(self, group: JointGroup, states: Sequence[Array]) -> list[WatchedPoint]:
        """Return the default tool frame at some states, with the boxes that may hide it there."""
        found: list[WatchedPoint] = []
        for state in states if group.tool_frames else ():
            self.set_positions(state)
            boxes = [*self.boxes(moving=True), *self.boxes(moving=False)]
            found.append(WatchedPoint(self.tool(group), boxes))
        return found

    def _moves(self, body: RigidBody) -> bool:
        return body.index() not in self._fixed

    def _shown_bodies(self) -> list[ShownBody]:
        found: list[ShownBody] = []
        for index, name in self.world.drake.body_names.items():
            frame = self._plant.GetBodyFrameIdIfExists(index)
            if frame is None:
                continue
            geometries = self._inspector.GetGeometries(
                frame, Role.kIllustration
            ) or self._inspector.GetGeometries(frame, Role.kProximity)
            if geometries:
                body = self._plant.get_body(index)
                shapes = tuple(self._shape(body, geometry) for geometry in geometries)
                found.append(ShownBody(name, _path(name), body, shapes))
        return found

    def _shape(self, body: RigidBody, geometry: GeometryId) -> ShownShape:
        inspector = self._inspector
        return ShownShape(
            inspector.GetShape(geometry),
            inspector.GetPoseInFrame(geometry),
            self._color(body, geometry),
            inspector.GetObbInGeometryFrame(geometry),
        )

    def _color(self, body: RigidBody, geometry: GeometryId) -> Rgba:
        # Drake returns None for a geometry that only collides, contrary to its stubs.
        properties: Any = self._inspector.GetIllustrationProperties(geometry)
        if properties is not None and properties.HasProperty("phong", "diffuse"):
            found: Rgba = properties.GetProperty("phong", "diffuse")
            return found
        return _PALETTE[int(body.index()) % len(_PALETTE)]

    def _static_bodies(self) -> list[ShownBody]:
        static_objects = self.world.drake.static_objects
        found: list[ShownBody] = []
        for thing, shape in zip(static_objects.objects, static_objects.drake_shapes, strict=True):
            color = Rgba(*(DEFAULT_COLOR if thing.color is None else thing.color))
            drawn = ShownShape(shape, RigidTransform(), color, CalcObb(shape))
            found.append(ShownBody(thing.name, _path(thing.name), None, (drawn,)))
        return found


def _path(name: str) -> str:
    """Return the place of a body in Meshcat's tree."""
    return f"/bodies/{name.replace('::', '/')}"


def _solid(x_wb: RigidTransform, drawn: ShownShape) -> SolidBox:
    """Return the box around a shape, in world."""
    x_wo = x_wb @ drawn.X_BS @ drawn.box.pose()
    return SolidBox(x_wo.GetAsMatrix4(), np.array(drawn.box.half_width()))
