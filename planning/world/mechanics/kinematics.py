"""Forward kinematics of frames."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float64

from planning.domain.geometry.pose import Pose
from planning.world.loading.positions import validate_positions
from planning.world.world import World


def forward_kinematics(
    world: World,
    group: str,
    configurations: Float64[np.ndarray, "n nq"],
    frames: Sequence[str] = (),
) -> tuple[dict[str, Pose], ...]:
    """Return X_WF of some frames at each configuration of a group.

    Args:
        world: The scene, loaded.
        group: `robot` or `robot::group`.
        configurations: The group's q [rad or m], a row each.
        frames: Full names; none for the group's tool frames.

    Raises:
        UnknownName: There is no such group or frame.
        ProblemInvalid: A row has the wrong count or is not finite.
    """
    joints = world.group(group)
    frame_names = tuple(frames) or joints.tool_frames
    poses: list[dict[str, Pose]] = []
    for i, row in enumerate(configurations):
        full = world.embed(joints, validate_positions(joints, row, f"configurations.{i}"))
        poses.append({frame: world.frame_pose(frame, full) for frame in frame_names})
    return tuple(poses)
