"""Kernel retimer: a path of lines and parabolas timed by one call of the native kernel.

Cells, toppra's passes, profile, composition and audit are those of `toppra_retimer`, `compose` and
`timed_piece`, number for number; those remain for all other curves and limits.
"""

from planning.domain.curves.curve import JointSpline, TimedTrajectory
from planning.domain.robot.joints import JointLimits
from planning.kernel.native import native
from planning.retime.limit_utilization import LimitUtilization
from planning.retime.limits.timed_piece import TimedPiece

# Largest number of polynomial pieces: more would take longer than from one look at the clock to the
# next.
_MAX_PIECES = 128


def timed_by_kernel(spline: JointSpline, limits: JointLimits) -> list[TimedPiece] | None:
    """Return all smooth pieces of a path timed and audited under velocity and acceleration limits.

    None if the kernel cannot do it, or finds no profile: `toppra_profile` then says why.

    Args:
        spline: The path.
        limits: Joint limits, positive and finite.
    """
    module = native()
    count, terms, size = spline.coefficients.shape
    has_scalar_limits = limits.blocks == tuple((i,) for i in range(size))
    if module is None or not has_scalar_limits or not 2 <= terms <= 3 or count > _MAX_PIECES:
        return None
    parts = module.time_path(
        (spline.breaks, spline.coefficients), limits.velocity, limits.acceleration
    )
    if parts is None:
        return None
    return [
        TimedPiece(
            TimedTrajectory(spline.joints, times, spline.bases[pieces], coefficients),
            [LimitUtilization(*velocity), LimitUtilization(*acceleration)],
            [],
            raw_duration,
        )
        for times, pieces, coefficients, velocity, acceleration, raw_duration in parts
    ]
