"""Motion: a planned motion as keyframes that can be drawn at any time."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from service.studio.api import Api, ShownGroup
from service.studio.motions.series import Series
from service.studio.numbers import Array

# Keyframes of a motion: between them bodies are interpolated.
_MAX_KEYFRAMES = 240


@dataclass(frozen=True)
class Motion:
    """A motion in a scene.

    Attributes:
        plan: Id of its plan.
        times: Of the keyframes [s], shape (n,), n >= 2.
        positions: Of the group, shape (n, nq).
        poses: X_WB of the moving bodies, by name, shape (n, 7).
        tool: p_WT of the tool [m], shape (n, 3); None without one.
        certificate: As the API has it.
        series: Its rates, efforts and limits.
        job: The plan, with its request and its result.
    """

    plan: str
    times: Array
    positions: Array
    poses: Mapping[str, Array]
    tool: Array | None
    certificate: Mapping[str, Any]
    series: Series
    job: Mapping[str, Any] = field(default_factory=dict[str, Any])

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
        poses=poses,
        tool=tool,
        certificate=job["result"]["certificate"],
        series=api.series(job["id"]),
        job=job,
    )


def _between(poses: Array, row: float) -> Array:
    """Return a pose between two rows: positions and normalised quaternions, linearly."""
    i = min(int(row), len(poses) - 2)
    first, second, share = poses[i], poses[i + 1], row - i
    turned = second[3:] if first[3:] @ second[3:] >= 0 else -second[3:]
    quaternion = (1 - share) * first[3:] + share * turned
    position = (1 - share) * first[:3] + share * second[:3]
    return np.concatenate([position, quaternion / np.linalg.norm(quaternion)])
