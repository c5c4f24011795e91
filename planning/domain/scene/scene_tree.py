"""What hangs on what in a scene, as far as the scene itself says it."""

from collections.abc import Mapping
from dataclasses import dataclass

from planning.domain.geometry.pose import Pose
from planning.domain.scene.scene import Scene
from planning.domain.value import Value
from planning.errors import SceneInvalid

WORLD = "world"


@dataclass(frozen=True, eq=False)
class Hold(Value):
    """Where something of the scene hangs in the end.

    Attributes:
        root: "world", or a name that the scene does not define: a robot's `robot::link`.
        pose: X_RN, the thing in the root.
    """

    root: str
    pose: Pose

    @property
    def robot(self) -> str | None:
        """The robot whose link the root is, or None."""
        return robot_of(self.root)


def parents(scene: Scene) -> dict[str, tuple[str, Pose]]:
    """Return the parent P of every object and frame N, and X_PN."""
    objects = {
        thing.name: (thing.attached.frame if thing.attached else WORLD, thing.pose)
        for thing in scene.objects
    }
    return {**objects, **{frame.name: (frame.parent, frame.pose) for frame in scene.frames}}


def hold_of(name: str, above: Mapping[str, tuple[str, Pose]]) -> Hold:
    """Follow `parents` up from an object, a frame or a link.

    Raises:
        SceneInvalid: It hangs on itself.
    """
    pose = Pose.identity()
    for step in _way(name, above):
        name, x_pn = above[step]
        pose = x_pn @ pose
    return Hold(name, pose)


def holder_of(name: str, above: Mapping[str, tuple[str, Pose]]) -> str | None:
    """Return the robot that an object, a frame or a link hangs on in the end, or None.

    Raises:
        SceneInvalid: It hangs on itself.
    """
    way = _way(name, above)
    return robot_of(above[way[-1]][0] if way else name)


def robot_of(root: str) -> str | None:
    """Return the robot of a link, by its full name; None of what is no link."""
    robot, has_robot, _ = root.partition("::")
    return robot if has_robot else None


def _way(name: str, above: Mapping[str, tuple[str, Pose]]) -> list[str]:
    """Return what hangs on what, from a name on, as far as the scene says it."""
    seen: dict[str, None] = {}
    while name in above:
        if name in seen:
            way = list(seen)
            message = f"{way[0]!r} hangs on itself: {[*way, name]}"
            raise SceneInvalid(message, {"path": "", "names": [*way, name]})
        seen[name] = None
        name = above[name][0]
    return list(seen)
