"""WorldView: what of a world shows in a replay, in which colours, and where it is."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64
from pydrake.geometry import GeometryId, Rgba, Role
from pydrake.math import RigidTransform
from pydrake.multibody.tree import Frame, RigidBody

from planning.domain.joints import JointGroup
from planning.world.camera import SolidBox, WatchedPoint
from planning.world.world import World

type Array = np.ndarray[Any, np.dtype[np.float64]]

# For what has no colour of its own: neighbours differ, so that one sees where a link ends.
_PALETTE = (
    Rgba(0.55, 0.63, 0.71),
    Rgba(0.80, 0.71, 0.52),
    Rgba(0.56, 0.69, 0.56),
    Rgba(0.74, 0.58, 0.60),
    Rgba(0.64, 0.58, 0.74),
    Rgba(0.70, 0.70, 0.70),
)


@dataclass(frozen=True)
class ShownBody:
    """A body that shows.

    Attributes:
        name: Its full name.
        path: Its place in Meshcat's tree.
        body: Drake's.
        geometries: What is drawn of it: what it looks like, else its collision shapes.
    """

    name: str
    path: str
    body: RigidBody
    geometries: tuple[GeometryId, ...]


class WorldView:
    """Draws on a world of its own context; one thread."""

    def __init__(self, world: World) -> None:
        """Find what shows."""
        self.world = world
        self.inspector: Any = world.drake.scene_graph.model_inspector()
        self._plant = world.drake.plant
        self._root = world.drake.diagram.CreateDefaultContext()
        self._context = self._plant.GetMyMutableContextFromRoot(self._root)
        fixed = self._plant.GetBodiesWeldedTo(self._plant.world_body())
        self._fixed = {body.index() for body in fixed}
        self.bodies = self._shown_bodies()
        named = {f"/frames/{frame.name}": frame.name for frame in world.scene.frames}
        self._frames: dict[str, Frame] = {
            **{shown.path: shown.body.body_frame() for shown in self.bodies},
            **{path: world.drake.frames[name] for path, name in named.items()},
        }
        self._moving = {p: f for p, f in self._frames.items() if self._moves(f.body())}

    def go_to(self, state: Float64[np.ndarray, " nx"]) -> None:
        """Put everything at a full configuration."""
        self._plant.SetPositions(self._context, state)

    @property
    def poses(self) -> dict[str, RigidTransform]:
        """X_WF of everything that shows, by path."""
        return {p: f.CalcPoseInWorld(self._context) for p, f in self._frames.items()}

    @property
    def moving_poses(self) -> dict[str, RigidTransform]:
        """X_WF of what shows and is not fixed to the world, by path."""
        return {p: f.CalcPoseInWorld(self._context) for p, f in self._moving.items()}

    def color(self, body: RigidBody, geometry: GeometryId) -> Rgba:
        """Return the colour of a geometry, as its description says or one of ours."""
        # Drake answers None for a geometry that only collides, whatever its stubs say.
        properties: Any = self.inspector.GetIllustrationProperties(geometry)
        if properties is not None and properties.HasProperty("phong", "diffuse"):
            found: Rgba = properties.GetProperty("phong", "diffuse")
            return found
        return _PALETTE[int(body.index()) % len(_PALETTE)]

    def pose_of(self, body: RigidBody) -> RigidTransform:
        """Return X_WB of a body."""
        return self._plant.EvalBodyPoseInWorld(self._context, body)

    def tool(self, group: JointGroup) -> Array:
        """Return where the default tool frame of a group is, p_WF, shape (3,)."""
        tool = self.world.drake.frames[group.tool_frames[0]]
        return np.array(tool.CalcPoseInWorld(self._context).translation())

    def boxes(self, *, moving: bool) -> list[SolidBox]:
        """Return the boxes around what shows and moves, or around what shows and does not."""
        boxes: list[SolidBox] = []
        for shown in self.bodies:
            if self._moves(shown.body) is not moving:
                continue
            x_wb = self.pose_of(shown.body)
            for geometry in shown.geometries:
                box = self.inspector.GetObbInGeometryFrame(geometry)
                if box is not None:
                    x_wo = x_wb @ self.inspector.GetPoseInFrame(geometry) @ box.pose()
                    boxes.append(SolidBox(x_wo.GetAsMatrix4(), np.array(box.half_width())))
        return boxes

    def watched(self, group: JointGroup, states: Sequence[Array]) -> list[WatchedPoint]:
        """Return the default tool frame at some states, with what may hide it there."""
        found: list[WatchedPoint] = []
        for state in states if group.tool_frames else ():
            self.go_to(state)
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
            geometries = self.inspector.GetGeometries(
                frame, Role.kIllustration
            ) or self.inspector.GetGeometries(frame, Role.kProximity)
            if geometries:
                path = f"/bodies/{name.replace('::', '/')}"
                body = self._plant.get_body(index)
                found.append(ShownBody(name, path, body, tuple(geometries)))
        return found
