"""DistanceBuffers: distances beyond the margins that the optimizer keeps, by pair of bodies."""

from collections.abc import Collection
from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float64

from planning.domain.value import Value
from planning.world.collision.margins import PairMargins
from planning.world.kernel.kernel_scene import kernel_scene_of
from planning.world.world import World

# Buffer with which a curve is easily proven free between its samples [m].
_BUFFER = 0.003
# Buffer of bodies of one robot, which are near one another by design [m].
_BUFFER_WITHIN_ROBOT = 0.0005
# More than what the probe's distances may be too short by [m].
_DISTANCE_TOLERANCE = 1e-3
# Share of the buffer that the audit requires of the optimized curve.
_AUDIT_FRACTION = 1 / 3


@runtime_checkable
class PairThresholds(Protocol):
    """Required distances of pairs of bodies."""

    def threshold(self, body_a: str, body_b: str) -> float:
        """Return the required distance between two bodies [m]."""
        ...

    @property
    def override_pairs(self) -> Collection[tuple[str, str]]:
        """Pairs, by full names in sorted order, that may have a required distance of their own.

        All other pairs of one robot share one distance, and all remaining pairs another.
        """
        ...


@dataclass(frozen=True, eq=False)
class DistanceBuffers(Value):
    """Distances beyond the margins, by pair of bodies.

    The optimizer can satisfy a bound only where the start and the goal, which are fixed, satisfy it
    too. So the buffer of a pair is at most half of its signed margin at either end.

    Attributes:
        margins: Required margins.
        signed_margins: Signed margins of the nearest pairs at the start or the goal, whichever is
            less [m]; the key is the two full names in sorted order.
    """

    margins: PairMargins
    signed_margins: dict[tuple[str, str], float] = field(default_factory=dict)

    @classmethod
    def from_ends(
        cls, world: World, margins: PairMargins, ends: Float64[np.ndarray, "m num_positions"]
    ) -> "DistanceBuffers":
        """Return the buffers for full configurations of the start and the goal."""
        distance = margins.largest + 2 * _BUFFER
        scene = kernel_scene_of(world.drake)
        if scene is not None:
            reach = distance + _DISTANCE_TOLERANCE
            ends = ends[[scene.has_near_pair(configuration, reach) for configuration in ends]]
        if not len(ends):
            return cls(margins)
        probe = world.distance_probe(margins)
        signed_margins: dict[tuple[str, str], float] = {}
        for configuration in ends:
            for pair in probe.pairs_within(configuration, distance):
                signed_margin = pair.distance - margins.of(*pair.bodies)
                signed_margins[pair.bodies] = min(
                    signed_margin, signed_margins.get(pair.bodies, np.inf)
                )
        return cls(margins, signed_margins)

    @property
    def override_pairs(self) -> Collection[tuple[str, str]]:
        """Pairs with margins of their own, and those that are near at an end."""
        return self.signed_margins.keys() | self.margins.by_pair.keys()

    def threshold(self, body_a: str, body_b: str) -> float:
        """Return the required distance between two bodies: margin plus buffer [m]."""
        low, high = sorted((body_a, body_b))
        margin = self.margins.of(low, high)
        signed_margin = self.signed_margins.get((low, high), np.inf)
        if self.margins.are_of_one_robot(low, high):
            # Links that almost touch may do so in any configuration. The optimizer would fail at
            # them; the audit checks them all the same.
            buffer = _BUFFER_WITHIN_ROBOT
            return margin + (buffer if signed_margin > 2 * buffer else signed_margin - 2 * buffer)
        return margin + min(_BUFFER, signed_margin / 2)

    @property
    def audit_margins(self) -> PairMargins:
        """Margins that the audit requires at every sample of a curve."""
        end_pairs = {
            pair: self.margins.of(*pair) + _AUDIT_FRACTION * min(_BUFFER, signed_margin / 2)
            for pair, signed_margin in self.signed_margins.items()
            if not self.margins.are_of_one_robot(*pair)
        }
        override_margins = {
            pair: margin
            + (0.0 if self.margins.are_of_one_robot(*pair) else _AUDIT_FRACTION * _BUFFER)
            for pair, margin in self.margins.by_pair.items()
        }
        default = self.margins.default + _AUDIT_FRACTION * _BUFFER
        return PairMargins(default, {**override_margins, **end_pairs}, self.margins.owners)
