"""ClearanceObjective: clearance beyond what is demanded, as far as it is worth its time.

minimise  T + weight * mean over the way of max(0, distance - clearance)

where clearance is that of the nearest pair of bodies, not both of one robot, at each instant.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from planning.domain.curves.curve import TimedTrajectory
from planning.domain.request.options import ClearanceWish, RefineOptions
from planning.domain.robot.joints import JointGroup
from planning.errors import ProblemInvalid
from planning.refine.constraints.distance_query import DistanceQuery, DistanceRows, nearness_of
from planning.world.collision.margins import PairMargins
from planning.world.world import World

type Array = np.ndarray[Any, np.dtype[np.float64]]

# Nothing is ever this deep in anything: links of one robot are near by design [m].
_UNWISHED = -10.0
# Instants at which a motion is held against the wish.
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
        """Return the distance that is wished for between two bodies [m]."""
        return _UNWISHED if self.margins.are_of_one_robot(body_a, body_b) else self.distance


@dataclass(frozen=True)
class ClearanceObjective:
    """A wish in one scene.

    Attributes:
        nearness: Measures pairs, with the wished distance as what is demanded.
        distance: That is wished for [m].
        weight: What a metre less, all along the way, may cost [s/m].
    """

    nearness: DistanceQuery
    distance: float
    weight: float

    def along(self, nearness: DistanceQuery) -> "ClearanceObjective":
        """Return the same wish, measured in other coordinates."""
        return replace(self, nearness=nearness)

    def cost(self, near: DistanceRows, num_instants: int) -> float:
        """Return what falling short at so many instants costs [s]."""
        return self.weight * self.distance * float(self.lacks(near, num_instants).mean())

    def lacks(self, near: DistanceRows, num_instants: int) -> Array:
        """Return what is lacking at every instant, as a share of the distance, shape (m,)."""
        lacks = np.zeros(num_instants)
        np.maximum.at(lacks, near.at, -near.spare / self.distance)
        return lacks

    def shortfall(self, trajectory: TimedTrajectory) -> float:
        """Return by how much a motion's clearance falls short on average over its time [m]."""
        times = np.linspace(0.0, trajectory.duration, _NUM_SAMPLES)
        near = self.nearness.within(trajectory.positions(times), 0.0)
        return self.distance * float(self.lacks(near, len(times)).mean())


def require_wish(options: RefineOptions) -> None:
    """Go on only if a wish for clearance makes sense.

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
    """Return what is wished for, if anything."""
    if asked is None:
        return None
    wished = _Wished(asked.distance, margins)
    return ClearanceObjective(nearness_of(world, group, wished), asked.distance, asked.weight)
