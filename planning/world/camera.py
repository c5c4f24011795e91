"""Camera: from where to look at what moves, with as little as possible in the way."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64

type Array = np.ndarray[Any, np.dtype[np.float64]]

# Three quarters from the front first, then around, then from higher up.
_AZIMUTHS = np.deg2rad([-40.0, 40.0, -75.0, 75.0, -110.0, 110.0, -150.0, 150.0])
_ELEVATIONS = np.deg2rad([25.0, 45.0, 70.0])
_FROM_ABOVE = np.array([0.0, -0.3, 1.0])
# Meshcat's field of view is 75 degrees: at this distance a ball of radius 1 fills most of it.
_DISTANCE_PER_RADIUS = 1.5
# A sight line ends short of its point, which may lie on a surface.
_REACH = 0.97


@dataclass(frozen=True)
class SolidBox:
    """A box in the way.

    Attributes:
        pose: X_WB, shape (4, 4).
        half_width: Half its side lengths [m], shape (3,).
    """

    pose: Float64[np.ndarray, "4 4"]
    half_width: Float64[np.ndarray, "3"]


def place_camera(
    points: Float64[np.ndarray, "n 3"], obstacles: list[SolidBox], *, from_above: bool = False
) -> tuple[Float64[np.ndarray, "3"], Float64[np.ndarray, "3"]]:
    """Return where the camera is and what it looks at, p_WC and p_WT.

    Of some viewpoints around the points, the first from which the most of them can be seen.

    Args:
        points: What is to be seen, in world [m], n >= 1.
        obstacles: What may hide it.
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
    cameras = [target + _DISTANCE_PER_RADIUS * radius * direction for direction in directions]
    # max() keeps the first of equals, which is the preferred one.
    best = max(cameras, key=lambda camera: num_visible(camera, points, obstacles))
    return best, target


def num_visible(
    camera: Float64[np.ndarray, "3"], points: Float64[np.ndarray, "n 3"], obstacles: list[SolidBox]
) -> int:
    """Return how many of the points the camera sees past the obstacles."""
    hidden = np.zeros(len(points), dtype=bool)
    for box in obstacles:
        hidden |= _crosses(box, camera, points)
    return int(np.sum(~hidden))


def _crosses(box: SolidBox, camera: Array, points: Array) -> np.ndarray[Any, np.dtype[np.bool_]]:
    """Return whether each sight line meets the box, by its three slabs (Kay and Kajiya, 1986)."""
    turn, shift = box.pose[:3, :3], box.pose[:3, 3]
    start = (camera - shift) @ turn
    step = _REACH * (points - camera) @ turn
    step = np.where(np.abs(step) < 1e-12, 1e-12, step)
    first, second = (-box.half_width - start) / step, (box.half_width - start) / step
    enter = np.max(np.minimum(first, second), axis=1)
    leave = np.min(np.maximum(first, second), axis=1)
    return (enter <= leave) & (leave >= 0) & (enter <= 1)
