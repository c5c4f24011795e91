"""End constraint of car paths: nearby segments that end at the goal, by Newton's method."""

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.refine.cars.arc_segments import ArcSegments, end_pose
from planning.refine.cars.drive_problem import DriveProblem

# Largest miss of the goal by an end [m and rad].
_GOAL_TOLERANCE = 1e-11
# Largest share of the miss that a correction may leave, and most corrections.
_MAX_REMAINING_RATIO, _MAX_CORRECTIONS = 0.7, 10
# Distance from a bound at which a variable is at it.
_BOUND_TOLERANCE = 1e-12


def variable_bounds(problem: DriveProblem, segments: ArcSegments) -> tuple[Array, Array]:
    """Return lower and upper bounds of lengths and curvatures, (2 n,): directions are kept."""
    max_curvatures = np.full(len(segments), 1 / problem.steering.turning_radius)
    lower = np.where(segments.signed_lengths < 0, -np.inf, 0.0)
    upper = np.where(segments.signed_lengths > 0, np.inf, 0.0)
    return np.concatenate([lower, -max_curvatures]), np.concatenate([upper, max_curvatures])


def trust_region_radii(
    problem: DriveProblem, segments: ArcSegments, radius: float
) -> Float64[np.ndarray, " v"]:
    """Return changes of lengths and curvatures, each for about `turning_radius` of motion [m]."""
    turning_radius = problem.steering.turning_radius
    curvature_radii = radius / (
        turning_radius * np.maximum(np.abs(segments.signed_lengths), radius)
    )
    return np.concatenate([np.full(len(segments), radius), curvature_radii])


def projected_to_goal(
    problem: DriveProblem, segments: ArcSegments, radius: float
) -> ArcSegments | None:
    """Return nearby segments that end at the goal; None if Newton's method fails.

    Each correction is the least one in units of `trust_region_radii` for the linearized end;
    variables at a bound that they would leave stay there.
    """
    lower, upper = variable_bounds(problem, segments)
    last_error = np.inf
    for _ in range(_MAX_CORRECTIONS):
        end = end_pose(problem.start, segments)
        error = problem.goal - end.poses[0]
        error_size = float(np.abs(error).max())
        if error_size < _GOAL_TOLERANCE:
            return segments
        if error_size > _MAX_REMAINING_RATIO * last_error:
            return None
        last_error = error_size
        values = np.concatenate([segments.signed_lengths, segments.curvatures])
        radii = trust_region_radii(problem, segments, radius)
        step = _min_norm_step(
            end.jacobians[0] * radii, error, (values - lower, upper - values), radii
        )
        segments = segments.with_variables(np.clip(values + step, lower, upper))
    return None


def _min_norm_step(
    jacobian: Array, error: Array, margins: tuple[Array, Array], radii: Array
) -> Array:
    """Return the least step that corrects a miss, with variables at their bounds fixed."""
    down, up = margins
    is_free = np.ones(len(radii))
    while True:
        free_jacobian = jacobian * is_free
        step = (
            free_jacobian.T
            @ np.linalg.lstsq(free_jacobian @ free_jacobian.T, error, rcond=1e-12)[0]
            * radii
        )
        is_blocked = ((step < 0) & (down <= _BOUND_TOLERANCE)) | (
            (step > 0) & (up <= _BOUND_TOLERANCE)
        )
        if not (is_blocked & (is_free > 0)).any():
            return step
        is_free[is_blocked] = 0.0
