"""Shapes of an attack, written as in scenes: `{"box": [x, y, z]}`, `{"sphere": r}` and so on.

What the judge knows of a shape is its support function, the largest n . x over its points, and the
point where that is. Everything here is from definitions; nothing is from `planning`.
"""

from typing import Any

import numpy as np

from planning.domain.arrays import Array

type Shape = dict[str, Any]

KINDS = ("box", "sphere", "cylinder", "capsule", "ellipsoid", "convex")


def random_shape(rng: np.random.Generator, size: float, kinds: tuple[str, ...] = KINDS) -> Shape:
    """Return a shape whose extent is about `size` [m], sometimes long, sometimes flat."""
    kind = str(rng.choice(kinds))
    extents = size * 10 ** rng.uniform(-0.8, 0.0, size=3)
    match kind:
        case "box":
            return {"box": extents.tolist()}
        case "sphere":
            return {"sphere": float(extents[0] / 2)}
        case "cylinder" | "capsule":
            return {kind: {"radius": float(extents[0] / 4), "length": float(extents[1])}}
        case "ellipsoid":
            return {"ellipsoid": (extents / 2).tolist()}
        case _:
            points = rng.normal(size=(int(rng.integers(5, 14)), 3))
            points /= np.abs(points).max(axis=0)
            return {"convex": {"points": (points * extents / 2).tolist()}}


def points_of(shape: Shape) -> Array | None:
    """Return the corners of what has corners, shape (n, 3), None of what is round."""
    if "convex" in shape:
        return np.array(shape["convex"]["points"], dtype=np.float64)
    if "box" in shape:
        signs = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, -1).T
        return signs * np.array(shape["box"]) / 2
    return None


def support(shape: Shape, n: Array) -> Array:
    """Return the point of a shape that is farthest along n, both in its own frame, shape (3,)."""
    corners = points_of(shape)
    if corners is not None:
        return corners[int(np.argmax(corners @ n))]
    ((kind, size),) = shape.items()
    length = float(np.linalg.norm(n))
    match kind:
        case "sphere":
            return size * n / length
        case "ellipsoid":
            stretched = np.array(size) * n
            return np.array(size) * stretched / np.linalg.norm(stretched)
        case "capsule":
            ball = size["radius"] * n / length
            return ball + np.array([0.0, 0.0, np.copysign(size["length"] / 2, n[2])])
        case "cylinder":
            across = float(np.hypot(n[0], n[1]))
            rim = size["radius"] * n[:2] / across if across > 0 else np.zeros(2)
            return np.array([*rim, np.copysign(size["length"] / 2, n[2])])
        case _:
            message = f"no support function of {kind}"
            raise ValueError(message)


def heights(shape: Shape, normals: Array) -> Array:
    """Return the largest n . x over a shape for every row n, shape (m, 3) to (m,)."""
    corners = points_of(shape)
    if corners is not None:
        return (normals @ corners.T).max(axis=1)
    ((kind, size),) = shape.items()
    lengths = np.linalg.norm(normals, axis=1)
    match kind:
        case "sphere":
            return size * lengths
        case "ellipsoid":
            return np.linalg.norm(normals * np.array(size), axis=1)
        case "capsule":
            return size["radius"] * lengths + size["length"] / 2 * np.abs(normals[:, 2])
        case _:
            across = np.hypot(normals[:, 0], normals[:, 1])
            return size["radius"] * across + size["length"] / 2 * np.abs(normals[:, 2])


def radius_of(shape: Shape) -> float:
    """Return the radius of a ball about the origin of the shape's frame that holds it."""
    corners = points_of(shape)
    if corners is not None:
        return float(np.linalg.norm(corners, axis=1).max())
    ((kind, size),) = shape.items()
    match kind:
        case "sphere":
            return float(size)
        case "ellipsoid":
            return float(max(size))
        case "capsule":
            return float(size["radius"] + size["length"] / 2)
        case "cylinder":
            return float(np.hypot(size["radius"], size["length"] / 2))
        case _:
            return float("inf")


def scaled(shape: Shape, factor: float) -> Shape:
    """Return the shape with all lengths multiplied."""

    def grown(value: Any) -> Any:
        if isinstance(value, dict):
            return {name: grown(part) for name, part in value.items()}
        if isinstance(value, list):
            return [grown(part) for part in value]
        return value * factor

    return grown(shape)


def obj_text(points: Array) -> str:
    """Return a mesh whose vertices are these points; its hull is theirs, whatever its faces."""
    lines = [f"v {float(x)!r} {float(y)!r} {float(z)!r}" for x, y, z in points]
    count = len(points)
    faces = [f"f {i + 1} {(i + 1) % count + 1} {(i + 2) % count + 1}" for i in range(count)]
    return "\n".join(lines + faces) + "\n"


def obj_points(text: str) -> Array:
    """Return the vertices of a mesh in OBJ."""
    rows = [line.split()[1:4] for line in text.splitlines() if line.startswith("v ")]
    return np.array(rows, dtype=np.float64)
