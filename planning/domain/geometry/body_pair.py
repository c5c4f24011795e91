"""BodyPair: two bodies and how far apart they are."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class BodyPair(Value):
    """Two bodies and their signed distance.

    Attributes:
        bodies: Full names.
        distance: Signed [m]; negative is the depth of penetration.
        points: The nearest points in world, p_WA and p_WB, shape (2, 3) [m].
    """

    bodies: tuple[str, str]
    distance: float
    points: Float64[np.ndarray, "2 3"]
