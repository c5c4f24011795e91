"""Hit-and-run sampling of a polytope: random walks with uniform steady state (Smith 1984)."""

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array


def hit_and_run(
    qs: Float64[np.ndarray, "k n"],
    faces: tuple[Float64[np.ndarray, "m n"], Float64[np.ndarray, " m"]],
    shape: Float64[np.ndarray, "n n"],
    num_steps: int,
    generator: np.random.Generator,
) -> Array:
    """Return the points of k hit-and-run walks after some steps, shape (k, n).

    Args:
        qs: Start points, inside the polytope.
        faces: Normals and offsets of a bounded polytope.
        shape: Linear map of the normally distributed step directions.
        num_steps: Number of steps, each to a uniform point on a random chord through the point.
        generator: Random number generator.
    """
    normals, offsets = faces
    qs = np.array(qs)
    for _ in range(num_steps):
        directions = generator.standard_normal(qs.shape) @ shape.T
        speed = directions @ normals.T
        slack = np.maximum(offsets - qs @ normals.T, 0.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            time = slack / speed
        last = np.where(speed > 0, time, np.inf).min(axis=1)
        first = np.where(speed < 0, time, -np.inf).max(axis=1)
        qs += (first + generator.random(len(qs)) * (last - first))[:, None] * directions
    return qs
