"""CarSpace: the search space of a group with a car in it."""

from collections.abc import Callable
from typing import Any, override

import numpy as np
from jaxtyping import Float64

from planning.domain.joints import JointGroup, JointLimits
from planning.search.driven_edges import DrivenEdges
from planning.search.drives import Drives
from planning.search.oracle import WatchedOracle
from planning.search.spaces import SearchSpace

type Array = np.ndarray[Any, np.dtype[np.float64]]


class CarSpace(SearchSpace):
    """A space whose states are joined by drives.

    OMPL grows its trees along Reeds and Shepp's curves, for a car that drives forwards only as
    well: its wheel binds no space of Dubins' curves. That decides only where states are tried; the
    motions between them are ours, and every one is a drive in the direction of the motion.

    Attributes:
        drives: The ways between states.
    """

    def __init__(
        self,
        group: JointGroup,
        limits: JointLimits,
        anchors: Float64[np.ndarray, "m nq"],
        weights: Float64[np.ndarray, " num_blocks"],
    ) -> None:
        """Build the space; the arguments are those of a plain one.

        Raises:
            ProblemInvalid: The group has several cars.
        """
        self.drives = Drives(group)
        super().__init__(group, limits, anchors, weights)

    @override
    def checker(
        self, oracle: WatchedOracle, resolution: float, norm: Callable[[Array], Array]
    ) -> DrivenEdges:
        """Return what checks drives at a resolution."""
        return DrivenEdges(self.drives, oracle, resolution, norm, (self.lower, self.upper))
