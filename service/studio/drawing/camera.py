"""place_camera(): a viewpoint from which the robots are seen, past what stands around them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import trimesh

from service.studio.numbers import Array

# Three quarters from the front first, then around.
_AZIMUTHS = np.deg2rad([-40.0, 40.0, -75.0, 75.0, -110.0, 110.0, -145.0, 145.0])
_ELEVATION = np.deg2rad(27.0)
_DISTANCE_PER_SIZE = 0.72
# The panel covers the right of the page: what is looked at is left of the middle, by this share.
_SHIFT = 0.1
# Around these origins [m].
_AROUND = 0.2
# A floor or a table top: wider than so much and thinner than that [m].
_WIDE, _THIN = 0.5, 0.06
# What is further from the robots is not worth a step back [m].
_FAR = 2.5


@dataclass(frozen=True)
class SeenBox:
    """A box that stands in the world.

    Attributes:
        X_WB: Its pose, shape (4, 4).
        half: Half its sides [m], shape (3,).
    """

    X_WB: Array
    half: Array

    @property
    def corners(self) -> Array:
        """Its corners in world [m], shape (8, 3)."""
        signs = np.stack(np.meshgrid(*[[-1.0, 1.0]] * 3), axis=-1).reshape(8, 3)
        return signs * self.half @ self.X_WB[:3, :3].T + self.X_WB[:3, 3]

    @property
    def is_floor(self) -> bool:
        """Whether it is wide and thin, and lies."""
        size = np.ptp(self.corners, axis=0)
        return bool(size[2] < _THIN and size[:2].min() > _WIDE)

    def hides(self, points: Array, camera: Array) -> np.ndarray[Any, np.dtype[np.bool_]]:
        """Return which points, shape (n, 3), are behind it, by its slabs (Kay and Kajiya, 1986)."""
        start = (points - self.X_WB[:3, 3]) @ self.X_WB[:3, :3]
        step = (camera - points) @ self.X_WB[:3, :3]
        step = np.where(np.abs(step) < 1e-12, 1e-12, step)
        first, second = (-self.half - start) / step, (self.half - start) / step
        enter = np.minimum(first, second).max(axis=1)
        leave = np.maximum(first, second).min(axis=1)
        return (enter <= leave) & (leave >= 0) & (enter <= 1)


def seen_boxes(bodies: Sequence[Mapping[str, Any]]) -> list[SeenBox]:
    """Return the fixed boxes of a scene, by the API's geometry."""
    return [
        SeenBox(_matrix(body["pose"]) @ _matrix(shape["pose"]), np.array(shape["box"]) / 2)
        for body in bodies
        if body["pose"] is not None
        for shape in body["shapes"]
        if shape["box"] is not None
    ]


def place_camera(robots: Array, boxes: Sequence[SeenBox]) -> tuple[Array, Array]:
    """Return the camera's position and what it looks at, p_WC and p_WT.

    Args:
        robots: Origins of the robots' bodies and of frames, in world [m], shape (n, 3), n >= 1.
        boxes: That may hide them.
    """
    middle = robots.mean(axis=0)
    standing = [
        box for box in boxes if not box.is_floor and np.linalg.norm(box.X_WB[:3, 3] - middle) < _FAR
    ]
    points = np.concatenate([robots - _AROUND, robots + _AROUND, *[b.corners for b in standing]])
    lower, upper = points.min(axis=0), points.max(axis=0)
    target, size = (lower + upper) / 2, float(np.linalg.norm(upper - lower))
    around = [
        np.array([np.cos(a) * np.cos(_ELEVATION), np.sin(a) * np.cos(_ELEVATION), 0.0])
        for a in _AZIMUTHS
    ]
    up = np.array([0.0, 0.0, np.sin(_ELEVATION)])
    cameras = [target + _DISTANCE_PER_SIZE * size * (away + up) for away in around]
    hidden = [sum(int(box.hides(robots, c).sum()) for box in standing) for c in cameras]
    best = int(np.argmin(hidden))  # the first of equals
    right = np.cross([0.0, 0.0, 1.0], around[best])
    shift = _SHIFT * size * right / np.linalg.norm(right)
    return cameras[best] + shift, target + shift


def _matrix(pose: Mapping[str, Any]) -> Array:
    found = trimesh.transformations.quaternion_matrix(pose["quaternion"])
    found[:3, 3] = pose["position"]
    return found
