"""close_on(): the position of a gripper at which its fingers have just reached an object."""

from dataclasses import dataclass

import numpy as np

from planning.domain.robot.gripper import Gripper
from planning.domain.robot.joints import JointGroup
from planning.domain.value import Value
from planning.errors import GraspMissed
from planning.world.mechanics.grippers import finger_bodies
from planning.world.world import World

# Steps of a search that converges geometrically, and how near the gap is near enough [m].
_MAX_STEPS, _TOLERANCE = 200, 1e-7
# From here on it does not matter how far away the object is [m].
_HORIZON = 0.05


@dataclass(frozen=True, eq=False)
class Closing(Value):
    """Where fingers have reached an object.

    Attributes:
        position: Of the gripper's joint [m].
        distances: Between the object and each finger [m], the first one's first.
    """

    position: float
    distances: tuple[float, ...]


def close_on(world: World, group: JointGroup, gripper: Gripper, name: str, gap: float) -> Closing:
    """Return where fingers that close from where they are come within a gap of an object.

    By conservative advancement (Mirtich, Impulse-based Dynamic Simulation of Rigid Body Systems,
    1996, section 2.3): no finger moves by more than the gripper's joint times its rate, so a step
    of the distance over the largest rate passes no contact on the way.

    Args:
        world: Where the object is not attached.
        group: The gripper.
        gripper: The same.
        name: Of the object.
        gap: Distance that remains between the object and the nearest finger [m].

    Raises:
        GraspMissed: No finger reaches the object.
    """
    fingers = finger_bodies(world, gripper)
    probe = world.distance_probe(world.margins())
    fastest = max(rate for rate, _ in fingers)
    position = float(world.positions(group)[0])
    distances = (np.inf,) * len(fingers)
    for _ in range(_MAX_STEPS):
        full = world.embed(group, np.array([position]))
        near = [p for p in probe.pairs_within(full, _HORIZON, exactly=True) if name in p.bodies]
        distances = tuple(
            min((pair.distance for pair in near if bodies & set(pair.bodies)), default=np.inf)
            for _, bodies in fingers
        )
        step = (min(*distances, _HORIZON) - gap) / fastest
        if step <= _TOLERANCE or position <= gripper.lower:
            break
        position = max(gripper.lower, position - step)
    if min(distances) - gap > fastest * 1e-5:
        raise _missed(name, gripper, Closing(position, distances), gap)
    return Closing(position, distances)


def require_between(gripper: Gripper, name: str, closing: Closing, reach: float) -> None:
    """Go on only if every finger has reached the object.

    Raises:
        GraspMissed: One is further away than `reach` [m].
    """
    if max(closing.distances) > reach:
        raise _missed(name, gripper, closing, reach)


def _missed(name: str, gripper: Gripper, closing: Closing, bound: float) -> GraspMissed:
    distances = [float(each) if np.isfinite(each) else None for each in closing.distances]
    width = gripper.width(closing.position)
    shown = ", ".join("far" if each is None else f"{1000 * each:.2f} mm" for each in distances)
    message = (
        f"the fingers do not hold {name!r}: {width:.4g} m apart they are {shown} from it, where "
        f"{1000 * bound:.2f} mm are allowed; bring it between them, or name another object"
    )
    evidence = {"object": name, "width": width, "distances": distances, "bound": bound}
    return GraspMissed(message, evidence)
