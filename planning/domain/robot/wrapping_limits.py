"""WrappingLimits: position limits of angles on circles, for which OMPL's spaces have no bounds."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64

from planning.domain.robot.joints import JointGroup, JointLimits

# Rounding of an angle that is brought back by whole turns [rad].
_ROUNDING = 1e-9


@dataclass(frozen=True)
class WrappingLimits:
    """Limits of the coordinates of a group that are angles on a circle and may not turn fully.

    Attributes:
        indices: Of these coordinates in q.
        lower: Their lower limits, shape (k,) [rad].
        widths: Their ranges above these, shape (k,) [rad].
    """

    indices: list[int]
    lower: Float64[np.ndarray, " k"]
    widths: Float64[np.ndarray, " k"]

    @classmethod
    def of(cls, group: JointGroup, limits: JointLimits) -> "WrappingLimits":
        """Return those of a group."""
        if group.has_scalar_joints:
            return _NO_LIMITS
        width = limits.upper - limits.lower
        indices: list[int] = []
        iq = 0
        for joint in group.joints:
            wraps = joint.wraps
            count = joint.num_positions
            if any(wraps):
                indices += [iq + k for k in range(count) if wraps[k] and width[iq + k] < 2 * np.pi]
            iq += count
        return cls(indices, limits.lower[indices], width[indices])

    def are_within(self, qs: Float64[np.ndarray, "m nq"]) -> Bool[np.ndarray, " m"]:
        """Return whether each row keeps the limits, by whichever turn."""
        offsets = np.remainder(qs[:, self.indices] - self.lower, 2 * np.pi)
        return ((offsets <= self.widths + _ROUNDING) | (offsets >= 2 * np.pi - _ROUNDING)).all(
            axis=1
        )


# Of joints that do not wrap.
_NO_LIMITS = WrappingLimits([], np.empty(0), np.empty(0))
