r"""servo_deviation(): how far servoed joints may be from the path that was certified.

The controller is sent q(t_k) every h seconds. Between two samples it interpolates, which is off by
at most a h^2 / 8 of a motion with |q''| <= a (de Boor, A Practical Guide to Splines, 2001, II).
Then it smooths over a window of length T: with weights w >= 0 of mean delay d,

    |\int w(s) q(t - s) ds - q(t - d)| <= a / 2 \int w(s) (s - d)^2 ds <= a T^2 / 8,

as no distribution on an interval of length T has a larger variance than T^2 / 4. So every joint is
within a (h^2 + T^2) / 8 of where it was d seconds before on the path.
"""

import numpy as np
from jaxtyping import Float64

from planning.domain.robot.joints import JointLimits
from planning.execute.ur.servo_program import ServoOptions


def servo_deviation(limits: JointLimits, options: ServoOptions) -> Float64[np.ndarray, " nv"]:
    """Return a bound on every joint's distance from the path [rad], shape (nv,).

    It holds for every speed and every command, which keep the acceleration limits. Assumed, as the
    controller's maker does not publish it: `servoj` smooths over `lookahead` at most, with weights
    that are not negative. Not included: the tracking error of the joints' own controllers.

    Args:
        limits: Limits of the group, each block a single joint.
        options: How the controller follows.
    """
    return limits.acceleration * (options.period**2 + options.lookahead**2) / 8
