"""Canvas: shaded triangles with hidden surfaces removed, as a PNG, by numpy alone."""

import struct
import zlib
from dataclasses import dataclass, field

import numpy as np

from planning.domain.arrays import Array

_LIGHT = np.array([0.35, -0.5, 0.8]) / np.linalg.norm([0.35, -0.5, 0.8])
_SHADOW = 0.55  # brightness of what faces away from the light
_FINE = 2  # pixels that are drawn for one that is shown, along each side
_COLORS = 16  # steps of each colour: few of them make small files


@dataclass
class Canvas:
    """Draws in parallel projection.

    Attributes:
        eye: Direction from the middle to the viewer, shape (3,).
        middle: Point in the middle of the picture [m], shape (3,).
        width: Of what is shown [m].
        size: Of the picture [pixels].
    """

    eye: Array
    middle: Array
    width: float
    size: tuple[int, int] = (640, 400)
    _depth: Array = field(init=False)
    _image: Array = field(init=False)

    def __post_init__(self) -> None:
        """Begin with an empty sheet."""
        columns, rows = (_FINE * side for side in self.size)
        self._depth = np.full((rows, columns), -np.inf)
        self._image = np.ones((rows, columns, 3))
        forward = self.eye / np.linalg.norm(self.eye)
        up = np.array([0.0, 0.0, 1.0]) if abs(forward[2]) < 0.999 else np.array([0.0, 1.0, 0.0])
        right = np.cross(up, forward)
        right /= np.linalg.norm(right)
        self._axes = np.stack([right, np.cross(forward, right), forward])

    def draw(self, triangles: Array, color: Array) -> None:
        """Draw triangles in world, shape (n, 3, 3), in an RGB colour."""
        normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
        bright = _SHADOW + (1 - _SHADOW) * np.clip(normals @ _LIGHT, 0, 1)
        for corners, shade in zip(self._seen(triangles), bright, strict=True):
            self._fill(corners, np.clip(shade * color, 0, 1))

    def dot(self, points: Array, color: Array, radius: int = 2) -> None:
        """Draw points in world, shape (n, 3), as small squares that lie on what is behind them."""
        for x, y, z in self._seen(points):
            rows = slice(max(round(y) - radius, 0), round(y) + radius + 1)
            columns = slice(max(round(x) - radius, 0), round(x) + radius + 1)
            behind = self._depth[rows, columns] < z
            self._image[rows, columns][behind] = color

    def png(self) -> bytes:
        """Return the picture."""
        columns, rows = self.size
        blocks = self._image.reshape(rows, _FINE, columns, _FINE, 3).mean(axis=(1, 3))
        steps = np.round(blocks * (_COLORS - 1)) * (255 // (_COLORS - 1))
        pixels = steps.astype(np.uint8).reshape(rows, -1)
        raw = b"".join(b"\0" + row.tobytes() for row in pixels)
        header = struct.pack(">IIBBBBB", columns, rows, 8, 2, 0, 0, 0)
        parts = ((b"IHDR", header), (b"IDAT", zlib.compress(raw, 9)), (b"IEND", b""))
        return b"\x89PNG\r\n\x1a\n" + b"".join(
            struct.pack(">I", len(content))
            + kind
            + content
            + struct.pack(">I", zlib.crc32(kind + content))
            for kind, content in parts
        )

    def _seen(self, points: Array) -> Array:
        """Return pixel coordinates (column, row) and nearness, same shape."""
        columns, rows = (_FINE * side for side in self.size)
        scale = columns / self.width
        x, y, z = np.moveaxis((points - self.middle) @ self._axes.T, -1, 0)
        return np.stack([columns / 2 + scale * x, rows / 2 - scale * y, z], axis=-1)

    def _fill(self, corners: Array, color: Array) -> None:
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = corners
        area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
        if area >= 0:  # seen from behind: rows count downwards
            return
        rows, columns = self._depth.shape
        left, right = max(int(min(ax, bx, cx)), 0), min(int(max(ax, bx, cx)) + 2, columns)
        top, bottom = max(int(min(ay, by, cy)), 0), min(int(max(ay, by, cy)) + 2, rows)
        if left >= right or top >= bottom:
            return
        x, y = np.meshgrid(np.arange(left, right), np.arange(top, bottom))
        u = ((x - ax) * (cy - ay) - (cx - ax) * (y - ay)) / area
        v = ((bx - ax) * (y - ay) - (x - ax) * (by - ay)) / area
        depth = az + u * (bz - az) + v * (cz - az)
        held = self._depth[top:bottom, left:right]
        nearer = (u >= 0) & (v >= 0) & (u + v <= 1) & (depth > held)
        held[nearer] = depth[nearer]
        self._image[top:bottom, left:right][nearer] = color
