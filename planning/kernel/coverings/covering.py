"""Covering: outer spheres that contain a convex shape, and inner spheres inside it."""

import json
import os
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path

import numpy as np
from jaxtyping import Float64

from planning.domain.value import Value, digest
from planning.kernel.coverings.ball_choices import BallChoices
from planning.kernel.coverings.enclosing_ball import enclosing_ball
from planning.kernel.coverings.inner_spheres import inner_spheres
from planning.kernel.coverings.outer_polytope import OuterPolytope
from planning.kernel.coverings.outer_spheres import outer_spheres
from planning.kernel.coverings.solid import Solid
from planning.kernel.shape import ConvexShape, ShapeKind
from planning.parallel.atomic_files import evict_oldest, write_atomically

# Version of this computation: a stored covering of another version is not read.
VERSION = 2
_MAX_BYTES = 2**28


@dataclass(frozen=True, eq=False)
class Covering(Value):
    """Outer and inner spheres of a convex shape, as rows (x, y, z, r) in its frame [m].

    Attributes:
        outer: Their union contains the shape, the largest first, shape (n, 4).
        inner: Each lies inside the shape, in decreasing order of benefit, shape (m, 4); none in a
            shape without thickness.
        bound: One sphere that contains the shape, shape (4,).
        protrusion: Largest distance that the outer spheres reach beyond the shape [m].
    """

    outer: Float64[np.ndarray, "n 4"]
    inner: Float64[np.ndarray, "m 4"]
    bound: Float64[np.ndarray, "4"]
    protrusion: float


def cover(shape: ConvexShape) -> Covering:
    """Return the covering of a shape; the same shape has the same one, bit for bit.

    Raises:
        ModelInvalid: A half space has no covering.
    """
    if shape.kind is ShapeKind.SPHERE:
        ball = np.array([0.0, 0.0, 0.0, shape.size[0]])
        return Covering(ball[None], ball[None], ball, 0.0)
    solid = Solid.of(shape)
    polytope = OuterPolytope.of(solid)
    choices = BallChoices.of(solid, polytope)
    outer, protrusion = outer_spheres(solid, polytope, choices)
    bound = enclosing_ball(polytope.v_representation.corners)
    return Covering(outer, inner_spheres(solid, choices), bound, protrusion)


@lru_cache(maxsize=1024)
def cached_covering(shape: ConvexShape, folder: Path | None) -> Covering:
    """Return the covering of a shape from memory, or else from a folder; None for memory alone.

    Raises:
        ModelInvalid: A half space has no covering.
    """
    return cover(shape) if folder is None else stored_covering(shape, folder)


def stored_covering(
    shape: ConvexShape,
    folder: Path,
    compute: Callable[[ConvexShape], Covering] = cover,
    version: int = VERSION,
) -> Covering:
    """Return the covering of a shape from a folder, computed and stored there if it is missing.

    A file that is damaged or of another shape is computed anew; a folder that cannot be written to
    is no error.

    Args:
        shape: The shape.
        folder: Of files, one for a shape; made if it does not exist.
        compute: Computes a covering.
        version: Of `compute`: files of another one are not read.

    Raises:
        ModelInvalid: A half space has no covering.
    """
    file = folder / f"{digest((shape, version))}.json"
    covering = _read(file)
    with suppress(OSError):
        os.utime(file)
    if covering is None:
        covering = compute(shape)
        _write(file, covering)
    return covering


def _checksum(file: Path, covering: Covering) -> str:
    """Return the checksum of a file's name, which is that of a shape, and of its covering."""
    return digest((file.stem, covering))


def _read(file: Path) -> Covering | None:
    """Return the covering in a file; None if there is none or its content is invalid."""
    try:
        document = json.loads(file.read_text("utf-8"))
        outer, inner, bound = (
            np.array(document[name], dtype=np.float64).reshape(-1, 4)
            for name in ("outer", "inner", "bound")
        )
        covering = Covering(outer, inner, bound.reshape(4), float(document["protrusion"]))
        is_intact = document["seal"] == _checksum(file, covering)
    except (OSError, ValueError, KeyError, TypeError, OverflowError, RecursionError):
        return None
    return covering if is_intact else None


def _write(file: Path, covering: Covering) -> None:
    """Write a covering to its file, if the folder can be written to."""
    document = {
        "outer": covering.outer.tolist(),
        "inner": covering.inner.tolist(),
        "bound": covering.bound.tolist(),
        "protrusion": covering.protrusion,
        "seal": _checksum(file, covering),
    }
    with suppress(OSError):
        write_atomically(file, json.dumps(document))
        _trim(file.parent)


@cache
def _trim(folder: Path) -> None:
    """Remove the least recently used files if the folder is too large: once in a process."""
    evict_oldest(folder, _MAX_BYTES)
