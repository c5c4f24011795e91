"""ClearanceCost: cost of clearance below a target distance, traded against duration.

minimize  T + weight * mean over the curve of max(0, distance - clearance)

where clearance is that of the nearest pair of bodies, not both of one robot, at each instant.
"""

from dataclasses import dataclass, replace

import numpy as np

from planning.domain.arrays import Array
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.request.options import ClearanceObjective, RefineOptions
from planning.domain.robot.joints import JointGroup
from planning.errors import ProblemInvalid
from planning.refine.constraints.distance_query import (
    DistanceQuery,
    DistanceRows,
    make_distance_query,
)
from planning.world.collision.margins import PairMargins
from planning.world.world import World

# Target distance of pairs within one robot: larger in size than any penetration depth, so that
# these pairs, which are near by design, never count [m].
_IGNORED_DISTANCE = -10.0
# Instants at which a motion's clearance is evaluated.
_NUM_SAMPLES = 201


@dataclass(frozen=True)
class _ClearanceThresholds:
    distance: float
    margins: PairMargins

    @property
    def override_pairs(self) -> tuple[tuple[str, str], ...]:
        """No pair is an exception."""
        return ()

    def threshold(self, body_a: str, body_b: str) -> float:
        """Return the target distance between two bodies [m]."""
        return _IGNORED_DISTANCE if self.margins.are_of_one_robot(body_a, body_b) else self.distance


@dataclass(frozen=True)
class ClearanceCost:
    """Clearance objective in one scene.

    Attributes:
        distance_query: Distance query with the target distance as the required one.
        distance: Target distance [m].
        weight: Cost of one metre of shortfall along the whole curve [s/m].
    """

    distance_query: DistanceQuery
    distance: float
    weight: float

    def with_distance_query(self, distance_query: DistanceQuery) -> "ClearanceCost":
        """Return the same objective with distances in other coordinates."""
        return replace(self, distance_query=distance_query)

    def cost(self, distances: DistanceRows, num_samples: int) -> float:
        """Return the cost of shortfalls over a number of instants [s]."""
        return self.weight * self.distance * float(self.shortfalls(distances, num_samples).mean())

    def shortfalls(self, distances: DistanceRows, num_samples: int) -> Array:
        """Return the shortfall at every instant, as a share of the target distance, shape (m,)."""
        shortfalls = np.zeros(num_samples)
        np.maximum.at(
            shortfalls, distances.sample_indices, -distances.signed_margins / self.distance
        )
        return shortfalls

    def mean_shortfall(self, trajectory: TimedTrajectory) -> float:
        """Return the mean shortfall of a motion's clearance over its time [m]."""
        times = np.linspace(0.0, trajectory.duration, _NUM_SAMPLES)
        distances = self.distance_query.within(trajectory.positions(times), 0.0)
        return self.distance * float(self.shortfalls(distances, len(times)).mean())


def validate_clearance_objective(options: RefineOptions) -> None:
    """Check the clearance objective of a request.

    Raises:
        ProblemInvalid: Its distance or weight is not positive and finite, or nothing is refined.
    """
    objective = options.clearance
    if objective is None:
        return
    for name, number in (("distance", objective.distance), ("weight", objective.weight)):
        if not 0 < number < np.inf:
            field = f"refine.clearance.{name}"
            raise ProblemInvalid(f"{field} must be positive and finite", {"field": field})
    if options.method == "none":
        message = "refine.clearance requires refine.method 'trajopt' or 'auto', not 'none'"
        raise ProblemInvalid(message, {"field": "refine.clearance"})


def make_clearance_objective(
    world: World, group: JointGroup, margins: PairMargins, request: ClearanceObjective | None
) -> ClearanceCost | None:
    """Return the clearance objective of a request, or None if there is none."""
    if request is None:
        return None
    thresholds = _ClearanceThresholds(request.distance, margins)
    return ClearanceCost(
        make_distance_query(world, group, thresholds), request.distance, request.weight
    )
