"""CertifyRequest: a trajectory and everything it shall be held against."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.curve import TimedTrajectory
from planning.domain.joints import JointGroup, JointLimits
from planning.domain.value import Value
from planning.world.margins import PairMargins


@dataclass(frozen=True, eq=False)
class CertifyRequest(Value):
    """What to prove.

    Attributes:
        group: What moves.
        trajectory: The motion.
        state: Where everything else is, full plant positions, shape (num_positions,).
        start: Where the motion shall begin, shape (nq,).
        goals: Configurations one of which it shall reach, shape (n, nq).
        limits: The limits to keep.
        margins: The distances to keep.
        jerk: Whether jerk is limited (and acceleration hence continuous).
    """

    group: JointGroup
    trajectory: TimedTrajectory
    state: Float64[np.ndarray, " num_positions"]
    start: Float64[np.ndarray, " nq"]
    goals: Float64[np.ndarray, "n nq"]
    limits: JointLimits
    margins: PairMargins
    jerk: bool
