"""Contacts of robots that are simulated apart from each other, by their measured positions."""

import numpy as np

from planning.world.collision.margins import PairMargins
from planning.world.mechanics.simulation import CONTACT_DEPTH
from service.executions.watching.tasks import TOUCHING, Touches, Touching, TouchWork
from service.jobs.context import TaskContext
from service.scenes.world_cache import borrow_world


@TOUCHING.runs
def touching_robots(work: TouchWork, context: TaskContext) -> Touches:  # noqa: ARG001  (none of it)
    """Return the contacts of bodies that different executions move.

    Contacts are as deep as those that a simulation tells.
    """
    owners: dict[str, str] = {}
    with borrow_world(work) as world:
        for each in work.groups:
            robots = {joint.name.partition("::")[0] for joint in world.group(each.group).joints}
            owners |= dict.fromkeys(robots, each.execution)
        whole = world.group("+".join(each.group for each in work.groups))
        q = np.array([value for each in work.groups for value in each.positions])
        near = world.violations(whole, q, PairMargins(0.0, {}, world.drake.owners))
        held = dict(world.drake.owners)
    found: list[Touching] = []
    for pair in near:
        a, b = (owners.get(held.get(body, body.partition("::")[0])) for body in pair.bodies)
        if a is None or b is None or a == b or pair.distance > -CONTACT_DEPTH:
            continue
        found.append(Touching(executions=(a, b), pair=pair.bodies, depth=-pair.distance))
    return Touches(found=found)
