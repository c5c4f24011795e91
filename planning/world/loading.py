"""load_world(): from a scene to a world that is ready for questions."""

from planning.domain.scene import Scene
from planning.errors import SceneInvalid, UnknownName
from planning.world.builder import build_diagram
from planning.world.contexts import shared_context
from planning.world.kernel_tree import kernel_chain
from planning.world.model_library import ModelLibrary
from planning.world.world import World


def load_world(scene: Scene, library: ModelLibrary | None = None, *, kernel: bool = True) -> World:
    """Load a scene into Drake.

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
    drake, robots = build_diagram(scene, chosen, kernel=kernel)
    world = World(scene, chosen, drake, robots)
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
