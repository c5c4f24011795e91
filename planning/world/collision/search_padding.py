"""Search padding: clearance beyond the margin that a search keeps, where start and goal can."""

import numpy as np
from jaxtyping import Float64

from planning.domain.robot.joints import JointGroup
from planning.world.world import World

# A path with this clearance beyond its margins is proven in a few distance queries [m].
SEARCH_PADDING = 0.001


def endpoint_padding(
    world: World,
    group: JointGroup,
    start: Float64[np.ndarray, " nq"],
    goals: Float64[np.ndarray, "n nq"],
    margin: float | None,
) -> float:
    """Return a padding that the start and at least one goal can keep [m]; 0 if there is none."""
    for padding in (SEARCH_PADDING, SEARCH_PADDING / 4):
        oracle = world.collision_oracle(group, world.margins(margin, padding))
        if oracle.is_free(start) and bool(oracle.are_free(goals).any()):
            return padding
    return 0.0
