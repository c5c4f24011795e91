"""Motion: a planned motion as keyframes that can be drawn at any time."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from service.studio.api import Api, Array, ShownGroup

# Keyframes of a motion: between them bodies are interpolated.
_MAX_KEYFRAMES = 240
# Of the colours of the trace: red where something is as near as this [m], green beyond the other.
_NEAR, _FAR = 0.0, 0.05
_RED, _AMBER, _GREEN = np.array([230, 57, 70]), np.array([255, 183, 3]), np.array([42, 157, 143])


@dataclass(frozen=True)
class Motion:
    """A motion in a scene.

    Attributes:
        plan: Id of its plan.
        times: Of the keyframes [s], shape (n,), n >= 2.
        positions: Of the group, shape (n, nq).
        velocities: Of the group, shape (n, nv).
        poses: X_WB of the moving bodies, by name, shape (n, 7).
        tool: p_WT of the tool [m], shape (n, 3); None without one.
        certificate: As the API has it.
        names: Of the positions, without the robot's.
    """

    plan: str
    times: Array
    positions: Array
    velocities: Array
    poses: Mapping[str, Array]
    tool: Array | None
    certificate: Mapping[str, Any]
    names: Sequence[str]

    @property
    def duration(self) -> float:
        """From start to end [s]."""
        return float(self.times[-1])

    def at(self, time: float) -> dict[str, Array]:
        """Return X_WB of the moving bodies at a time."""
        row = float(np.interp(time, self.times, np.arange(len(self.times))))
        return {name: _between(poses, row) for name, poses in self.poses.items()}


def load_motion(
    api: Api, scene: str, group: ShownGroup, job: Mapping[str, Any], bodies: Sequence[str]
) -> Motion:
    """Return the motion of a plan that succeeded.

    Args:
        api: Says where bodies are.
        scene: That it moves in.
        group: That moves.
        job: The plan, with its result.
        bodies: That move.
    """
    trajectory = job["result"]["trajectory"]
    rows = np.unique(
        np.linspace(
            0, len(trajectory["times"]) - 1, min(_MAX_KEYFRAMES, len(trajectory["times"]))
        ).round()
    ).astype(int)
    positions = np.array(trajectory["positions"])[rows]
    tools = group.tool_frames[:1]
    poses = api.poses(scene, group.name, positions, [*bodies, *tools])
    tool = poses.pop(tools[0])[:, :3] if tools and tools[0] not in bodies else None
    return Motion(
        plan=job["id"],
        times=np.array(trajectory["times"])[rows],
        positions=positions,
        velocities=np.array(trajectory["velocities"])[rows],
        poses=poses,
        tool=tool,
        certificate=job["result"]["certificate"],
        names=[name.rpartition("::")[2] for name in group.position_names],
    )


def clearance_colors(clearance: Array) -> Array:
    """Return colours from red (touches) over amber to green (far), shape (n, 3)."""
    share = np.clip((clearance - _NEAR) / (_FAR - _NEAR), 0.0, 1.0)[:, None]
    low = _RED + (_AMBER - _RED) * np.minimum(1.0, 2 * share)
    return np.where(share < 0.5, low, _AMBER + (_GREEN - _AMBER) * (2 * share - 1))


def _between(poses: Array, row: float) -> Array:
    """Return a pose between two rows: positions and normalised quaternions, linearly."""
    i = min(int(row), len(poses) - 2)
    first, second, share = poses[i], poses[i + 1], row - i
    turned = second[3:] if first[3:] @ second[3:] >= 0 else -second[3:]
    quaternion = (1 - share) * first[3:] + share * turned
    position = (1 - share) * first[:3] + share * second[:3]
    return np.concatenate([position, quaternion / np.linalg.norm(quaternion)])
