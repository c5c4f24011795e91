"""Loads: limits beside those of single joints, under which the same problems are planned.

`torque` limits joint torques to the model's, with 1 kg in the tool; `tool` limits the tool's speed
to 1 m/s, `zone` to 0.5 m/s in a box before the robot; `all` is the three at once.
"""

from typing import Literal, get_args

import numpy as np

import planning
from benchmarks.motion_bench_maker.robots import RobotSpec

type Load = Literal["none", "torque", "tool", "zone", "all"]

LOADS: tuple[Load, ...] = get_args(Load.__value__)
_PAYLOAD = 1.0
_TOOL_SPEED = 1.0
_ZONE_SPEED = 0.5
# Edges and centre of the box, in the world [m].
_ZONE_SIZE, _ZONE_CENTER = (0.6, 2.0, 2.0), (0.7, 0.0, 0.5)


def retime_options(spec: RobotSpec, load: Load) -> planning.RetimeOptions:
    """Return a plan's limits under a load, by the method of timing that the robot's limits need."""
    tool = f"robot::{spec.tool}"
    limits_tool, has_zone = load in {"tool", "all"}, load in {"zone", "all"}
    has_torque = load in {"torque", "all"}
    return planning.RetimeOptions(
        "ruckig" if spec.jerk else "toppra",
        tool_limits=(planning.ToolLimit(tool, speed=_TOOL_SPEED),) if limits_tool else (),
        speed_zones=(_zone(tool),) if has_zone else (),
        effort=has_torque,
        payload=planning.Payload(tool, _PAYLOAD) if has_torque else None,
    )


def _zone(tool: str) -> planning.SpeedZone:
    box = planning.PlacedBox(np.array(_ZONE_SIZE), planning.Pose.from_parts(_ZONE_CENTER))
    return planning.SpeedZone("near", tool, box, _ZONE_SPEED)
