"""ViewPoint: a camera that has some points in its picture, and no room to spare."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.value import Value

# Height of the picture over its distance: a long lens, which keeps right angles.
_TANGENT = 2 * np.tan(np.deg2rad(28.0) / 2)
# Share of the picture that the points fill, and rounds until they do.
_FILLED, _ROUNDS = 0.88, 8
# Nothing nearer than this is drawn [m].
NEAREST = 0.02


@dataclass(frozen=True, eq=False)
class ViewPoint(Value):
    """A camera C: x to the right, y down, z ahead.

    Attributes:
        position: p_WC [m], shape (3,).
        turn: R_WC, shape (3, 3).
        width: Of the picture [pixel].
        height: Of the picture [pixel].
    """

    position: Float64[np.ndarray, "3"]
    turn: Float64[np.ndarray, "3 3"]
    width: int
    height: int

    @property
    def focal(self) -> float:
        """Focal length [pixel]."""
        return self.height / _TANGENT

    def seen(self, points: Float64[np.ndarray, "... 3"]) -> Float64[np.ndarray, "... 3"]:
        """Return p_CP of points in world [m]."""
        return (points - self.position) @ self.turn

    def on_picture(self, seen: Float64[np.ndarray, "... 3"]) -> Float64[np.ndarray, "... 2"]:
        """Return pixels of points in the camera's frame that lie ahead."""
        middle = np.array([self.width, self.height]) / 2
        return middle + self.focal * seen[..., :2] / seen[..., 2:]

    def enlarged(self, factor: int) -> "ViewPoint":
        """Return the same view with more pixels."""
        return ViewPoint(self.position, self.turn, factor * self.width, factor * self.height)


def view_of(
    points: Float64[np.ndarray, "n 3"], direction: Float64[np.ndarray, "3"], width: int, height: int
) -> ViewPoint:
    """Return the view that shows points as large as can be.

    Args:
        points: In world [m].
        direction: From the points to the camera.
        width: Of the picture [pixel].
        height: Of the picture [pixel].
    """
    ahead = -direction / np.linalg.norm(direction)
    right = np.cross(ahead, [0.0, 0.0, 1.0])
    if np.linalg.norm(right) < 1e-6:
        right = np.array([1.0, 0.0, 0.0])
    right = right / np.linalg.norm(right)
    turn = np.stack([right, np.cross(ahead, right), ahead], axis=1)
    target = (points.min(axis=0) + points.max(axis=0)) / 2
    distance = max(float(np.linalg.norm(np.ptp(points, axis=0))), 0.1) / _TANGENT
    for _ in range(_ROUNDS):
        view = ViewPoint(target - distance * ahead, turn, width, height)
        low, high = _extent(view, points)
        size = np.array([width, height])
        scale = float(((high - low) / size).max()) / _FILLED
        shift = ((low + high) / 2 - size / 2) * distance / view.focal
        target = target + turn[:, :2] @ shift
        distance *= scale
    return ViewPoint(target - distance * ahead, turn, width, height)


def _extent(view: ViewPoint, points: Array) -> tuple[Array, Array]:
    seen = view.seen(points)
    seen[:, 2] = seen[:, 2].clip(NEAREST)
    pixels = view.on_picture(seen)
    return pixels.min(axis=0), pixels.max(axis=0)
