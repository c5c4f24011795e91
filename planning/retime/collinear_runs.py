"""Collinear runs: removal of waypoints in the middle of straight lines of a path.

However finely a path was cut, it is then the same path for every retimer.
"""

import numpy as np

from planning.domain.arrays import Array
from planning.domain.robot.manifold import Manifold

# Rounding error of a waypoint's distance from the line that it lies on (joint-space length).
COLLINEAR_TOLERANCE = 1e-9


def without_collinear_waypoints(waypoints: Array, manifold: Manifold, tolerance: float) -> Array:
    """Return the corners of a path, and both its ends (Ramer-Douglas-Peucker).

    Args:
        waypoints: Joined by geodesics, shape (n, nq).
        manifold: Joint manifold of the waypoints.
        tolerance: Largest distance of a removed waypoint from the remaining line (joint-space
            length).
    """
    if len(waypoints) < 3:
        return waypoints
    before, here, after = waypoints[:-2], waypoints[1:-1], waypoints[2:]
    # Within a run all three waypoints are within `tolerance` of the line, so the middle one is
    # within twice that of its neighbours' chord; others, and reversals, are corners.
    distances = _distances_from_chord(manifold.minus(here, before), manifold.minus(after, before))
    corners = np.flatnonzero(distances > 2 * tolerance) + 1
    if len(corners) == len(here):
        return waypoints
    kept = {0, len(waypoints) - 1, *corners.tolist()}
    runs = [*zip(sorted(kept)[:-1], sorted(kept)[1:], strict=True)]
    while runs:
        begin, end = runs.pop()
        if end - begin < 2:
            continue
        inside = manifold.minus(waypoints[begin + 1 : end], waypoints[begin])
        distances_from_chord = _distances_from_chord(
            inside, manifold.minus(waypoints[end], waypoints[begin])
        )
        if distances_from_chord.max() > tolerance:
            # Ramer-Douglas-Peucker: the farthest waypoint is a corner, both its sides are runs.
            farthest = begin + 1 + int(np.argmax(distances_from_chord))
            kept.add(farthest)
            runs += [(begin, farthest), (farthest, end)]
    return waypoints[sorted(kept)]


def _distances_from_chord(points: Array, chords: Array) -> Array:
    """Return distances of points from the line between 0 and the end of a chord."""
    squares = np.maximum((chords**2).sum(axis=-1), 1e-300)
    along = ((points * chords).sum(axis=-1) / squares).clip(0.0, 1.0)
    return np.asarray(np.sqrt(((points - along[..., None] * chords) ** 2).sum(axis=-1)))
