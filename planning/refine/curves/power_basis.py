"""Power basis: exact conversion of Drake's B-splines to polynomial pieces."""

from math import factorial

import numpy as np
from pydrake.trajectories import BsplineTrajectory

from planning.domain.curves.curve import JointSpline
from planning.domain.robot.joints import Joint


def joint_spline(joints: tuple[Joint, ...], spline: BsplineTrajectory) -> JointSpline:
    """Return the same curve as a `JointSpline` over s = (t - start) / (end - start).

    Every span of knots is one polynomial; Taylor's formula at its left end gives it:
    r(s) = sum_k r^(k)(s_i) / k! (s - s_i)^k. Exact but for rounding.

    Args:
        joints: Joints that do not float; their coordinates are the rows of the spline.
        spline: On any interval, with one column.
    """
    knots = np.unique(np.array(spline.basis().knots()))
    begin, length = spline.start_time(), spline.end_time() - spline.start_time()
    span_starts: list[float] = knots[:-1].tolist()
    bases = spline.vector_values(span_starts).T
    terms = [np.zeros_like(bases)]
    for k in range(1, spline.basis().order()):
        rate = spline.MakeDerivative(k).vector_values(span_starts).T
        terms.append(rate * (length**k / factorial(k)))
    breaks = (knots - begin) / length
    breaks[0], breaks[-1] = 0.0, 1.0
    return JointSpline(joints, breaks, bases, np.stack(terms, axis=1))
