"""Stills: a scene at one configuration as an HTML page that needs no server, by Drake's Meshcat."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64
from pydrake.geometry import Rgba, Sphere
from pydrake.math import RigidTransform

from planning.domain.arrays import Array
from planning.domain.geometry.body_pair import BodyPair
from planning.domain.geometry.pose import Pose
from planning.world.replay.camera import WatchedPoint, place_camera
from planning.world.replay.replay_page import labelled
from planning.world.replay.replay_view import WorldView
from planning.world.replay.scene_drawing import (
    MARKED,
    SceneDrawing,
    box_corners,
    frame_labels,
    open_meshcat,
)
from planning.world.world import World

_GHOST = Rgba(0.16, 0.62, 0.24, 0.35)
_POINT_RADIUS = 0.008


@dataclass(frozen=True)
class Still:
    """What a page shows of a scene.

    Attributes:
        title: Above the picture.
        notes: Lines of text below the title.
        state: Full configuration; None for the scene's.
        pairs: Bodies to show in red, with their nearest points.
        marked: Further bodies to show in red, by their full names.
        ghost: Full configuration that is drawn once more, green and translucent.
        target: X_WT of a tool pose to show as axes; None for none.
    """

    title: str
    notes: Sequence[str] = ()
    state: Float64[np.ndarray, " nx"] | None = None
    pairs: Sequence[BodyPair] = ()
    marked: Sequence[str] = ()
    ghost: Float64[np.ndarray, " nx"] | None = None
    target: Pose | None = None


def still_html(world: World, still: Still) -> str:
    """Return a page with a scene that can be turned and looked into.

    Args:
        world: The scene.
        still: What to show of it.
    """
    view = WorldView(world)
    if still.state is not None:
        view.set_positions(still.state)
    marked = {name for pair in still.pairs for name in pair.bodies} | {*still.marked}
    drawing = SceneDrawing(open_meshcat(), marked)
    drawing.add(view)
    drawing.place(view)
    labels = [*frame_labels(view), *drawing.labels()]
    if still.target is not None:
        labels.append(drawing.draw_target(still.target))
    drawing.draw_half_spaces(_aim_camera(drawing, view, still))
    for i, pair in enumerate(still.pairs):
        _draw_pair(drawing, pair, f"/pairs/{i}")
    if still.ghost is not None:
        view.set_positions(still.ghost)
        drawing.add_ghost(view, _GHOST)
    return labelled(drawing.meshcat.StaticHtml(), still.title, labels, notes=still.notes)


def _draw_pair(drawing: SceneDrawing, pair: BodyPair, path: str) -> None:
    """Draw the nearest points of two bodies, and the segment between them."""
    for k, point in enumerate(pair.points):
        drawing.meshcat.SetObject(f"{path}/{k}", Sphere(_POINT_RADIUS), MARKED)
        drawing.meshcat.SetTransform(f"{path}/{k}", RigidTransform(point))
    drawing.meshcat.SetLine(f"{path}/segment", np.array(pair.points).T, 6.0, MARKED)


def _aim_camera(drawing: SceneDrawing, view: WorldView, still: Still) -> Array:
    """Aim at what moves, or else at all that stands; return its corners, shape (n, 3)."""
    moving, fixed = view.boxes(moving=True), view.boxes(moving=False)
    if still.ghost is not None:
        view.set_positions(still.ghost)
        moving += view.boxes(moving=True)
    corners = [box_corners(box) for box in moving or fixed]
    if still.target is not None:
        corners.append(still.target.position[None])
    points = np.concatenate([np.zeros((0, 3)), *corners])
    if len(points):
        hiding = [*moving, *fixed]
        seen = [WatchedPoint(point, hiding) for pair in still.pairs for point in pair.points]
        camera, target = place_camera(points, fixed if moving else [], seen)
        drawing.meshcat.SetCameraPose(camera, target)
    return points
