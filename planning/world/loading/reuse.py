"""reused(): the engine of a world that is loaded already, for a scene that differs in little.

Drake's model depends on robots and on what they hold. Where everything else stands are tables of
ours, and where robots stand is a state: neither is in the model.
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
    """Return the model of a world with objects elsewhere, and its robots.

    None if the scenes differ in more than where robots and objects outside of Drake's model stand,
    and how these look.

    Args:
        kept: The scene, with its files.
        names: The objects that stand outside of Drake's model.
        like: A world that is loaded.
        kernel: Whether the native kernel may answer.
    """
    if like is None or like.drake.uses_kernel != kernel:
        return None
    before, standing = like.drake, like.drake.standing
    if len(names) != len(standing) or _rest(kept.scene, names) != _rest(like.scene, names):
        return None
    things = [kept.thing(thing) for thing in kept.scene.objects if thing.name in names]
    if not _are_same(things, standing.things):
        return None
    robots = tuple(
        replace(loaded, scene_robot=robot)
        for loaded, robot in zip(like.loaded_robots, kept.scene.robots, strict=True)
    )
    return _moved(before, things, kept.scene.frames), robots


def _rest(scene: Scene, names: frozenset[str]) -> str:
    """Return the digest of all that Drake's model is made of."""
    return digest((
        [replace(robot, positions=None) for robot in scene.robots],
        [thing for thing in scene.objects if thing.name not in names],
        [(frame.name, frame.parent, frame.pose) for frame in scene.frames],
        scene.allowed_collisions,
        scene.margins,
        scene.files,
    ))


def _are_same(after: Sequence[SceneObject], before: Sequence[SceneObject]) -> bool:
    """Return whether objects are the same but for where they stand and how they look."""
    return len(after) == len(before) and all(
        a is b or (a.name == b.name and a.shape == b.shape)
        for a, b in zip(after, before, strict=True)
    )


def _moved(
    before: DrakeModel, things: Sequence[SceneObject], frames: Sequence[SceneFrame]
) -> DrakeModel:
    """Return a model with what stands outside of it where the scene says now."""
    standing = before.standing
    rows = [
        row
        for row, (a, b) in enumerate(zip(things, standing.things, strict=True))
        if a.pose is not b.pose and a.pose != b.pose
    ]
    poses = dict(zip(rows, transforms([things[row].pose for row in rows]), strict=True))
    placed = [poses.get(row, x) for row, x in enumerate(standing.poses)]
    after = replace(
        before, standing=standing.moved(things, poses, standing_frames(things, placed, frames))
    )
    share_candidates(before, after)
    share_unchecked(before, after)
    share_start_warnings(before, after, rows)
    share_kernel_scene(before, after, rows)
    return after
