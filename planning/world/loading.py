"""load_world(): from a scene to a world that is ready for questions."""

from planning.domain.scene import Scene
from planning.errors import SceneInvalid, UnknownName
from planning.world.builder import build_diagram
from planning.world.contexts import shared_context
from planning.world.keep_files import KeptScene, keep_files
from planning.world.kernel_tree import kernel_chain
from planning.world.model_library import ModelLibrary
from planning.world.world import World


def load_world(scene: Scene, library: ModelLibrary | None = None, *, kernel: bool = True) -> World:
    """Load a scene into Drake.

    Everything is made from copies of the files that the scene names: those that its `files` say,
    and what is on the disk now where they say nothing. The world's own `scene` says all of them,
    so loading that again gives the same world, whatever has become of the disk.

    Args:
        scene: What to load.
        library: Where robots are found; None for those that come with Wayproof.
        kernel: Whether the native kernel may answer where it is sure; the answers are Drake's
            either way.

    Raises:
        SceneInvalid: A name in the scene is wrong; evidence has its `path`.
        AssetNotFound: A file is not there.
        ModelInvalid: A robot's description is unsafe or does not load.
        UnknownName: There is no such robot.
    """
    chosen = library or ModelLibrary.bundled()
    kept = keep_files(scene, chosen)
    with kept.faults_as_found():
        return _loaded(kept, chosen, kernel=kernel)


def _loaded(kept: KeptScene, library: ModelLibrary, *, kernel: bool) -> World:
    scene = kept.scene
    drake, robots = build_diagram(kept, kernel=kernel)
    world = World(scene, library, drake, robots)
    # Now, rather than in the first plan.
    shared_context(drake)
    for group in world.groups:
        world.limits(group)
        world.collision_oracle(group, world.margins())
        if group.tool_frames:
            kernel_chain(drake, group, world.state, group.tool_frames[0])
    for i, entry in enumerate(scene.margins):
        for body in entry.bodies:
            if body not in drake.bodies:
                fault = UnknownName.among("body", body, drake.bodies)
                path = f"margins.{i}.bodies"
                raise SceneInvalid(f"{path}: {fault.detail}", {"path": path, **fault.evidence})
    return world
