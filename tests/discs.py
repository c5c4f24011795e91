"""Discs that slide in the plane: robots whose distances are known without any engine."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

import planning
from planning.domain.arrays import Array
from planning.domain.curves.curve import TimedTrajectory
from planning.world.world import World

RADIUS = 0.1

_LINK = """<link name="{name}"><inertial><mass value="1"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>{shape}</link>"""
_JOINT = """<joint name="{name}" type="prismatic"><parent link="{parent}"/><child link="{child}"/>
<axis xyz="{axis}"/><limit lower="-3" upper="3" velocity="4" effort="100"/></joint>"""


def discs(
    folder: Path, starts: Mapping[str, Sequence[float]], margin: float = 0.0, more: str = ""
) -> World:
    """Return a world of discs of radius `RADIUS`, each with the joints x and y."""
    shape = f'<collision><geometry><sphere radius="{RADIUS}"/></geometry></collision>'
    parts = [
        _LINK.format(name="base", shape=""),
        _LINK.format(name="slide", shape=""),
        _LINK.format(name="disc", shape=shape),
        _JOINT.format(name="x", parent="base", child="slide", axis="1 0 0"),
        _JOINT.format(name="y", parent="slide", child="disc", axis="0 1 0"),
    ]
    file = folder / "disc.urdf"
    file.write_text(f'<robot name="disc">{"".join(parts)}</robot>')
    robots = "".join(
        f"  - {{name: {name}, model: {file}, positions: [{x}, {y}]}}\n"
        for name, (x, y) in starts.items()
    )
    text = f"robots:\n{robots}margin: {margin}\n{more}"
    return planning.load_world(planning.parse_scene(text))


def straight(
    world: World, group: str, *waypoints: Sequence[float], seconds: float = 2.0
) -> TimedTrajectory:
    """Return a motion through waypoints that rests at each, `seconds` for each straight leg.

    On each leg the share of its length is 3 u^2 - 2 u^3, with u the share of its time.
    """
    q = np.array(waypoints, dtype=np.float64)
    steps = q[1:] - q[:-1]
    coefficients = np.zeros((len(steps), 4, q.shape[1]))
    coefficients[:, 2] = 3 * steps / seconds**2
    coefficients[:, 3] = -2 * steps / seconds**3
    breaks = np.arange(len(q)) * seconds
    return TimedTrajectory(world.group(group).joints, breaks, q[:-1], coefficients)


def disc_distance(a: TimedTrajectory, b: TimedTrajectory, delay: float) -> float:
    """Return the smallest distance of two discs whose motions begin at 0 and at `delay` [m]."""
    times = np.linspace(min(0.0, delay), max(a.duration, delay + b.duration), 20_001)
    return float((np.linalg.norm(_at(a, times) - _at(b, times - delay), axis=1)).min()) - 2 * RADIUS


def _at(motion: TimedTrajectory, times: Array) -> Array:
    return motion.positions(np.clip(times, 0.0, motion.duration))
