"""load_world(): load a scene into Drake as a World, ready for queries."""

from planning.domain.scene.scene import Scene
from planning.errors import ProblemInvalid, SceneInvalid, UnknownName
from planning.world.collision.box_pairs import box_pairs_of
from planning.world.collision.half_spaces import has_moving_half_space
from planning.world.collision.near_static import NearStatic
from planning.world.collision.unchecked_pairs import unchecked_pairs
from planning.world.contexts import shared_context
from planning.world.drake_model import DrakeModel
from planning.world.files.stored_scene import StoredScene, store_files
from planning.world.kernel.kernel_scene import kernel_scene_of
from planning.world.kernel.kernel_tree import kernel_chain
from planning.world.loading.builder import build_diagram
from planning.world.loading.model_reuse import copied_model, keep_model, reuse_model
from planning.world.loading.scene_build import LoadedRobot
from planning.world.loading.static_build import static_object_names
from planning.world.mechanics.grippers import require_gripper
from planning.world.models.model_library import ModelLibrary
from planning.world.world import World

# Groups whose checkers are made at once; those of others are made at their first use.
_MAX_PREPARED_GROUPS = 4
# Objects that are registered with Drake in advance: 0.1 ms each.
_MAX_REGISTERED = 24
# Without the kernel: Drake's tables have a row for every pair of shapes, and so has each context.
MAX_OBJECTS_FOR_DRAKE = 1_000


def load_world(
    scene: Scene,
    library: ModelLibrary | None = None,
    *,
    kernel: bool = True,
    previous: World | None = None,
    all_in_drake: bool = False,
) -> World:
    """Load a scene into Drake.

    Everything is made from copies of the files that the scene names: those in its `files`, and the
    present content of the disk for the others. The world's own `scene` has all of them, so loading
    that again gives the same world, independent of later changes of the disk.

    Args:
        scene: The scene.
        library: Library of robots; None for those that come with Wayproof.
        kernel: Whether the native kernel may decide collisions where it is certain; the results are
            Drake's either way.
        previous: A loaded world to reuse, such as that of the scene before an edit, or of another
            scene with the same robots: common parts are not loaded again but shared, so both belong
            to one thread.
        all_in_drake: Whether Drake's model has the objects that are fixed to the world too, but for
            half spaces, for those who ask Drake alone; else they are kept outside of it, with the
            same results.

    Raises:
        SceneInvalid: A name in the scene is wrong; evidence has its `path`.
        AssetNotFound: A file does not exist.
        ModelInvalid: A robot's description is unsafe or does not load.
        UnknownName: There is no such robot.
    """
    chosen = library or ModelLibrary.bundled()
    stored = store_files(scene, chosen)
    with stored.original_names_in_errors():
        static_names = (
            static_object_names(stored.scene) if kernel and not all_in_drake else frozenset[str]()
        )
        shared = reuse_model(stored, static_names, previous, kernel=kernel)
        world = World(
            stored.scene, chosen, *(shared or _build(stored, static_names, kernel=kernel))
        )
        _validate_margin_bodies(stored.scene, world.drake)
        _validate_grips(world)
        if previous is None or not world.has_objects_of(previous):
            _precompute(world)
        return world


def _build(
    stored: StoredScene, static_names: frozenset[str], *, kernel: bool
) -> tuple[DrakeModel, tuple[LoadedRobot, ...]]:
    """Return the scene in Drake; static objects stay outside if the kernel has their shapes."""
    if static_names:
        copied = copied_model(stored, static_names, kernel=kernel)
        if copied is not None:
            return copied
        model, robots = build_diagram(stored, static_names, kernel=kernel)
        if kernel_scene_of(model) is not None and not has_moving_half_space(model):
            keep_model(stored, static_names, model, robots)
            return model, robots
    _validate_num_objects(stored.scene)
    return build_diagram(stored, kernel=kernel)


def _validate_num_objects(scene: Scene) -> None:
    count = len(scene.objects)
    if count > MAX_OBJECTS_FOR_DRAKE:
        message = (
            f"objects: {count} objects exceed the limit of {MAX_OBJECTS_FOR_DRAKE} for scenes that "
            "only Drake can check; the native kernel has no such limit, but it needs joints and "
            "shapes of supported types and no moving half spaces"
        )
        evidence = {"path": "objects", "count": count, "bound": MAX_OBJECTS_FOR_DRAKE}
        raise SceneInvalid(message, evidence)


def _precompute(world: World) -> None:
    """Compute in advance the caches that the first queries need."""
    shared_context(world.drake)
    world.drake.static_objects.precompute()
    if len(world.drake.static_objects) <= _MAX_REGISTERED:
        NearStatic.shared(world.drake).register(range(len(world.drake.static_objects)))
    unchecked_pairs(world.drake)
    box_pairs_of(world.drake)
    for group in world.groups[:_MAX_PREPARED_GROUPS]:
        world.limits(group)
        world.collision_oracle(group, world.margins())
        if group.tool_frames:
            kernel_chain(world.drake, group, world.state, group.tool_frames[0])


def _validate_grips(world: World) -> None:
    """Raise unless everything that holds an object by contact is a gripper."""
    for i, thing in enumerate(world.scene.objects):
        grip = None if thing.attached is None else thing.attached.grip
        if grip is None:
            continue
        try:
            require_gripper(world, world.group(grip.gripper))
        except (UnknownName, ProblemInvalid) as fault:
            path = f"objects.{i}.attached.grip.gripper"
            raise SceneInvalid(
                f"{path}: {fault.detail}", {"path": path, **fault.evidence}
            ) from None


def _validate_margin_bodies(scene: Scene, model: DrakeModel) -> None:
    """Raise unless all bodies in the scene's margins exist."""
    for i, entry in enumerate(scene.margins):
        for body in entry.bodies:
            if body not in model.all_bodies:
                fault = UnknownName.among("body", body, model.all_bodies)
                path = f"margins.{i}.bodies"
                raise SceneInvalid(f"{path}: {fault.detail}", {"path": path, **fault.evidence})
