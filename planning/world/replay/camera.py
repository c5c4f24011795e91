"""Camera placement: a viewpoint from which moving bodies are visible with little occlusion."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array

# Three quarters from the front first, then around, then from higher up.
_AZIMUTHS = np.deg2rad([-40.0, 40.0, -75.0, 75.0, -110.0, 110.0, -150.0, 150.0])
_ELEVATIONS = np.deg2rad([25.0, 45.0, 70.0])
_FROM_ABOVE = np.array([0.0, -0.3, 1.0])
# Meshcat's field of view is 75 degrees: at this distance a ball of radius 1 fills most of it.
_DISTANCE_PER_RADIUS = 1.5
# Weight of all watched points together, where all others together weigh 1.
_WATCHED_WEIGHT = 2.0
# A sight line ends short of its point, which may lie on a surface.
_SIGHT_LINE_FRACTION = 0.97


@dataclass(frozen=True)
class SolidBox:
    """Oriented box that occludes.

    Attributes:
        pose: X_WB, shape (4, 4).
        half_width: Half its side lengths [m], shape (3,).
    """

    pose: Float64[np.ndarray, "4 4"]
    half_width: Float64[np.ndarray, "3"]


@dataclass(frozen=True)
class WatchedPoint:
    """Point of higher weight, at one instant.

    Attributes:
        point: p_WP [m], shape (3,).
        obstacles: Boxes that may hide it at that instant; a box that contains it does not.
    """

    point: Float64[np.ndarray, "3"]
    obstacles: list[SolidBox]


def place_camera(
    points: Float64[np.ndarray, "n 3"],
    obstacles: list[SolidBox],
    watched: Sequence[WatchedPoint] = (),
    *,
    from_above: bool = False,
) -> tuple[Float64[np.ndarray, "3"], Float64[np.ndarray, "3"]]:
    """Return the camera's position and target, p_WC and p_WT.

    Of some viewpoints around the points, the first from which most of them are visible; the
    watched ones together count twice as much as the others together.

    Args:
        points: Points to show, in world [m], n >= 1.
        obstacles: Boxes that may hide them.
        watched: Points of higher weight, such as the tool during the motion.
        from_above: Whether a view from above is preferred.
    """
    lower, upper = points.min(axis=0), points.max(axis=0)
    target = (lower + upper) / 2
    radius = max(float(np.linalg.norm(upper - lower)) / 2, 0.1)
    around = [
        np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
        for e in _ELEVATIONS
        for a in _AZIMUTHS
    ]
    above = _FROM_ABOVE / np.linalg.norm(_FROM_ABOVE)
    directions = [above, *around] if from_above else [*around, above]
    cameras = np.array([target + _DISTANCE_PER_RADIUS * radius * turn for turn in directions])
    visibility = np.array([num_visible(camera, points, obstacles) for camera in cameras]) / len(
        points
    )
    if watched:
        visibility = visibility + _WATCHED_WEIGHT * np.mean(
            [_sees(cameras, one) for one in watched], axis=0
        )
    # argmax() takes the first of equals, which is the preferred one.
    return cameras[int(np.argmax(visibility))], target


def num_visible(
    camera: Float64[np.ndarray, "3"], points: Float64[np.ndarray, "n 3"], obstacles: list[SolidBox]
) -> int:
    """Return the number of points that the camera sees past the obstacles."""
    hidden = np.zeros(len(points), dtype=bool)
    for box in obstacles:
        hidden |= _crosses(box, camera, points)
    return int(np.sum(~hidden))


def _sees(cameras: Array, watched: WatchedPoint) -> np.ndarray[Any, np.dtype[np.bool_]]:
    """Return which cameras, shape (n, 3), see a watched point."""
    hidden = np.zeros(len(cameras), dtype=bool)
    for box in watched.obstacles:
        inside = np.abs((watched.point - box.pose[:3, 3]) @ box.pose[:3, :3]) <= box.half_width
        if not inside.all():
            hidden |= _crosses(box, watched.point, cameras)
    return ~hidden


def _crosses(box: SolidBox, camera: Array, points: Array) -> np.ndarray[Any, np.dtype[np.bool_]]:
    """Return whether each sight line meets the box, by its three slabs (Kay and Kajiya, 1986)."""
    R_WB, p_WB = box.pose[:3, :3], box.pose[:3, 3]
    start = (camera - p_WB) @ R_WB
    step = _SIGHT_LINE_FRACTION * (points - camera) @ R_WB
    step = np.where(np.abs(step) < 1e-12, 1e-12, step)
    first, second = (-box.half_width - start) / step, (box.half_width - start) / step
    enter = np.max(np.minimum(first, second), axis=1)
    leave = np.min(np.maximum(first, second), axis=1)
    return (enter <= leave) & (leave >= 0) & (enter <= 1)
