"""Keyframes: where bodies are along a planned motion, as can be drawn at any time."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from service.studio.api import Api, ShownGroup
from service.studio.numbers import Array

# Of a motion: between them bodies are interpolated.
_MAX_KEYFRAMES = 240


@dataclass(frozen=True)
class Keyframes:
    """A motion in a scene, as it is seen.

    Attributes:
        plan: Id of its plan.
        times: Of the keyframes [s], shape (n,), n >= 2.
        positions: Of the group, shape (n, nq).
        poses: X_WB of bodies, by name, shape (n, 7).
        tool: p_WT of the tool [m], shape (n, 3); None without one.
    """

    plan: str
    times: Array
    positions: Array
    poses: Mapping[str, Array]
    tool: Array | None

    @property
    def duration(self) -> float:
        """From start to end [s]."""
        return float(self.times[-1])

    def at(self, time: float) -> dict[str, Array]:
        """Return X_WB of the bodies at a time; before the start and after the end it rests."""
        row = float(np.interp(time, self.times, np.arange(len(self.times))))
        return {name: _between(poses, row) for name, poses in self.poses.items()}


def load_keyframes(
    api: Api, scene: str, group: ShownGroup, job: Mapping[str, Any], bodies: Sequence[str]
) -> Keyframes:
    """Return the keyframes of a plan that succeeded.

    Args:
        api: Says where bodies are.
        scene: That it moves in.
        group: That moves.
        job: The plan, with its result.
        bodies: That move.
    """
    trajectory = job["result"]["trajectory"]
    num = len(trajectory["times"])
    rows = np.unique(np.linspace(0, num - 1, min(_MAX_KEYFRAMES, num)).round()).astype(int)
    positions = np.array(trajectory["positions"])[rows]
    tools = group.tool_frames[:1]
    poses = api.poses(scene, group.name, positions, [*bodies, *tools])
    return Keyframes(
        plan=job["id"],
        times=np.array(trajectory["times"])[rows],
        positions=positions,
        tool=poses.pop(tools[0])[:, :3] if tools and tools[0] not in bodies else None,
        poses=poses,
    )


def _between(poses: Array, row: float) -> Array:
    """Return a pose between two rows: positions and normalised quaternions, linearly."""
    i = min(int(row), len(poses) - 2)
    first, second, share = poses[i], poses[i + 1], row - i
    turned = second[3:] if first[3:] @ second[3:] >= 0 else -second[3:]
    quaternion = (1 - share) * first[3:] + share * turned
    position = (1 - share) * first[:3] + share * second[:3]
    return np.concatenate([position, quaternion / np.linalg.norm(quaternion)])
