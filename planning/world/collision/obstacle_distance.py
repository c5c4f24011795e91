"""Obstacle distance: smallest distance of a robot's bodies from all other bodies."""

from collections.abc import Callable

import numpy as np

from planning.domain.arrays import Array
from planning.domain.robot.joints import JointGroup
from planning.world.world import World

# Upper end of reported distances: farther obstacles count as this far [m].
_MAX_REPORTED_DISTANCE = 0.3


def obstacle_distances(world: World, group: JointGroup) -> Callable[[Array], Array]:
    """Return a function from rows of the group's q to obstacle distances [m], at most 0.3 m.

    Distances are those between bodies of the group's robot and all others; self-collision pairs are
    excluded, and nothing is computed before the function is first called.
    """
    prefix = group.name.split("::")[0] + "::"
    margins = world.margins()
    probe = None

    def measure(qs: Array) -> Array:
        nonlocal probe
        probe = probe or world.distance_probe(margins)
        full = world.embed(group, qs)
        return np.array([
            min(
                (
                    pair.distance
                    for pair in probe.pairs_within(q, _MAX_REPORTED_DISTANCE)
                    if sum(name.startswith(prefix) for name in pair.bodies) == 1
                ),
                default=_MAX_REPORTED_DISTANCE,
            )
            for q in full
        ])

    return measure
