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

    Distances are those between bodies of the group's robots and all others, the group's other
    robots included; self-collision pairs are excluded, and nothing is computed before the function
    is first called.
    """
    probe, own = None, set[str]()

    def measure(qs: Array) -> Array:
        nonlocal probe
        if probe is None:
            own.update(joint.name.partition("::")[0] for joint in group.joints)
            probe = world.distance_probe(world.margins())
        full = world.embed(group, qs)
        return np.array([
            min(
                (
                    pair.distance
                    for pair in probe.pairs_within(q, _MAX_REPORTED_DISTANCE)
                    if _concerns(own, *(name.partition("::") for name in pair.bodies))
                ),
                default=_MAX_REPORTED_DISTANCE,
            )
            for q in full
        ])

    return measure


def _concerns(own: set[str], a: tuple[str, str, str], b: tuple[str, str, str]) -> bool:
    """Return whether of two bodies, split at `::`, one is of these robots and they are of two."""
    robot_a, robot_b = (part[0] if part[1] else None for part in (a, b))
    return robot_a != robot_b and not own.isdisjoint((robot_a, robot_b))
