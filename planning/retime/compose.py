"""Composition q(t) = r(s(t)) of a path and a speed profile, exact as polynomials."""

import numpy as np

from planning.domain.arrays import Array
from planning.domain.curves.curve import JointSpline, TimedTrajectory
from planning.kernel.native import native
from planning.retime.profile import SpeedProfile


def compose(spline: JointSpline, profile: SpeedProfile) -> TimedTrajectory:
    """Return the trajectory along the spline with the given speed profile.

    Every phase lies on one piece of the spline, whose polynomial of degree k is expanded about the
    phase's beginning and then composed with s(t), giving degree 3 k (2 k without jerk).
    """
    module = native()
    if module is None or spline.coefficients.shape[1] < 2:
        return compose_in_numpy(spline, profile)
    times, pieces, coefficients = module.compose(
        (spline.breaks, spline.coefficients), profile.s, profile.v, profile.a, profile.j, profile.h
    )
    return TimedTrajectory(spline.joints, times, spline.bases[pieces], coefficients)


def compose_in_numpy(spline: JointSpline, profile: SpeedProfile) -> TimedTrajectory:
    """Return the same without the kernel, which has the same sums."""
    middles = (profile.s[:-1] + profile.s[1:]) / 2
    pieces, _ = spline.locate(middles)
    local = taylor_shifted(spline.coefficients[pieces], profile.s[:-1] - spline.breaks[pieces])
    steps = [profile.v, profile.a / 2] + ([profile.j / 6] if profile.j.any() else [])
    inner = np.stack(steps, axis=1)
    coefficients = _substitute(local, inner)
    times = np.concatenate([[0.0], np.cumsum(profile.h)])
    return TimedTrajectory(spline.joints, times, spline.bases[pieces], coefficients)


def taylor_shifted(coefficients: Array, offsets: Array) -> Array:
    """Return the coefficients of p(x + offset), by repeated synthetic division."""
    coefficients_at_offset = np.array(coefficients)
    last = coefficients_at_offset.shape[1] - 1
    for i in range(last):
        for k in range(last - 1, i - 1, -1):
            coefficients_at_offset[:, k] += offsets[:, None] * coefficients_at_offset[:, k + 1]
    return coefficients_at_offset


def _substitute(outer: Array, inner: Array) -> Array:
    """Return p(x(t)) with x(t) = inner[0] t + inner[1] t^2 + ..., by Horner's rule."""
    n, num_terms, nv = outer.shape
    inner_degree = inner.shape[1]
    total = np.zeros((n, (num_terms - 1) * inner_degree + 1, nv))
    total[:, 0] = outer[:, -1]
    length = 1
    for k in range(num_terms - 2, -1, -1):
        product = np.zeros_like(total)
        for m in range(inner_degree):
            product[:, m + 1 : m + 1 + length] += inner[:, m, None, None] * total[:, :length]
        total = product
        total[:, 0] += outer[:, k]
        length += inner_degree
    return total
