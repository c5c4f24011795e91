"""Gripper: a parallel gripper, by how wide its fingers are open."""

from dataclasses import dataclass

from planning.domain.value import Value
from planning.errors import ProblemInvalid

# Widths beyond the range by less than this are taken to be its end [m]: they were computed.
_TOLERANCE = 1e-9


@dataclass(frozen=True, eq=False)
class Gripper(Value):
    """Parallel gripper: one prismatic joint, and prismatic joints that follow it.

    Its width is how far its fingers are apart. It is 0 where the joint is at its lower limit, and
    grows by `travel` with each metre of the joint: 2 m where two fingers move by the same amount.

    Attributes:
        joint: Full name of the joint that moves the first finger.
        lower: Position of the joint where the fingers meet [m].
        upper: Position where they are furthest apart [m].
        travel: By how much the fingers part with each metre of the joint, at least 1.
    """

    joint: str
    lower: float
    upper: float
    travel: float

    @property
    def max_width(self) -> float:
        """Width of the open gripper [m]."""
        return self.travel * (self.upper - self.lower)

    def width(self, position: float) -> float:
        """Return the width at a position of the joint [m]."""
        return self.travel * (position - self.lower)

    def position(self, width: float) -> float:
        """Return the position of the joint at a width [m].

        Raises:
            ProblemInvalid: The gripper does not open so wide.
        """
        if not -_TOLERANCE <= width <= self.max_width + _TOLERANCE:
            message = f"width: {width:.4g} m is not from 0 to {self.max_width:.4g} m"
            raise ProblemInvalid(message, {"field": "width", "bound": self.max_width})
        return min(self.upper, max(self.lower, self.lower + width / self.travel))
