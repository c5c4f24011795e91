"""Curves with a continuous second derivative, as the refiner makes them."""

import numpy as np
from toppra.interpolator import SplineInterpolator

from planning.domain.curves.curve import JointSpline
from planning.domain.robot.joints import JointType
from tests.conftest import group_of, random_waypoints

SEVEN = group_of(*[JointType.REVOLUTE] * 7)


def smooth_spline(seed: int) -> tuple[JointSpline, SplineInterpolator]:
    """Return the same natural cubic spline twice: as ours, and as toppra's."""
    waypoints = random_waypoints(SEVEN, seed, 7, spread=0.5)
    knots = np.linspace(0, 1, 7)
    theirs = SplineInterpolator(knots, waypoints, bc_type="natural")
    lefts = knots[:-1]
    terms = [np.zeros_like(waypoints[:-1]), theirs(lefts, 1), theirs(lefts, 2) / 2]
    slopes = np.diff(theirs(knots, 2), axis=0) / np.diff(knots)[:, None]
    coefficients = np.stack([*terms, slopes / 6], axis=1)
    return JointSpline(SEVEN.joints, knots, theirs(lefts), coefficients), theirs
