"""BodyPair: two bodies, their signed distance and nearest points."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class BodyPair(Value):
    """Two bodies with their signed distance and nearest points.

    Attributes:
        bodies: Full names.
        distance: Signed [m]; negative is the depth of penetration.
        points: The nearest points in world, p_WA and p_WB, shape (2, 3) [m].
    """

    bodies: tuple[str, str]
    distance: float
    points: Float64[np.ndarray, "2 3"]
