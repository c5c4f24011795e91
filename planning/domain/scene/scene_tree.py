"""Scene tree: parents of objects and frames, as far as the scene itself defines them."""

from collections.abc import Mapping
from dataclasses import dataclass

from planning.domain.geometry.pose import Pose
from planning.domain.scene.scene import Scene
from planning.domain.value import Value
from planning.errors import SceneInvalid

WORLD = "world"


@dataclass(frozen=True, eq=False)
class RootAncestor(Value):
    """Root ancestor of an object or frame, with its pose in it.

    Attributes:
        root: "world", or a name that the scene does not define: a robot's `robot::link`.
        pose: X_RN, the object or frame N in the root R.
    """

    root: str
    pose: Pose

    @property
    def robot(self) -> str | None:
        """Robot of the root link, or None."""
        return robot_of(self.root)


def parents(scene: Scene) -> dict[str, tuple[str, Pose]]:
    """Return the parent P of every object and frame N, and X_PN."""
    objects = {
        thing.name: (thing.attached.frame if thing.attached else WORLD, thing.pose)
        for thing in scene.objects
    }
    return {**objects, **{frame.name: (frame.parent, frame.pose) for frame in scene.frames}}


def root_ancestor(name: str, parent_of: Mapping[str, tuple[str, Pose]]) -> RootAncestor:
    """Return the root ancestor of an object, a frame or a link, by following `parents`.

    Raises:
        SceneInvalid: It is its own ancestor.
    """
    pose = Pose.identity()
    for step in _ancestors(name, parent_of):
        name, x_pn = parent_of[step]
        pose = x_pn @ pose
    return RootAncestor(name, pose)


def root_robot(name: str, parent_of: Mapping[str, tuple[str, Pose]]) -> str | None:
    """Return the robot that is the root ancestor of an object, a frame or a link, or None.

    Raises:
        SceneInvalid: It is its own ancestor.
    """
    ancestors = _ancestors(name, parent_of)
    return robot_of(parent_of[ancestors[-1]][0] if ancestors else name)


def robot_of(root: str) -> str | None:
    """Return the robot of a link by the link's full name; None for any other name."""
    robot, has_robot, _ = root.partition("::")
    return robot if has_robot else None


def _ancestors(name: str, parent_of: Mapping[str, tuple[str, Pose]]) -> list[str]:
    """Return the chain of ancestors from a name on, as far as the scene defines it."""
    seen: dict[str, None] = {}
    while name in parent_of:
        if name in seen:
            names = list(seen)
            message = f"the parents of {names[0]!r} form a cycle: {[*names, name]}"
            raise SceneInvalid(message, {"path": "", "names": [*names, name]})
        seen[name] = None
        name = parent_of[name][0]
    return list(seen)
