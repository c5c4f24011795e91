"""shade(): surfaces in light and shadow, as a view point shows them."""

from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.world.replay.pictures.rasterize import Hits, rasterize
from planning.world.replay.pictures.surface import Surface
from planning.world.replay.pictures.view_point import NEAREST, ViewPoint

# Parts of the light: from everywhere, more from above, and from the lamp.
_AMBIENT, _SKY, _LAMP = 0.46, 0.16, 0.44
# Where the lamp is, as seen by the camera: left, above, behind.
_TO_LAMP = np.array([-0.45, -0.75, -0.75])
# Pixels of the shadows, and what counts as the same depth [m].
_SHADOW_SIZE, _BIAS = 720, 0.006
# Gloss: how much, and how narrow.
_GLOSS, _NARROW = 0.12, 24
_PAPER = 1.0
# Each pixel is this many by as many.
_SAMPLES = 2
# A jump of depth by this share is an outline.
_OUTLINE, _INK = 0.012, 0.45


def shade(
    surface: Surface, view: ViewPoint, around: Float64[np.ndarray, "n 3"]
) -> Float64[np.ndarray, "h w 3"]:
    """Return a picture on white, red, green and blue, 0 to 1.

    Args:
        surface: All that is there, in world; what is translucent shows what is behind it.
        view: From where.
        around: Points between which shadows fall [m].
    """
    fine = view.enlarged(_SAMPLES)
    opaque = surface.colors[:, 3] >= 1.0
    solid, glass = _only(surface, opaque), _only(surface, ~opaque)
    lamp = fine.turn @ (_TO_LAMP / np.linalg.norm(_TO_LAMP))
    picture, near = _drawn(solid, fine, lamp, _shadow_map(solid, lamp, around))
    if len(glass.corners):
        over, nearer = _drawn(glass, fine, lamp, None)
        share = np.where(nearer > near, _opacity(glass, fine), 0.0)[..., None]
        picture = share * over + (1 - share) * picture
    height, width = view.height, view.width
    return picture.reshape(height, _SAMPLES, width, _SAMPLES, 3).mean(axis=(1, 3)).clip(0.0, 1.0)


def _only(surface: Surface, chosen: Any) -> Surface:
    return Surface(surface.corners[chosen], surface.normals[chosen], surface.colors[chosen])


def _hits(surface: Surface, view: ViewPoint) -> tuple[Hits, Any]:
    """Return what pixels show of the triangles that lie ahead, and which those are."""
    seen = view.seen(surface.corners)
    ahead = np.flatnonzero((seen[..., 2] > NEAREST).all(axis=1))
    chosen = seen[ahead]
    size = (view.width, view.height)
    pixels = view.on_picture(chosen)
    return rasterize(pixels, 1 / chosen[..., 2], size, is_perspective=True), ahead


def _opacity(surface: Surface, view: ViewPoint) -> Array:
    hits, ahead = _hits(surface, view)
    return np.where(hits.rows >= 0, surface.colors[ahead[hits.rows], 3], 0.0)


def _drawn(
    surface: Surface, view: ViewPoint, lamp: Array, shadows: "_Shadows | None"
) -> tuple[Array, Array]:
    """Return a picture on white, and how near what it shows is."""
    picture = np.full((view.height, view.width, 3), _PAPER)
    if not len(surface.corners):
        return picture, np.full((view.height, view.width), -np.inf)
    hits, ahead = _hits(surface, view)
    y, x = np.nonzero(hits.rows >= 0)
    rows, weights = ahead[hits.rows[y, x]], hits.weights[y, x]
    points = np.einsum("ij,ijk->ik", weights, surface.corners[rows])
    normals = np.einsum("ij,ijk->ik", weights, surface.normals[rows])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True).clip(1e-9)
    to_eye = view.position - points
    to_eye /= np.linalg.norm(to_eye, axis=1, keepdims=True)
    # Meshes of strangers have faces that look inwards.
    normals *= np.where(np.einsum("ij,ij->i", normals, to_eye) < 0, -1.0, 1.0)[:, None]
    lit = (normals @ lamp).clip(0.0)
    if shadows is not None:
        lit = lit * shadows.light(points, normals)
    half = to_eye + lamp
    half /= np.linalg.norm(half, axis=1, keepdims=True).clip(1e-9)
    gloss = _GLOSS * np.einsum("ij,ij->i", normals, half).clip(0.0) ** _NARROW * (lit > 0)
    light = _AMBIENT + _SKY * normals[:, 2] + _LAMP * lit
    picture[y, x] = surface.colors[rows, :3] * light[:, None] + gloss[:, None]
    return picture * (1 - _INK * _outlines(hits.inverse_depth))[..., None], hits.inverse_depth


def _outlines(inverse_depth: Array) -> Array:
    """Return where depth jumps: 1 on the nearer side."""
    near = np.where(np.isfinite(inverse_depth), inverse_depth, 0.0)
    found = np.zeros(near.shape)
    for one, other in ((np.s_[1:], np.s_[:-1]), (np.s_[:-1], np.s_[1:])):
        down = near[one] > (1 + _OUTLINE) * near[other]
        found[one] = np.maximum(found[one], down)
        across = near[:, one] > (1 + _OUTLINE) * near[:, other]
        found[:, one] = np.maximum(found[:, one], across)
    return found


class _Shadows:
    """What the lamp sees, from far away."""

    def __init__(self, turn: Array, low: Array, scale: float, depth: Array) -> None:
        self._turn, self._low, self._scale, self._depth = turn, low, scale, depth

    def light(self, points: Array, normals: Array) -> Array:
        """Return how much of the lamp reaches points, 0 to 1, softly at the edges."""
        local = (points + _BIAS * normals) @ self._turn
        column, row = ((local[:, :2] - self._low) * self._scale).T
        found = np.zeros(len(points))
        for dy in (-1.2, 0.0, 1.2):
            for dx in (-1.2, 0.0, 1.2):
                x = (column + dx).astype(int).clip(0, _SHADOW_SIZE - 1)
                y = (row + dy).astype(int).clip(0, _SHADOW_SIZE - 1)
                found += local[:, 2] + _BIAS >= self._depth[y, x]
        return found / 9


def _shadow_map(surface: Surface, lamp: Array, around: Array) -> _Shadows:
    """Look from the lamp: x and y across, z towards it."""
    across = np.cross([0.0, 0.0, 1.0] if abs(lamp[2]) < 0.99 else [1.0, 0.0, 0.0], lamp)
    across /= np.linalg.norm(across)
    turn = np.stack([across, np.cross(lamp, across), lamp], axis=1)
    shown = around @ turn
    low, high = shown[:, :2].min(axis=0), shown[:, :2].max(axis=0)
    margin = 0.25 * float((high - low).max()) + 0.05
    low = low - margin
    scale = _SHADOW_SIZE / float((high + margin - low).max())
    local = surface.corners @ turn
    pixels = (local[..., :2] - low) * scale
    size = (_SHADOW_SIZE, _SHADOW_SIZE)
    hits = rasterize(pixels, local[..., 2], size, is_perspective=False)
    return _Shadows(turn, low, scale, hits.inverse_depth)
