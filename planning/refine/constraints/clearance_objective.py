"""ClearanceObjective: cost of clearance below a target distance, traded against duration.

minimise  T + weight * mean over the curve of max(0, distance - clearance)

where clearance is that of the nearest pair of bodies, not both of one robot, at each instant.
"""

from dataclasses import dataclass, replace

import numpy as np

from planning.domain.arrays import Array
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.request.options import ClearanceWish, RefineOptions
from planning.domain.robot.joints import JointGroup
from planning.errors import ProblemInvalid
from planning.refine.constraints.distance_query import DistanceQuery, DistanceRows, nearness_of
from planning.world.collision.margins import PairMargins
from planning.world.world import World

# Target distance of pairs within one robot: larger in size than any penetration depth, so that
# these pairs, which are near by design, never count [m].
_UNWISHED = -10.0
# Instants at which a motion's clearance is evaluated.
_NUM_SAMPLES = 201


@dataclass(frozen=True)
class _Wished:
    distance: float
    margins: PairMargins

    @property
    def exceptions(self) -> tuple[tuple[str, str], ...]:
        """No pair is an exception."""
        return ()

    def demanded(self, body_a: str, body_b: str) -> float:
        """Return the target distance between two bodies [m]."""
        return _UNWISHED if self.margins.are_of_one_robot(body_a, body_b) else self.distance


@dataclass(frozen=True)
class ClearanceObjective:
    """Clearance objective in one scene.

    Attributes:
        nearness: Distance query with the target distance as the required one.
        distance: Target distance [m].
        weight: Cost of a metre less all along the curve [s/m].
    """

    nearness: DistanceQuery
    distance: float
    weight: float

    def along(self, nearness: DistanceQuery) -> "ClearanceObjective":
        """Return the same objective with distances in other coordinates."""
        return replace(self, nearness=nearness)

    def cost(self, near: DistanceRows, num_instants: int) -> float:
        """Return the cost of shortfalls over a number of instants [s]."""
        return self.weight * self.distance * float(self.lacks(near, num_instants).mean())

    def lacks(self, near: DistanceRows, num_instants: int) -> Array:
        """Return the shortfall at every instant, as a share of the target distance, shape (m,)."""
        lacks = np.zeros(num_instants)
        np.maximum.at(lacks, near.at, -near.spare / self.distance)
        return lacks

    def shortfall(self, trajectory: TimedTrajectory) -> float:
        """Return the mean shortfall of a motion's clearance over its time [m]."""
        times = np.linspace(0.0, trajectory.duration, _NUM_SAMPLES)
        near = self.nearness.within(trajectory.positions(times), 0.0)
        return self.distance * float(self.lacks(near, len(times)).mean())


def require_wish(options: RefineOptions) -> None:
    """Check the clearance objective of a request.

    Raises:
        ProblemInvalid: Its distance or weight is not positive and finite, or nothing is refined.
    """
    wish = options.clearance
    if wish is None:
        return
    for name, number in (("distance", wish.distance), ("weight", wish.weight)):
        if not 0 < number < np.inf:
            field = f"refine.clearance.{name}"
            raise ProblemInvalid(f"{field} must be positive and finite", {"field": field})
    if options.method == "none":
        message = "refine.clearance is wished of an optimiser: method trajopt or auto"
        raise ProblemInvalid(message, {"field": "refine.clearance"})


def clearance_objective(
    world: World, group: JointGroup, margins: PairMargins, asked: ClearanceWish | None
) -> ClearanceObjective | None:
    """Return the clearance objective of a request, or None if there is none."""
    if asked is None:
        return None
    wished = _Wished(asked.distance, margins)
    return ClearanceObjective(nearness_of(world, group, wished), asked.distance, asked.weight)
