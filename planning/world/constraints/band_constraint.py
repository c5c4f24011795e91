"""BandConstraint: the smallest distance between two sets of bodies stays within two bounds.

All pairs are farther apart than `min` if none is near at that distance; one is no farther apart
than `max` if any is near at that. Configurations in collision are undefined here: the collision
checker rejects them.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float64

from planning.domain.curves.motion_samples import is_motion_free
from planning.domain.robot.joints import JointGroup
from planning.domain.robot.manifold import Manifold
from planning.world.constraints.compiled_constraint import MIN_STEP, ConstraintValue, suggested_step
from planning.world.constraints.pair_proximity import PairProximity
from planning.world.world import World

# Preferred margin: this share of the band, and no more than this [m].
_MARGIN_FRACTION, _MAX_MARGIN = 0.1, 2e-3
# Largest distance that is measured, beyond `max` [m].
_MEASURED_BEYOND = 1.0
_NUM_BISECTIONS = 18


@dataclass(frozen=True)
class BandConstraint:
    """Constraint on the smallest distance of some pairs of bodies.

    Attributes:
        label: For messages.
        world: The scene.
        group: Group of the configurations.
        pairs: Full names, sorted within each pair.
        min: Smallest distance [m].
        max: Largest distance [m], maybe infinite.
        margin: Margin at both bounds in addition to the constraint [m].
    """

    label: str
    world: World
    group: JointGroup
    pairs: frozenset[tuple[str, str]]
    min: float
    max: float
    margin: float = 0.0

    @property
    def preferred_margin(self) -> float:
        """Preferred margin of a search [m]."""
        return min(_MARGIN_FRACTION * (self.max - self.min), _MAX_MARGIN)

    @property
    def step(self) -> float:
        """Largest distance between samples of an edge [rad or m]."""
        return suggested_step(self.margin) if np.isfinite(self.max) else 4 * MIN_STEP

    def tightened(self, margin: float) -> "BandConstraint":
        """Return the constraint tightened by a margin [m]."""
        return replace(self, margin=margin)

    def value(self, q: Float64[np.ndarray, " nq"]) -> ConstraintValue:
        """Return the smallest distance [m] within a metre beyond the band, by bisection.

        Drake's own distances are not used (docs/decisions/0006): they may be too large.
        """
        low, high = 0.0, (self.max if np.isfinite(self.max) else self.min) + _MEASURED_BEYOND
        for _ in range(_NUM_BISECTIONS):
            middle = (low + high) / 2
            proximity = PairProximity(self.world, self.group, self.pairs, middle)
            low, high = (low, middle) if proximity.are_near(q[None])[0] else (middle, high)
        return ConstraintValue(high, self.min if high < self.max else self.max, "m")

    def are_satisfied(self, qs: Float64[np.ndarray, "m nq"]) -> Bool[np.ndarray, " m"]:
        """Return whether each row that does not collide is within the band with its margin."""
        is_satisfied = ~self._min_proximity.are_near(qs)
        if np.isfinite(self.max) and is_satisfied.any():
            is_satisfied[is_satisfied] = self._max_proximity.are_near(qs[is_satisfied])
        return is_satisfied

    def is_motion_satisfied(
        self,
        origin: Float64[np.ndarray, " nq"],
        displacement: Float64[np.ndarray, " nv"],
        resolution: float,
    ) -> bool:
        """Return whether `are_satisfied` holds at every sample of a motion; in fewer calls."""
        if not self._min_proximity.is_motion_clear(origin, displacement, resolution):
            return False
        if not np.isfinite(self.max):
            return True
        motion = origin, displacement
        return is_motion_free(
            Manifold(self.group.joints), self._max_proximity.are_near, motion, resolution
        )

    @cached_property
    def _min_proximity(self) -> PairProximity:
        return PairProximity(self.world, self.group, self.pairs, self.min + self.margin)

    @cached_property
    def _max_proximity(self) -> PairProximity:
        return PairProximity(self.world, self.group, self.pairs, self.max - self.margin)
