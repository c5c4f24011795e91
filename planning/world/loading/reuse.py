"""Reuse of a loaded world's Drake model for a scene that differs only in poses and positions.

Drake's model depends on the robots and on the attached objects. The poses of all other objects
are in our own tables, and robot positions are a state: neither is in the model.
"""

from collections.abc import Sequence
from dataclasses import replace

from planning.domain.scene.scene import Scene, SceneFrame, SceneObject
from planning.domain.value import digest
from planning.world.collision.shape_pairs import share_candidates
from planning.world.collision.unchecked_pairs import share_unchecked
from planning.world.drake_model import DrakeModel
from planning.world.files.keep_files import KeptScene
from planning.world.kernel.kernel_scene import share_kernel_scene
from planning.world.loading.scene_build import LoadedRobot
from planning.world.loading.start_warnings import share_start_warnings
from planning.world.loading.static_build import standing_frames, transforms
from planning.world.world import World


def reused(
    kept: KeptScene, names: frozenset[str], like: World | None, *, kernel: bool
) -> tuple[DrakeModel, tuple[LoadedRobot, ...]] | None:
    """Return the model of a loaded world with objects moved, and its robots.

    None if the scenes differ in more than the poses, positions and colors of robots and of
    objects outside of Drake's model.

    Args:
        kept: The scene, with its files.
        names: The objects that stand outside of Drake's model.
        like: The loaded world.
        kernel: Whether the native kernel may decide collisions.
    """
    if like is None or like.drake.uses_kernel != kernel:
        return None
    before, standing = like.drake, like.drake.standing
    if len(names) != len(standing) or _rest(kept.scene, names) != _rest(like.scene, names):
        return None
    things = [thing for thing in kept.scene.objects if thing.name in names]
    if kept.meshes:
        things = list(map(kept.thing, things))
    if not _are_same(things, standing.things):
        return None
    robots = tuple(
        replace(loaded, scene_robot=robot)
        for loaded, robot in zip(like.loaded_robots, kept.scene.robots, strict=True)
    )
    return _moved(before, things, kept.scene.frames), robots


def _rest(scene: Scene, names: frozenset[str]) -> str:
    """Return the digest of all inputs of Drake's model."""
    return digest((
        [replace(robot, positions=None) for robot in scene.robots],
        [thing for thing in scene.objects if thing.name not in names],
        [(frame.name, frame.parent, frame.pose) for frame in scene.frames],
        scene.allowed_collisions,
        scene.margins,
        scene.files,
    ))


def _are_same(after: Sequence[SceneObject], before: Sequence[SceneObject]) -> bool:
    """Return whether objects are equal except for poses and colors."""
    if len(after) != len(before):
        return False
    others = [(a, b) for a, b in zip(after, before, strict=True) if a is not b]
    return all(a.name == b.name and a.shape == b.shape for a, b in others)


def _moved(
    before: DrakeModel, things: Sequence[SceneObject], frames: Sequence[SceneFrame]
) -> DrakeModel:
    """Return a model with the objects outside of it at the scene's present poses."""
    standing = before.standing
    rows = [
        row
        for row, (a, b) in enumerate(zip(things, standing.things, strict=True))
        if a is not b and a.pose is not b.pose and a.pose != b.pose
    ]
    poses = dict(zip(rows, transforms([things[row].pose for row in rows]), strict=True))
    placed = standing.placed(poses)
    after = replace(
        before, standing=standing.moved(things, poses, standing_frames(things, placed, frames))
    )
    share_candidates(before, after)
    share_unchecked(before, after)
    share_start_warnings(before, after, rows)
    share_kernel_scene(before, after, rows)
    return after
