"""Uniform samples of a search space, independent of OMPL and its global random numbers."""

import numpy as np
from jaxtyping import Float64

from planning.domain.robot.joints import JointGroup, JointType
from planning.search.ompl.spaces import SearchSpace


def uniform_samples(
    group: JointGroup, space: SearchSpace, count: int, rng: np.random.Generator
) -> Float64[np.ndarray, "count nq"]:
    """Return uniform configurations in the space's bounds; full circles, rotations by Haar measure.

    Held coordinates of the space have their start values.
    """
    lower = np.where(np.isfinite(space.lower), space.lower, -np.pi)
    upper = np.where(np.isfinite(space.upper), space.upper, np.pi)
    qs = rng.uniform(lower, upper, (count, group.num_positions))
    iq = 0
    for joint in group.joints:
        if joint.type is JointType.FLOATING:
            # The direction of a normal vector is uniform on the sphere.
            qs[:, iq : iq + 4] = rng.normal(size=(count, 4))
        iq += joint.num_positions
    return space.with_held_values(space.manifold.normalized(qs))
