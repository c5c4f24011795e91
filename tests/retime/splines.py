"""Curves with a continuous second derivative, as the refiner makes them."""

import numpy as np
from toppra.interpolator import SplineInterpolator

from planning.domain.curves.curve import JointSpline
from planning.domain.robot.joints import JointType
from planning.retime.profile import SpeedProfile
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


def slow_profile(stretch: JointSpline, duration: float = 30.0) -> SpeedProfile:
    """Return a profile that is far from all limits: one hop by four phases of constant jerk."""
    h = duration / 4
    j = np.array([1.0, -1.0, -1.0, 1.0]) / (2 * h**3)
    a = np.array([0.0, j[0] * h, 0.0, -j[0] * h])
    v = np.array([0.0, 0.5, 1.0, 0.5]) * j[0] * h**2
    s = np.array([0.0, 1 / 12, 0.5, 11 / 12, 1.0])
    return SpeedProfile(s, v, a, j, np.full(4, h)).split_at(stretch.breaks[1:-1])
