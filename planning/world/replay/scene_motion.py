"""scene_motion(): where everything in a scene is at the instants of a motion."""

import numpy as np
from jaxtyping import Float64

from planning.domain.geometry.pose import Pose
from planning.domain.robot.joints import JointGroup
from planning.domain.scene.geometry import MeshFile, SceneMotion
from planning.world.replay.replay_view import WorldView
from planning.world.replay.scene_geometry import scene_geometry, scene_mesh
from planning.world.world import World


def scene_motion(
    world: World, group: JointGroup, configurations: Float64[np.ndarray, "n nq"]
) -> SceneMotion:
    """Return what the bodies of a scene look like, and where they are as a group moves.

    Args:
        world: The scene; joints outside of the group stay at its state.
        group: The group that moves.
        configurations: Its q [rad or m], one row per instant, n >= 1.
    """
    view = WorldView(world)
    names = {shown.path: shown.name for shown in view.bodies}
    names |= {f"/frames/{frame.name}": frame.name for frame in world.scene.frames}
    poses: dict[str, list[np.ndarray]] = {names[path]: [] for path in view.moving_poses}
    tool_path: list[np.ndarray] = []
    for q in configurations:
        view.set_positions(world.embed(group, q))
        for path, pose in view.moving_poses.items():
            poses[names[path]].append(pose.GetAsMatrix4())
        if group.tool_frames:
            tool_path.append(view.tool(group))
    bodies = scene_geometry(world)
    shapes = [drawn.shape for body in bodies for drawn in body.shapes]
    digests = {shape.sha256 for shape in shapes if isinstance(shape, MeshFile)}
    return SceneMotion(
        bodies=bodies,
        fixed={
            names[path]: Pose.from_matrix(pose.GetAsMatrix4())
            for path, pose in view.poses.items()
            if names[path] not in poses
        },
        moving={name: np.stack(rows) for name, rows in poses.items()},
        tool_path=np.reshape(tool_path, (-1, 3)),
        meshes={digest: scene_mesh(world, digest) or b"" for digest in sorted(digests)},
    )
