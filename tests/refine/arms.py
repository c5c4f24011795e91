"""Two arms with loads to try: bounds of a group under limits besides those of its joints."""

import numpy as np

from planning.domain.curves.path import JointPath
from planning.domain.request.constraint import PlacedBox
from planning.domain.request.motion_limits import MotionLimits, SpeedZone, ToolLimit
from planning.domain.request.options import RefineOptions
from planning.domain.robot.joints import JointGroup
from planning.domain.robot.payload import Payload
from planning.refine.constraints.rate_bounds import RateBounds
from planning.refine.constraints.request_bounds import request_bounds
from planning.refine.request import RefineRequest
from planning.world.world import World
from tests.conftest import bundled_world

ARMS = {
    "ur5e": ("ur5e_pickup", "arm", "arm::tcp", 7.5),
    "panda": ("panda_shelf", "panda", "panda::panda_hand_tcp", 2.5),
}
KINDS = ("torque", "speed", "acceleration", "both", "zone")


def arm_of(name: str) -> tuple[World, JointGroup]:
    scene, group, _, _ = ARMS[name]
    world = bundled_world(scene)
    return world, world.group(group)


def limits_of(name: str, kind: str) -> MotionLimits:
    _, _, frame, mass = ARMS[name]
    world, _ = arm_of(name)
    about = world.frame_pose(frame, world.state)
    zone = SpeedZone("slow", frame, PlacedBox(np.array([0.25, 0.2, 0.3]), about), 0.2)
    carried = Payload.from_parts(frame, mass, (0.0, 0.0, 0.05))
    return {
        "torque": MotionLimits(limits_effort=True, payload=carried),
        "speed": MotionLimits((ToolLimit(frame, speed=0.4),)),
        "acceleration": MotionLimits((ToolLimit(frame, acceleration=1.5),)),
        "both": MotionLimits((ToolLimit(frame, speed=0.5, acceleration=2.0),)),
        "zone": MotionLimits(speed_zones=(zone,)),
    }[kind]


def request_of(
    world: World, path: JointPath, others: MotionLimits, **more: object
) -> RefineRequest:
    limits = world.limits(path.group)
    options = RefineOptions()
    return RefineRequest(path, limits, world.margins(), options, motion_limits=others, **more)


def bounds_under(name: str, others: MotionLimits) -> RateBounds:
    world, group = arm_of(name)
    still = world.positions(group)
    return request_bounds(
        world, request_of(world, JointPath(group, np.stack([still, still])), others)
    )


def curve_points(name: str, rng: np.random.Generator, count: int = 10) -> np.ndarray:
    """Return control points of a curve that bends, about where the scene has the arm."""
    world, group = arm_of(name)
    steps = 0.5 * rng.normal(size=len(group.joints)) + 0.15 * rng.normal(
        size=(count, len(group.joints))
    )
    return world.positions(group) + np.cumsum(steps / count**0.5 * 0.4, axis=0)
