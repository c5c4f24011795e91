"""Coverings: a convex shape between spheres around it and spheres inside it."""

import json
import tempfile
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.value import Value, digest
from planning.kernel.inner_spheres import inner_spheres
from planning.kernel.outer_spheres import outer_spheres
from planning.kernel.shape import ConvexShape, ShapeKind
from planning.kernel.solid import Solid

type Array = np.ndarray[Any, np.dtype[np.float64]]

# Of what is computed here: a covering of another version is not read.
_VERSION = 1


@dataclass(frozen=True, eq=False)
class Covering(Value):
    """Spheres as rows (x, y, z, r) in the shape's frame [m].

    Attributes:
        outer: Their union contains the shape, shape (n, 4).
        inner: Each lies inside the shape, shape (m, 4); none in one that is very thin.
        bound: One that contains the shape, shape (4,).
        protrusion: How far the outer ones reach beyond the shape at most [m].
    """

    outer: Float64[np.ndarray, "n 4"]
    inner: Float64[np.ndarray, "m 4"]
    bound: Float64[np.ndarray, "4"]
    protrusion: float


def cover(shape: ConvexShape) -> Covering:
    """Return the covering of a shape; the same shape has the same one, bit for bit.

    Raises:
        ModelInvalid: A half space has none.
    """
    if shape.kind is ShapeKind.SPHERE:
        ball = np.array([0.0, 0.0, 0.0, shape.size[0]])
        return Covering(ball[None], ball[None], ball, 0.0)
    solid = Solid.of(shape)
    outer, protrusion = outer_spheres(solid)
    whole = solid.polytope
    center = (whole.low + whole.high) / 2
    radius = float(np.linalg.norm(whole.corners - center, axis=1).max()) * (1 + 1e-9)
    return Covering(outer, inner_spheres(solid), np.append(center, radius), protrusion)


def cached_covering(shape: ConvexShape, folder: Path) -> Covering:
    """Return the covering of a shape from a folder, made and kept there when it is first asked for.

    A file that is damaged is made anew; a folder that cannot be written to is no fault.

    Raises:
        ModelInvalid: A half space has none.
    """
    return _remembered(shape, folder)


@lru_cache(maxsize=1024)
def _remembered(shape: ConvexShape, folder: Path) -> Covering:
    file = folder / f"{digest((shape, _VERSION))}.json"
    known = _read(file)
    if known is None:
        known = cover(shape)
        _write(file, known)
    return known


def _read(file: Path) -> Covering | None:
    """Return what a file holds; None if there is none or it holds something else."""
    try:
        found = json.loads(file.read_text("utf-8"))
        outer, inner = (
            np.array(found[name], dtype=np.float64).reshape(-1, 4) for name in ("outer", "inner")
        )
        bound, protrusion = np.array(found["bound"], dtype=np.float64), float(found["protrusion"])
        content = Covering(outer, inner, bound.reshape(4), protrusion)
    except (OSError, ValueError, KeyError, TypeError):
        return None
    return content if found.get("digest") == digest(content) else None


def _write(file: Path, content: Covering) -> None:
    """Write a file that other processes see either whole or not at all."""
    document = {
        "outer": content.outer.tolist(),
        "inner": content.inner.tolist(),
        "bound": content.bound.tolist(),
        "protrusion": content.protrusion,
        "digest": digest(content),
    }
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile("w", dir=file.parent, delete=False) as part:
            json.dump(document, part)
        Path(part.name).replace(file)
    except OSError:
        return
