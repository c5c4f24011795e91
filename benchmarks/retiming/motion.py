"""Motion: what every contender answers, to be sampled."""

from collections.abc import Callable
from dataclasses import dataclass

from planning.domain.arrays import Array


@dataclass(frozen=True)
class Motion:
    """A timed motion.

    Attributes:
        duration: [s].
        sample: Positions and their derivatives (0 to 2, with jerk 3) at instants, each (n, nq).
    """

    duration: float
    sample: Callable[[Array], list[Array]]
