"""load_world(): load a scene into Drake as a World, ready for queries."""

from planning.domain.scene.scene import Scene
from planning.errors import SceneInvalid, UnknownName
from planning.world.collision.box_pairs import box_pairs_of
from planning.world.collision.half_spaces import has_half_space_that_moves
from planning.world.collision.unchecked_pairs import unchecked_pairs
from planning.world.contexts import shared_context
from planning.world.drake_model import DrakeModel
from planning.world.files.keep_files import KeptScene, keep_files
from planning.world.kernel.kernel_scene import kernel_scene_of
from planning.world.kernel.kernel_tree import kernel_chain
from planning.world.loading.builder import build_diagram
from planning.world.loading.reuse import reused
from planning.world.loading.scene_build import LoadedRobot
from planning.world.loading.static_build import MOST_IN_MODEL, standing_names
from planning.world.models.model_library import ModelLibrary
from planning.world.world import World

# Groups whose checkers are made at once; those of others are made at their first use.
_MOST_READY = 4
# Without the kernel: Drake's tables have a row for every pair of shapes, and so has each context.
MOST_FOR_DRAKE = 1_000


def load_world(
    scene: Scene,
    library: ModelLibrary | None = None,
    *,
    kernel: bool = True,
    like: World | None = None,
    most_in_model: int = MOST_IN_MODEL,
) -> World:
    """Load a scene into Drake.

    Everything is made from copies of the files that the scene names: those in its `files`,
    and the present content of the disk for the others. The world's own `scene` has all of them,
    so loading that again gives the same world, independent of later changes of the disk.

    Args:
        scene: The scene.
        library: Library of robots; None for those that come with Wayproof.
        kernel: Whether the native kernel may decide collisions where it is certain; the results are
            Drake's either way.
        like: A loaded world to reuse, such as that of the scene before an edit: common parts
            are not loaded again but shared, so both belong to one thread.
        most_in_model: Largest number of objects that stand in the world within Drake's model; if
            there are more, all of them stand outside of it, with the same results.

    Raises:
        SceneInvalid: A name in the scene is wrong; evidence has its `path`.
        AssetNotFound: A file does not exist.
        ModelInvalid: A robot's description is unsafe or does not load.
        UnknownName: There is no such robot.
    """
    chosen = library or ModelLibrary.bundled()
    kept = keep_files(scene, chosen)
    with kept.faults_as_found():
        names = standing_names(kept.scene, most_in_model) if kernel else frozenset[str]()
        shared = reused(kept, names, like, kernel=kernel)
        world = World(kept.scene, chosen, *(shared or _built(kept, names, kernel=kernel)))
        _require_bodies(kept.scene, world.drake)
        if shared is None:
            _make_ready(world)
        return world


def _built(
    kept: KeptScene, names: frozenset[str], *, kernel: bool
) -> tuple[DrakeModel, tuple[LoadedRobot, ...]]:
    """Return the scene in Drake; static objects stay outside if the kernel has their shapes."""
    if names:
        model, robots = build_diagram(kept, names, kernel=kernel)
        if kernel_scene_of(model) is not None and not has_half_space_that_moves(model):
            return model, robots
    _require_bearable(kept.scene)
    return build_diagram(kept, kernel=kernel)


def _require_bearable(scene: Scene) -> None:
    count = len(scene.objects)
    if count > MOST_FOR_DRAKE:
        message = f"objects: there are {count}, and Drake alone bears {MOST_FOR_DRAKE}: more need "
        message += "the native kernel, and robots of joints and shapes that it knows, without half "
        message += "spaces that move"
        evidence = {"path": "objects", "count": count, "bound": MOST_FOR_DRAKE}
        raise SceneInvalid(message, evidence)


def _make_ready(world: World) -> None:
    """Compute now what the first queries would wait for."""
    shared_context(world.drake)
    world.drake.standing.make_ready()
    unchecked_pairs(world.drake)
    box_pairs_of(world.drake)
    for group in world.groups[:_MOST_READY]:
        world.limits(group)
        world.collision_oracle(group, world.margins())
        if group.tool_frames:
            kernel_chain(world.drake, group, world.state, group.tool_frames[0])


def _require_bodies(scene: Scene, model: DrakeModel) -> None:
    """Raise unless all bodies in the scene's margins exist."""
    for i, entry in enumerate(scene.margins):
        for body in entry.bodies:
            if body not in model.all_bodies:
                fault = UnknownName.among("body", body, model.all_bodies)
                path = f"margins.{i}.bodies"
                raise SceneInvalid(f"{path}: {fault.detail}", {"path": path, **fault.evidence})
