"""End constraint of car paths: nearby segments that end at the goal, by Newton's method."""

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.refine.cars.arc_segments import ArcSegments, end_of
from planning.refine.cars.drive_problem import DriveProblem

# Largest miss of the goal by an end [m and rad].
_MISS = 1e-11
# Largest share of the miss that a correction may leave, and most corrections.
_LEFT, _MOST = 0.7, 10
_AT_BOUND = 1e-12


def variable_bounds(course: DriveProblem, letters: ArcSegments) -> tuple[Array, Array]:
    """Return lower and upper bounds of lengths and curvatures, (2 n,): directions are kept."""
    bend = np.full(len(letters), 1 / course.steering.turning_radius)
    lower = np.where(letters.ways < 0, -np.inf, 0.0)
    upper = np.where(letters.ways > 0, np.inf, 0.0)
    return np.concatenate([lower, -bend]), np.concatenate([upper, bend])


def sides_of(course: DriveProblem, letters: ArcSegments, size: float) -> Float64[np.ndarray, " v"]:
    """Return changes of lengths and curvatures that each move the path by about `size` [m]."""
    radius = course.steering.turning_radius
    bends = size / (radius * np.maximum(np.abs(letters.ways), size))
    return np.concatenate([np.full(len(letters), size), bends])


def ended(course: DriveProblem, letters: ArcSegments, size: float) -> ArcSegments | None:
    """Return nearby segments that end at the goal; None if Newton's method fails.

    Each correction is the least one in units of `sides_of` for the linearized end; variables at a
    bound that they would leave stay there.
    """
    lower, upper = variable_bounds(course, letters)
    before = np.inf
    for _ in range(_MOST):
        end = end_of(course.start, letters)
        miss = course.goal - end.poses[0]
        size_of_miss = float(np.abs(miss).max())
        if size_of_miss < _MISS:
            return letters
        if size_of_miss > _LEFT * before:
            return None
        before = size_of_miss
        values = np.concatenate([letters.ways, letters.bends])
        sides = sides_of(course, letters, size)
        step = _least_step(end.slopes[0] * sides, miss, (values - lower, upper - values), sides)
        letters = letters.with_variables(np.clip(values + step, lower, upper))
    return None


def _least_step(slopes: Array, miss: Array, room: tuple[Array, Array], sides: Array) -> Array:
    """Return the least step that corrects a miss, with variables at their bounds fixed."""
    down, up = room
    free = np.ones(len(sides))
    while True:
        some = slopes * free
        step = some.T @ np.linalg.lstsq(some @ some.T, miss, rcond=1e-12)[0] * sides
        stuck = ((step < 0) & (down <= _AT_BOUND)) | ((step > 0) & (up <= _AT_BOUND))
        if not (stuck & (free > 0)).any():
            return step
        free[stuck] = 0.0
