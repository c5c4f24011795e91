"""CarSpace: OMPL state space of a group with a car in it."""

from collections.abc import Callable
from typing import override

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.robot.joints import JointGroup, JointLimits
from planning.search.cars.steering_edges import SteeringEdgeChecker
from planning.search.cars.steering_paths import SteeringPaths
from planning.search.collision_oracle import WatchedOracle
from planning.search.ompl.spaces import SearchSpace


class CarSpace(SearchSpace):
    """State space whose motions are steering paths.

    OMPL extends its trees along Reeds-Shepp curves, for a car that drives forwards only as well.
    That decides only where states are tried; motions between states are computed here, each a
    steering path in the direction of the motion.

    Attributes:
        steering_paths: Steering function between states.
    """

    def __init__(
        self,
        group: JointGroup,
        limits: JointLimits,
        anchors: Float64[np.ndarray, "m nq"],
        weights: Float64[np.ndarray, " num_blocks"],
    ) -> None:
        """Build the space; the arguments are those of `SearchSpace`.

        Raises:
            ProblemInvalid: The group has several cars.
        """
        self.steering_paths = SteeringPaths(group)
        super().__init__(group, limits, anchors, weights)

    @override
    def checker(
        self, oracle: WatchedOracle, resolution: float, norm: Callable[[Array], Array] | None
    ) -> SteeringEdgeChecker:
        """Return a checker of steering paths at a resolution."""
        return SteeringEdgeChecker(
            self.steering_paths, oracle, resolution, norm, (self.lower, self.upper)
        )
